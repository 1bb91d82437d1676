//! Camera paths: where a viewer is over time.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use serde::Serialize;

use super::View;
use super::motion::Placement;
use super::spline::Spline;
use super::track::{Track, smooth_slopes};

/// A camera that moves, or a pair of them.
#[derive(Clone, Debug, Serialize)]
pub struct CameraPath {
    /// What configs call it.
    pub name: String,
    /// Distance between the two eyes of a stereo pair, metres; `None` for one camera.
    pub eye_distance_m: Option<f64>,
    /// Where its cameras come from.
    pub source: PathSource,
}

/// Where the cameras of a path come from.
#[derive(Clone, Debug, Serialize)]
pub enum PathSource {
    /// Key frames of its own.
    Keys(KeyedPath),
    /// A camera that something carries: where it is at rest, and how that moves.
    Carried {
        /// At rest, in the coordinates of the scene file.
        view: View,
        /// The motion that carries it.
        placement: Placement,
    },
}

/// Cameras at key frames.
///
/// Positions lie on a centripetal Catmull–Rom spline, orientations are interpolated spherically and fields
/// of view linearly between neighbouring keys. Times outside the keys hold the ends.
#[derive(Clone, Debug, Serialize)]
pub struct KeyedPath {
    keys: Vec<PathKey>,
    pace: Pace,
}

/// A key frame.
#[derive(Clone, Debug, Serialize)]
pub struct PathKey {
    /// When the camera is there.
    pub time_s: f64,
    /// Where the camera is and looks, in the coordinates of the scene file.
    pub view: View,
}

/// How fast a camera runs along its path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Pace {
    /// Each key is passed at its time; in between the speed changes smoothly.
    Keyed,
    /// The same speed everywhere from the first time to the last; times between are not used.
    Constant,
}

/// Where between two keys a camera is.
struct Stage {
    position: DVec3,
    /// Key before, and the share of the way to the next.
    key: usize,
    share: f64,
}

impl KeyedPath {
    /// A path through at least one key.
    ///
    /// # Errors
    /// A sentence and the number of the key that is at fault: times that do not ascend, keys of which some are
    /// mirrored, fields of view along different sides of the film, or, at constant speed, a key where the last was.
    pub fn new(keys: Vec<PathKey>, pace: Pace) -> Result<Self, (usize, String)> {
        let Some(first) = keys.first() else {
            return Err((0, "a path needs at least one key".into()));
        };
        for (i, key) in keys.iter().enumerate() {
            let earlier = i.checked_sub(1).map(|before| &keys[before]);
            let wrong = if earlier.is_some_and(|before| key.time_s <= before.time_s) {
                "times of keys must ascend"
            } else if key.view.fov_axis != first.view.fov_axis {
                "all keys need a field of view along the same side of the film; give `fov_deg` with `fov_axis` of \
                 the path"
            } else if is_mirrored(&key.view) != is_mirrored(&first.view) {
                "some keys have mirrored views and others do not"
            } else if pace == Pace::Constant
                && earlier.is_some_and(|before| before.view.origin == key.view.origin)
            {
                "two neighbouring keys are at the same place, which no constant speed can do"
            } else {
                continue;
            };
            return Err((i, wrong.into()));
        }
        Ok(Self { keys, pace })
    }

    fn view(&self, time_s: f64) -> View {
        let stage = self.stage(time_s);
        let from = &self.keys[stage.key].view;
        let to = &self.keys[(stage.key + 1).min(self.keys.len() - 1)].view;
        let orientation = orientation(from).slerp(orientation(to), stage.share);
        let side = if is_mirrored(from) { -1.0 } else { 1.0 };
        let mut view = from.clone();
        view.origin = stage.position;
        view.right = orientation * DVec3::X * side;
        view.up = orientation * DVec3::Y;
        view.forward = orientation * DVec3::NEG_Z;
        view.fov_deg += (to.fov_deg - from.fov_deg) * stage.share;
        view
    }

