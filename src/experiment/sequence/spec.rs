//! `[sequence]` of a config: what is seen over time, by whom, and what of it is measured and kept.

use serde::{Deserialize, Serialize};

use super::{Sequence, Viewer};
use crate::scene::path::CameraPath;
use crate::scene::{SceneDescription, View};
use crate::suggest::hint;

/// Most frames of a sequence.
const MOST_FRAMES: usize = 100_000;
/// Most viewers of a sequence.
const MOST_VIEWERS: usize = 1024;
/// Measured frames of which images are kept unless the config says which.
const KEPT: usize = 8;

/// `[sequence]`.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SequenceSpec {
    /// Camera path of the scene; without it and without `viewers` the camera stands at the scene's view. Beside
    /// `viewers` only where they overlap.
    #[serde(default)]
    pub path: Option<String>,
    /// Numbers of the frames that are rendered one after another: how many (`120`), `"from..to"` or
    /// `"from..to..step"` without `to`, or a list.
    pub frames: Frames,
    /// Frame `n` shows the time `n / fps` seconds.
    #[serde(default = "thirty")]
    pub fps: f64,
    /// Several cameras that see each frame together: names of paths, or `{ paths, count, overlap }`.
    #[serde(default)]
    pub viewers: Option<ViewersSpec>,
    /// Frames at the start that are rendered and not measured.
    #[serde(default)]
    pub warm_up: usize,
    /// Of the frames after the warm-up one in so many is measured.
    #[serde(default = "one")]
    pub measure_every: usize,
    /// Frames of each `measure_every` that are measured, one after another: from 2 on rows have `flicker`.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub measure_run: usize,
    /// Frames whose images are kept: `"some"` (eight of those measured), `"measured"`, `"all"`, `"none"` or a list.
    #[serde(default)]
    pub keep: Keep,
    /// Whether contenders with a memory also render each measured frame without it, for `rmse_cold`.
    #[serde(default)]
    pub cold: bool,
    /// Whether contenders without a memory leave out frames that are neither measured nor kept: their totals are then of
    /// fewer frames, so compare costs per image.
    #[serde(default)]
    pub skip_unmeasured: bool,
}

fn thirty() -> f64 {
    30.0
}

pub(super) fn one() -> usize {
    1
}

pub(super) fn is_one(number: &usize) -> bool {
    *number == 1
}

/// Which frames are rendered.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(
    untagged,
    expecting = "frames: expected how many (120), \"from..to\", \"from..to..step\" or a list, in whole numbers of at least 0"
)]
pub enum Frames {
    /// So many, numbered from 0.
    Count(u32),
    /// `from..to` or `from..to..step`, without `to`.
    Range(String),
    /// Their numbers, ascending.
    List(Vec<u32>),
}

/// Who looks.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(
    untagged,
    expecting = "viewers: expected a list of names of paths, or { count = 2 } with `paths` or `overlap` besides"
)]
pub enum ViewersSpec {
    /// Each path by name; of a stereo pair both eyes.
    Paths(Vec<String>),
    /// Some of several paths, or copies of one.
    Rule(ViewerRule),
}

/// Viewers by a rule: the first `count` of some paths, or copies of one path.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ViewerRule {
    /// Paths to take the first ones of, without an overlap; default: all of the scene, in its order.
    #[serde(default)]
    pub paths: Vec<String>,
    /// How many viewers.
    pub count: usize,
    /// In place of several paths: copies of `path`, each turned to the right of the one before so that
    /// neighbours share this part, in [0, 1], of their horizontal field of view.
    #[serde(default)]
    pub overlap: Option<f64>,
}

/// Of which frames images are kept.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(
    untagged,
    expecting = "keep: expected \"some\", \"measured\", \"all\", \"none\" or a list of frames"
)]
pub enum Keep {
    /// By a rule.
    Word(KeepWord),
    /// Numbers of frames.
    Frames(Vec<u32>),
}

impl Default for Keep {
    fn default() -> Self {
        Self::Word(KeepWord::Some)
    }
}

/// Of which frames images are kept, in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum KeepWord {
    /// Eight of those that are measured, evenly spread.
    Some,
    /// All that are measured.
    Measured,
    /// All that are rendered.
    All,
    /// Of none.
    None,
}

