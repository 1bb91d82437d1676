//! A similarity of a whole scene, for tests of scale, rotation and translation.

use crate::environment::EnvironmentDescription;
use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::{LightKind, SceneDescription};

impl SceneDescription {
    /// Scales, then turns about +y, then moves everything, cameras, lights and declared lengths
    /// included. Metres per unit follow where they are declared, so that lengths in metres stay what they were.
    pub fn transformed(mut self, scale: f64, rotate_y_deg: f64, translate: DVec3) -> Self {
        let turn = DQuat::from_rotation_y(rotate_y_deg.to_radians());
        let all = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, translate);
        for shape in &mut self.shapes {
            shape.to_world = DMat4::from(all) * shape.to_world;
        }
        for view in &mut self.views {
            view.origin = all.transform_point3(view.origin);
            view.right = turn * view.right;
            view.up = turn * view.up;
            view.forward = turn * view.forward;
        }
        for clip in &mut self.clips {
            clip.near *= scale;
            clip.far *= scale;
        }
        for path in &mut self.paths {
            path.transformed(all);
        }
        for motion in &mut self.motions {
            motion.placement.transformed(all);
        }
        for light in &mut self.lights {
            light.kind.transform(scale, turn, &all);
        }
        match &mut self.environment {
            Some(
                EnvironmentDescription::Map { to_world, .. }
                | EnvironmentDescription::Embedded { to_world, .. },
            ) => {
                *to_world = DMat4::from_quat(turn) * *to_world;
            }
            Some(EnvironmentDescription::SunSky {
                sun_direction,
                zenith,
                ..
            }) => {
                *sun_direction = turn * *sun_direction;
                *zenith = turned_zenith(*zenith, turn);
            }
            Some(EnvironmentDescription::Constant { .. }) | None => {}
        }
        self.ao_distance = self.ao_distance.map(|d| d * scale);
        self.metres_per_unit = self.metres_per_unit.map(|m| m / scale);
        self
    }
}

/// A zenith along +y stays there to the bit where the turn is about it.
fn turned_zenith(zenith: DVec3, turn: DQuat) -> DVec3 {
    let turned = turn * zenith;
    match turned.distance(zenith) < 1e-12 {
        true => zenith,
        false => turned.normalize(),
    }
}

impl LightKind {
    /// Intensities follow the scale, so that surfaces receive what they did.
    fn transform(&mut self, scale: f64, turn: DQuat, all: &DAffine3) {
        let squared = (scale * scale) as f32;
        match self {
            Self::Directional { direction, .. } => *direction = turn * *direction,
            Self::Point {
                position,
                intensity,
            } => {
                *position = all.transform_point3(*position);
                *intensity = intensity.map(|i| i * squared);
            }
            Self::Spot {
                position,
                direction,
                intensity,
                ..
            } => {
                *position = all.transform_point3(*position);
                *direction = turn * *direction;
                *intensity = intensity.map(|i| i * squared);
            }
        }
    }
}

impl LightKind {
    /// Takes it where a map takes its place and direction; its strength stays.
    pub(crate) fn carry(&mut self, map: &DAffine3) {
        let turned = |direction: DVec3| (map.matrix3 * direction).normalize_or(direction);
        match self {
            Self::Directional { direction, .. } => *direction = turned(*direction),
            Self::Point { position, .. } => *position = map.transform_point3(*position),
            Self::Spot {
                position,
                direction,
                ..
            } => {
                *position = map.transform_point3(*position);
                *direction = turned(*direction);
            }
        }
    }

    /// Makes it stronger by a factor.
    pub(crate) fn scale(&mut self, factor: f32) {
        match self {
            Self::Directional { irradiance, .. } => *irradiance = irradiance.map(|e| e * factor),
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => {
                *intensity = intensity.map(|i| i * factor);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::LightDescription;

    #[test]
    fn surfaces_receive_of_a_point_what_they_did() {
        let kind = LightKind::Point {
            position: DVec3::X,
            intensity: [2.0; 3],
        };
        let scene = SceneDescription {
            lights: vec![LightDescription {
                name: "lamp".into(),
                kind,
            }],
            ..SceneDescription::default()
        };
        let scene = scene.transformed(2.0, 90.0, DVec3::Y);
        let LightKind::Point {
            position,
            intensity,
        } = &scene.lights[0].kind
        else {
            panic!("a point");
        };
        assert!(position.distance(DVec3::new(0.0, 1.0, -2.0)) < 1e-12);
        assert_eq!(*intensity, [8.0; 3]);
    }
}