    fn stage(&self, time_s: f64) -> Stage {
        let last = self.keys.len() - 1;
        let positions = self.keys.iter().map(|key| key.view.origin).collect();
        let spline = Spline::through(positions);
        let [start, end] = self.span_s();
        if last == 0 || time_s <= start {
            return self.held(0);
        } else if time_s >= end {
            return self.held(last);
        }
        let along = match self.pace {
            Pace::Constant => spline.at_length((time_s - start) / (end - start)),
            Pace::Keyed => {
                let times: Vec<f64> = self.keys.iter().map(|key| key.time_s).collect();
                let slopes = pace_slopes(&times, spline.knots());
                let knots = spline.knots().to_vec();
                Track::cubic(times, knots, slopes).at(time_s)
            }
        };
        let next = self.keys.partition_point(|key| key.time_s <= time_s);
        // Where a camera waits, only time tells keys apart.
        let waits = self.pace == Pace::Keyed && spline.knots()[next - 1] == spline.knots()[next];
        let (key, share) = if waits {
            let [from, to] = [&self.keys[next - 1], &self.keys[next]].map(|key| key.time_s);
            (next - 1, (time_s - from) / (to - from))
        } else {
            spline.between(along)
        };
        Stage {
            position: spline.position(along),
            key,
            share,
        }
    }

    fn held(&self, key: usize) -> Stage {
        Stage {
            position: self.keys[key].view.origin,
            key,
            share: 0.0,
        }
    }

    fn span_s(&self) -> [f64; 2] {
        [self.keys[0].time_s, self.keys[self.keys.len() - 1].time_s]
    }

    /// The keys.
    pub fn keys(&self) -> &[PathKey] {
        &self.keys
    }
}

/// Slopes of the knot over time, with two keys at constant speed.
fn pace_slopes(times: &[f64], knots: &[f64]) -> Vec<[f64; 2]> {
    let slopes = match times.len() {
        2 => vec![(knots[1] - knots[0]) / (times[1] - times[0]); 2],
        _ => smooth_slopes(times, knots),
    };
    slopes.into_iter().map(|slope| [slope; 2]).collect()
}

impl CameraPath {
    /// The camera at a time; of a stereo pair the place between its eyes.
    pub fn view(&self, time_s: f64) -> View {
        let mut view = match &self.source {
            PathSource::Keys(path) => path.view(time_s),
            PathSource::Carried { view, placement } => carried(view, &placement.at(time_s)),
        };
        view.name.clone_from(&self.name);
        view
    }

    /// How many viewers look along it.
    pub fn viewers(&self) -> usize {
        match self.eye_distance_m {
            None => 1,
            Some(_) => 2,
        }
    }

    /// The cameras of all its viewers at a time: one, or left and right eye.
    pub fn views(&self, time_s: f64, metres_per_unit: f64) -> Vec<View> {
        let view = self.view(time_s);
        let Some(distance_m) = self.eye_distance_m else {
            return vec![view];
        };
        let aside = 0.5 * distance_m / metres_per_unit;
        [("left", -aside), ("right", aside)]
            .map(|(eye, aside)| View {
                name: format!("{} {eye}", self.name),
                origin: view.origin + view.right * aside,
                ..view.clone()
            })
            .into()
    }

    /// From the first key to the last, s.
    pub fn span_s(&self) -> [f64; 2] {
        match &self.source {
            PathSource::Keys(path) => path.span_s(),
            PathSource::Carried { placement, .. } => {
                let times = placement.times_s();
                let earliest = times.iter().copied().reduce(f64::min);
                let latest = times.iter().copied().reduce(f64::max);
                [earliest.unwrap_or(0.0), latest.unwrap_or(0.0)]
            }
        }
    }

    /// Of a scene that was scaled, turned and moved as a whole.
    pub(super) fn transformed(&mut self, all: DAffine3) {
        match &mut self.source {
            PathSource::Keys(path) => {
                for key in &mut path.keys {
                    key.view = carried(&key.view, &all);
                }
            }
            PathSource::Carried { view, placement } => {
                *view = carried(view, &all);
                placement.transformed(all);
            }
        }
    }
}

/// A view under an affine map: its position moved, its directions turned and made orthonormal again.
pub(super) fn carried(view: &View, map: &DAffine3) -> View {
    let forward = (map.matrix3 * view.forward).normalize_or(view.forward);
    let up = map.matrix3 * view.up;
    let up = (up - forward * forward.dot(up)).normalize_or(view.up);
    let side = if is_mirrored(view) { -1.0 } else { 1.0 };
    View {
        origin: map.transform_point3(view.origin),
        right: forward.cross(up) * side,
        up,
        forward,
        ..view.clone()
    }
}

/// Whether image right is against `forward × up`.
fn is_mirrored(view: &View) -> bool {
    view.forward.cross(view.up).dot(view.right) < 0.0
}

/// The rotation that takes x, y and −z to right (of the unmirrored view), up and forward.
fn orientation(view: &View) -> DQuat {
    let right = view.forward.cross(view.up);
    DQuat::from_mat3(&DMat3::from_cols(right, view.up, -view.forward)).normalize()
}

#[cfg(test)]
mod tests;