/// The key of `[sequence]` that is at fault, and why.
pub type Fault = (&'static str, String);

impl SequenceSpec {
    /// The sequence of a scene. `path` is the scene's own choice of a path, `view` the view of a camera that stands,
    /// and `size` that of the images of a camera.
    pub fn resolve(
        &self,
        scene: &SceneDescription,
        path: Option<&str>,
        view: &str,
        size: &dyn Fn(&View) -> [usize; 2],
    ) -> Result<Sequence, Fault> {
        let frames = self.frames.numbers().map_err(|why| ("frames", why))?;
        if !(self.fps.is_finite() && self.fps > 0.0) {
            return Err(("fps", "fps: expected a number above 0".into()));
        }
        let last = frames[frames.len() - 1];
        if !(f64::from(last) / self.fps).is_finite() {
            let why = format!("fps: expected more, so that the time of frame {last} is finite");
            return Err(("fps", why));
        }
        if self.measure_every == 0 {
            let why = "measure_every: expected a whole number of at least 1";
            return Err(("measure_every", why.into()));
        }
        if !(1..=self.measure_every).contains(&self.measure_run) {
            let why = format!(
                "measure_run: expected 1 to {}, which is measure_every",
                self.measure_every
            );
            return Err(("measure_run", why));
        }
        if self.warm_up >= frames.len() {
            let why = format!(
                "warm_up: {} frames leave none of {} to measure",
                self.warm_up,
                frames.len()
            );
            return Err(("warm_up", why));
        }
        let mut sequence = Sequence {
            viewers: self.viewers(scene, path, view, size)?,
            first_of: self.first_of(),
            fps: self.fps,
            warm_up: self.warm_up,
            measure_every: self.measure_every,
            measure_run: self.measure_run,
            cold: self.cold,
            skip_unmeasured: self.skip_unmeasured,
            kept: Vec::new(),
            frames,
        };
        sequence.kept = self.kept(&sequence)?;
        Ok(sequence)
    }

    /// What listed paths are called together where viewers take the first of them.
    fn first_of(&self) -> Option<String> {
        let Some(ViewersSpec::Rule(rule)) = &self.viewers else {
            return None;
        };
        let [first, .., last] = rule.paths.as_slice() else {
            return None;
        };
        Some(format!("{first} to {last}"))
    }

    fn viewers(
        &self,
        scene: &SceneDescription,
        path: Option<&str>,
        view: &str,
        size: &dyn Fn(&View) -> [usize; 2],
    ) -> Result<Vec<Viewer>, Fault> {
        let path = path.or(self.path.as_deref());
        let overlap = match &self.viewers {
            Some(ViewersSpec::Rule(rule)) => rule.overlap,
            _ => None,
        };
        if let (Some(_), Some(name), None) = (&self.viewers, path, overlap) {
            let why = format!(
                "path: `viewers` say who looks, and `{name}` would not be followed: leave one of them out, or give \
                 viewers an `overlap` for copies of it"
            );
            return Err(("path", why));
        }
        let viewers: Vec<Viewer> = match &self.viewers {
            None => match path {
                None => vec![Viewer::View(view.to_owned())],
                Some(name) => along(find(scene, name, "path")?, scene, 0.0)?,
            },
            Some(ViewersSpec::Paths(names)) => several(scene, names)?,
            Some(ViewersSpec::Rule(rule)) if !(1..=MOST_VIEWERS).contains(&rule.count) => {
                let why = format!("viewers: expected a count from 1 to {MOST_VIEWERS}");
                return Err(("viewers", why));
            }
            Some(ViewersSpec::Rule(rule)) if overlap.is_some() && !rule.paths.is_empty() => {
                let why = "viewers with an `overlap` are copies of `path`: leave `paths` out";
                return Err(("viewers", why.into()));
            }
            Some(ViewersSpec::Rule(rule)) => match overlap {
                Some(overlap) => turned(scene, path, rule.count, overlap, size)?,
                None => first(scene, rule)?,
            },
        };
        match viewers.is_empty() {
            true => Err(("viewers", "viewers: expected at least one path".into())),
            false => Ok(viewers),
        }
    }

    fn kept(&self, sequence: &Sequence) -> Result<Vec<u32>, Fault> {
        let measured = || sequence.measured().collect::<Vec<u32>>();
        Ok(match &self.keep {
            Keep::Word(KeepWord::None) => Vec::new(),
            Keep::Word(KeepWord::All) => sequence.frames.clone(),
            Keep::Word(KeepWord::Measured) => measured(),
            Keep::Word(KeepWord::Some) => spread(&measured(), KEPT),
            Keep::Frames(frames) => {
                let absent = frames.iter().find(|f| !sequence.frames.contains(f));
                if let Some(frame) = absent {
                    let why = format!("keep: frame {frame} is not rendered");
                    return Err(("keep", why));
                }
                let mut frames = frames.clone();
                frames.sort_unstable();
                frames.dedup();
                frames
            }
        })
    }
}

/// Up to `count` of some frames, evenly apart, with the first and the last.
pub fn spread(frames: &[u32], count: usize) -> Vec<u32> {
    if frames.len() <= count || count < 2 {
        return frames[..frames.len().min(count)].to_vec();
    }
    let at = |k: usize| k * (frames.len() - 1) / (count - 1);
    (0..count).map(|k| frames[at(k)]).collect()
}

fn find<'a>(
    scene: &'a SceneDescription,
    name: &str,
    key: &'static str,
) -> Result<&'a CameraPath, Fault> {
    let found = scene.paths.iter().find(|path| path.name == name);
    found.ok_or_else(|| {
        let known: Vec<&str> = scene.paths.iter().map(|path| path.name.as_str()).collect();
        let hint = match hint(name, &known) {
            none if none.is_empty() => ":".to_owned(),
            hint => hint,
        };
        let known = match known.is_empty() {
            true => "the scene has none; a config may add one as [[path]]".to_owned(),
            false => format!("it has: {}", known.join(", ")),
        };
        let why = format!("scene `{}` has no path `{name}`{hint} {known}", scene.name);
        (key, why)
    })
}

