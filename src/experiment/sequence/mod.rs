//! What a job sees over time: frames and viewers. A still is a sequence of one frame and one viewer.

mod animation;
mod checkpoint;
mod columns;
mod frame;
mod spec;

use glam::DQuat;
use serde::{Deserialize, Serialize};

pub use animation::{Animation, Thumbnail};
pub use checkpoint::Checkpoint;
pub use columns::{frame_column, frame_columns, is_frame_column};
pub use frame::{FrameRecord, Metrics, frames_csv};
pub use spec::{Frames, Keep, KeepWord, SequenceSpec, ViewerRule, ViewersSpec, spread};

use crate::scene::{SceneDescription, View};

/// Frames and viewers of a job, resolved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sequence {
    /// Numbers of the frames, in the order in which they are rendered.
    pub frames: Vec<u32>,
    /// Frame `n` shows the time `n / fps` seconds.
    pub fps: f64,
    /// Cameras that see each frame together.
    pub viewers: Vec<Viewer>,
    /// Where a number of viewers take the first of several paths: what these are called together, so that more viewers are
    /// another column of the same place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_of: Option<String>,
    /// How many frames at the start are not measured.
    pub warm_up: usize,
    /// Of the frames after the warm-up one in so many is measured.
    pub measure_every: usize,
    /// Frames of each so many that are measured, one after another.
    #[serde(default = "spec::one", skip_serializing_if = "spec::is_one")]
    pub measure_run: usize,
    /// Frames whose images are kept.
    pub kept: Vec<u32>,
    /// Whether each measured frame is also rendered without memory.
    pub cold: bool,
    /// Whether contenders without memory leave out frames that nobody looks at.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub skip_unmeasured: bool,
}

/// A camera of a sequence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Viewer {
    /// It stands at a view of the scene.
    View(String),
    /// It follows a path.
    Path {
        /// Name of the path: one of the scene, or of the config.
        name: String,
        /// Of a stereo pair 0 is the left one.
        eye: usize,
        /// Degrees to the right about its own up.
        turn_deg: f64,
    },
}

impl Default for Sequence {
    /// A still of a view without a name.
    fn default() -> Self {
        Self::still("")
    }
}

impl Sequence {
    /// One picture of a view, at the time 0.
    pub fn still(view: &str) -> Self {
        Self {
            frames: vec![0],
            fps: 1.0,
            viewers: vec![Viewer::View(view.to_owned())],
            warm_up: 0,
            measure_every: 1,
            first_of: None,
            measure_run: 1,
            kept: vec![0],
            cold: false,
            skip_unmeasured: false,
        }
    }

    /// Whether it is one picture at the time 0.
    pub fn is_still(&self) -> bool {
        self.frames == [0] && matches!(self.viewers[..], [Viewer::View(_)])
    }

    /// Images in all.
    pub fn images(&self) -> usize {
        self.frames.len() * self.viewers.len()
    }

    /// The time of a frame.
    pub fn time_s(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps
    }

    /// Whether a frame is measured, by its place among the frames.
    pub fn is_measured(&self, place: usize) -> bool {
        place >= self.warm_up && (place - self.warm_up) % self.measure_every < self.measure_run
    }

    /// Whether a frame is measured or its image kept, by its place among the frames.
    pub fn is_looked_at(&self, place: usize) -> bool {
        self.is_measured(place) || self.kept.contains(&self.frames[place])
    }

    /// Numbers of the measured frames.
    pub fn measured(&self) -> impl Iterator<Item = u32> {
        let placed = self.frames.iter().enumerate();
        placed
            .filter(|(place, _)| self.is_measured(*place))
            .map(|(_, frame)| *frame)
    }

    /// The measured frame that stands for all where there is room for one: that in their middle.
    pub fn representative(&self) -> u32 {
        let measured: Vec<u32> = self.measured().collect();
        measured[measured.len() / 2]
    }

    /// Who looks, for rows and tables.
    pub fn place(&self) -> String {
        if let Some(paths) = &self.first_of {
            return paths.clone();
        }
        let mut names: Vec<&str> = Vec::new();
        for viewer in &self.viewers {
            let (Viewer::View(name) | Viewer::Path { name, .. }) = viewer;
            if names.last() != Some(&name.as_str()) {
                names.push(name);
            }
        }
        match names.len() {
            1..=3 => names.join(" + "),
            count => format!("{} + {} more", names[0], count - 1),
        }
    }

    /// A name for each viewer, for people.
    pub fn viewer_names(&self) -> Vec<String> {
        let paired = |name: &str| {
            let mut viewers = self.viewers.iter();
            viewers.any(|v| matches!(v, Viewer::Path { name: n, eye: 1.., .. } if n == name))
        };
        let viewers = self.viewers.iter();
        viewers
            .map(|viewer| match viewer {
                Viewer::View(name) => name.clone(),
                Viewer::Path {
                    name,
                    eye,
                    turn_deg,
                } => {
                    let eye = match (paired(name), eye) {
                        (false, _) => "",
                        (true, 0) => ", left",
                        (true, _) => ", right",
                    };
                    let turn = match *turn_deg {
                        0.0 => String::new(),
                        turn => format!(", turned {turn:.0}°"),
                    };
                    format!("{name}{eye}{turn}")
                }
            })
            .collect()
    }

    /// The cameras at a time, in the coordinates of the scene's file. `None` where the scene has no longer what
    /// they follow.
    pub fn views(&self, scene: &SceneDescription, time_s: f64) -> Option<Vec<View>> {
        let viewers = self.viewers.iter();
        viewers.map(|viewer| viewer.view(scene, time_s)).collect()
    }
}

impl Viewer {
    fn view(&self, scene: &SceneDescription, time_s: f64) -> Option<View> {
        match self {
            Self::View(name) => scene.views.iter().find(|view| view.name == *name).cloned(),
            Self::Path {
                name,
                eye,
                turn_deg,
            } => {
                let path = scene.paths.iter().find(|path| path.name == *name)?;
                let metres_per_unit = scene.metres_per_unit.unwrap_or(1.0);
                let mut views = path.views(time_s, metres_per_unit);
                (*eye < views.len()).then(|| turned(views.swap_remove(*eye), *turn_deg))
            }
        }
    }
}

/// A view turned to its right about its own up.
fn turned(view: View, degrees: f64) -> View {
    if degrees == 0.0 {
        return view;
    }
    let towards_right = view.forward.cross(view.right).dot(view.up).signum();
    let turn = DQuat::from_axis_angle(view.up, towards_right * degrees.to_radians());
    View {
        right: turn * view.right,
        forward: turn * view.forward,
        ..view
    }
}
