//! What of a scene moves, and how.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use serde::Serialize;

use super::track::Track;

/// Shapes and lights that move or change their strength over time. Several motions of the same thing follow one
/// another: the first one listed is applied first.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MotionDescription {
    /// Indices into [`super::SceneDescription::shapes`].
    pub shapes: Vec<usize>,
    /// Indices into [`super::SceneDescription::lights`].
    pub lights: Vec<usize>,
    /// Whether the environment turns with it.
    pub environment: bool,
    /// Where its things are over time.
    pub placement: Placement,
    /// Factors of what its shapes and lights emit.
    pub strength: Vec<Track<f64>>,
}

/// Where something is over time: maps from the coordinates of the scene file to themselves, the last one applied
/// first.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Placement {
    /// The last one is applied first; without any it is at rest.
    pub links: Vec<Link>,
}

/// One of the maps of a placement.
#[derive(Clone, Debug, Serialize)]
pub enum Link {
    /// A map that stays the same.
    Fixed(DAffine3),
    /// A map that changes with time.
    Keyed(KeyedLink),
}

/// A map that changes with time: scaled and turned about the pivot, then moved.
#[derive(Clone, Debug, Default, Serialize)]
pub struct KeyedLink {
    /// `None`: the centre of the box around all that moves, see [`Placement::about`].
    pub pivot: Option<DVec3>,
    /// Factors along the axes of the scene file; `None` is 1.
    pub scale: Option<Track<DVec3>>,
    /// Applied after the scale; `None` is none.
    pub turn: Option<Turn>,
    /// Scene units, applied last; `None` is 0.
    pub translate: Option<Track<DVec3>>,
}

/// A rotation that changes with time.
#[derive(Clone, Debug, Serialize)]
pub enum Turn {
    /// By an angle about a fixed axis, right-handed.
    About {
        /// Unit.
        axis: DVec3,
        /// Not reduced to a whole turn.
        angle_rad: Track<f64>,
    },
    /// By a unit quaternion.
    Quaternion(Track<DQuat>),
}

impl Placement {
    /// The map at a time.
    pub fn at(&self, time_s: f64) -> DAffine3 {
        let maps = self.links.iter().map(|link| match link {
            Link::Fixed(map) => *map,
            Link::Keyed(keyed) => keyed.at(time_s),
        });
        maps.fold(DAffine3::IDENTITY, |all, map| all * map)
    }

    /// Whether it is the same at all times, and the identity.
    pub fn is_rest(&self) -> bool {
        self.links.is_empty()
    }

    /// Puts pivots that nobody chose where something is at rest.
    pub fn about(&mut self, mut centre: DVec3) {
        for link in self.links.iter_mut().rev() {
            match link {
                Link::Fixed(map) => centre = map.transform_point3(centre),
                Link::Keyed(keyed) => _ = keyed.pivot.get_or_insert(centre),
            }
        }
    }

    /// The same movement of a scene that was moved as a whole.
    pub(super) fn transformed(&mut self, all: DAffine3) {
        if !self.is_rest() {
            self.links.insert(0, Link::Fixed(all));
            self.links.push(Link::Fixed(all.inverse()));
        }
    }

    /// Times of its keys.
    pub fn times_s(&self) -> Vec<f64> {
        let keyed = self.links.iter().filter_map(|link| match link {
            Link::Fixed(_) => None,
            Link::Keyed(keyed) => Some(keyed),
        });
        keyed.flat_map(KeyedLink::times_s).collect()
    }
}

impl KeyedLink {
    fn at(&self, time_s: f64) -> DAffine3 {
        let of = |track: &Option<Track<DVec3>>, rest| track.as_ref().map_or(rest, |t| t.at(time_s));
        let turn = match &self.turn {
            None => DQuat::IDENTITY,
            Some(Turn::About { axis, angle_rad }) => {
                DQuat::from_axis_angle(*axis, angle_rad.at(time_s))
            }
            Some(Turn::Quaternion(track)) => track.at(time_s),
        };
        let scale = of(&self.scale, DVec3::ONE);
        let linear = DMat3::from_quat(turn) * DMat3::from_diagonal(scale);
        let pivot = self.pivot.unwrap_or(DVec3::ZERO);
        DAffine3 {
            matrix3: linear,
            translation: pivot - linear * pivot + of(&self.translate, DVec3::ZERO),
        }
    }

    fn times_s(&self) -> Vec<f64> {
        let turn = match &self.turn {
            None => &[],
            Some(Turn::About { angle_rad, .. }) => angle_rad.times_s(),
            Some(Turn::Quaternion(track)) => track.times_s(),
        };
        let moves = [&self.scale, &self.translate];
        let others = moves.into_iter().flatten().flat_map(Track::times_s);
        turn.iter().chain(others).copied().collect()
    }
}

impl MotionDescription {
    /// Where things may be farthest out: the times of the keys and some between.
    pub fn times_s(&self) -> Vec<f64> {
        const BETWEEN: usize = 16;
        let mut keys = self.placement.times_s();
        keys.sort_by(f64::total_cmp);
        keys.dedup();
        let pairs = keys.windows(2).flat_map(|pair| {
            let step = (pair[1] - pair[0]) / BETWEEN as f64;
            (1..BETWEEN).map(move |k| pair[0] + step * k as f64)
        });
        let between: Vec<f64> = pairs.collect();
        keys.extend(between);
        keys
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half_turn() -> KeyedLink {
        KeyedLink {
            pivot: Some(DVec3::new(1.0, 0.0, 0.0)),
            scale: Some(Track::step(vec![0.0], vec![DVec3::splat(2.0)])),
            turn: Some(Turn::About {
                axis: DVec3::Y,
                angle_rad: Track::linear(vec![0.0, 2.0], vec![0.0, 2.0 * std::f64::consts::TAU]),
            }),
            translate: Some(Track::linear(vec![0.0, 2.0], vec![DVec3::ZERO, DVec3::Y])),
        }
    }

    #[test]
    fn scale_then_turn_about_the_pivot_then_move() {
        let placement = Placement {
            links: vec![Link::Keyed(half_turn())],
        };
        let point = |time, p| placement.at(time).transform_point3(p);
        // Two whole turns in two seconds: a quarter of a second is a quarter turn.
        let there = point(0.25, DVec3::new(2.0, 0.0, 0.0));
        assert!(
            there.distance(DVec3::new(1.0, 0.125, -2.0)) < 1e-12,
            "{there}"
        );
        let whole = point(2.0, DVec3::new(2.0, 0.0, 0.0));
        assert!(whole.distance(DVec3::new(3.0, 1.0, 0.0)) < 1e-12, "{whole}");
    }

    #[test]
    fn the_motion_of_a_moved_scene_is_the_moved_motion() {
        let placement = Placement {
            links: vec![Link::Keyed(half_turn())],
        };
        let turn = DQuat::from_rotation_y(0.7);
        let all = DAffine3::from_scale_rotation_translation(
            DVec3::splat(3.0),
            turn,
            DVec3::new(5.0, 6.0, 7.0),
        );
        let mut moved = placement.clone();
        moved.transformed(all);
        for time in [-1.0, 0.3, 1.1, 5.0] {
            let point = DVec3::new(0.2, 0.4, -0.9);
            let expected = all.transform_point3(placement.at(time).transform_point3(point));
            let found = moved.at(time).transform_point3(all.transform_point3(point));
            assert!(found.distance(expected) < 1e-12, "{found} {expected}");
        }
    }
}