/// The viewers of one path, turned to the right by an angle.
fn along(path: &CameraPath, scene: &SceneDescription, turn_deg: f64) -> Result<Vec<Viewer>, Fault> {
    if path.viewers() > 1 && scene.metres_per_unit.is_none() {
        let why = format!(
            "path `{}` is a stereo pair, and nothing says how long a unit of scene `{}` is: set metres_per_unit",
            path.name, scene.name
        );
        return Err(("path", why));
    }
    let viewer = |eye: usize| Viewer::Path {
        name: path.name.clone(),
        eye,
        turn_deg,
    };
    Ok((0..path.viewers()).map(viewer).collect())
}

fn several(scene: &SceneDescription, names: &[String]) -> Result<Vec<Viewer>, Fault> {
    let mut viewers = Vec::new();
    for name in names {
        viewers.extend(along(find(scene, name, "viewers")?, scene, 0.0)?);
    }
    Ok(viewers)
}

fn first(scene: &SceneDescription, rule: &ViewerRule) -> Result<Vec<Viewer>, Fault> {
    let names = match rule.paths.is_empty() {
        true => scene.paths.iter().map(|path| path.name.clone()).collect(),
        false => rule.paths.clone(),
    };
    let mut viewers = several(scene, &names)?;
    if viewers.len() < rule.count {
        let why = format!(
            "viewers: {} are wanted and the paths have {}",
            rule.count,
            viewers.len()
        );
        return Err(("viewers", why));
    }
    viewers.truncate(rule.count);
    Ok(viewers)
}

fn turned(
    scene: &SceneDescription,
    path: Option<&str>,
    count: usize,
    overlap: f64,
    size: &dyn Fn(&View) -> [usize; 2],
) -> Result<Vec<Viewer>, Fault> {
    let Some(name) = path else {
        let why = "viewers with an `overlap` are copies of one path: name it as `path`";
        return Err(("viewers", why.into()));
    };
    if !(0.0..=1.0).contains(&overlap) {
        return Err(("viewers", "overlap: expected a number from 0 to 1".into()));
    }
    let path = find(scene, name, "path")?;
    let view = path.view(path.span_s()[0]);
    let [width, height] = size(&view);
    let [tangent, _] = view.half_tangents(width, height);
    let step_deg = (1.0 - overlap) * 2.0 * tangent.atan().to_degrees();
    let mut viewers = Vec::new();
    for copy in 0..count {
        viewers.extend(along(path, scene, step_deg * copy as f64)?);
    }
    Ok(viewers)
}

impl Frames {
    fn numbers(&self) -> Result<Vec<u32>, String> {
        let frames = match self {
            Self::Count(count) => (0..*count).take(MOST_FRAMES + 1).collect(),
            Self::List(frames) => frames.clone(),
            Self::Range(text) => range(text)?,
        };
        if frames.is_empty() || frames.len() > MOST_FRAMES {
            return Err(format!("frames: expected 1 to {MOST_FRAMES} of them"));
        }
        if frames.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err("frames: expected ascending numbers".into());
        }
        Ok(frames)
    }
}

/// `from..to` or `from..to..step`, without `to`.
fn range(text: &str) -> Result<Vec<u32>, String> {
    let expected = || {
        format!(
            "frames: expected \"from..to\" or \"from..to..step\" in whole numbers, found \"{text}\""
        )
    };
    let numbers: Vec<u32> = text
        .split("..")
        .map(|part| part.trim().parse().map_err(|_| expected()))
        .collect::<Result<_, _>>()?;
    match numbers[..] {
        [from, to] => Ok((from..to).take(MOST_FRAMES + 1).collect()),
        [from, to, step] if step > 0 => Ok((from..to)
            .step_by(step as usize)
            .take(MOST_FRAMES + 1)
            .collect()),
        _ => Err(expected()),
    }
}

#[cfg(test)]
mod tests;
