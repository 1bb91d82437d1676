//! `[[motion]]`.

use std::collections::BTreeSet;

use glam::DVec3;

use super::Loader;
use super::keys::{Keys, Name};
use crate::scene::SceneError;
use crate::scene::motion::{KeyedLink, Link, MotionDescription, Placement, Turn};
use crate::scene::track::{Interpolation, Track};

/// What a key frame of a motion may say.
struct Frame {
    time_s: f64,
    translate: Option<DVec3>,
    rotate_deg: Option<f64>,
    scale: Option<DVec3>,
    emission: Option<f64>,
    on: Option<bool>,
}

impl Loader {
    pub(super) fn motion(&mut self, keys: &mut Keys) -> Result<(), SceneError> {
        let shapes = self.scene.shapes.iter();
        let shapes: Vec<[&str; 2]> = shapes.map(|s| [s.object(), s.name.as_str()]).collect();
        let lights = self.scene.lights.iter();
        let lights: Vec<[&str; 2]> = lights.map(|light| [light.name.as_str(); 2]).collect();
        let mut motion = MotionDescription {
            shapes: named(keys, ["shape", "shapes"], &shapes)?,
            lights: named(keys, ["light", "lights"], &lights)?,
            environment: keys.boolean("environment", false)?,
            ..MotionDescription::default()
        };
        if motion.shapes.is_empty() && motion.lights.is_empty() && !motion.environment {
            let message =
                "[[motion]] needs what it moves: `shape`, `light` or `environment = true`";
            return Err(keys.error(message));
        }
        let words = [
            ("linear", Interpolation::Linear),
            ("smooth", Interpolation::Smooth),
            ("step", Interpolation::Step),
        ];
        let interpolation = keys.word("interpolation", &words)?;
        let pivot = keys.vector("pivot")?;
        let axis = keys.vector("axis")?.unwrap_or(DVec3::Y).try_normalize();
        let axis = axis.ok_or_else(|| keys.error("the `axis` of a motion must not be zero"))?;
        let frames = frames(keys)?;
        keys.finish()?;
        self.check_frames(keys, &motion, &frames)?;
        let link = KeyedLink {
            pivot,
            scale: vectors(&frames, interpolation, |frame| frame.scale),
            turn: numbers(&frames, interpolation, |frame| {
                frame.rotate_deg.map(f64::to_radians)
            })
            .map(|angle_rad| Turn::About { axis, angle_rad }),
            translate: vectors(&frames, interpolation, |frame| frame.translate),
        };
        if link.scale.is_some() || link.turn.is_some() || link.translate.is_some() {
            motion.placement = Placement {
                links: vec![Link::Keyed(link)],
            };
        }
        let emission = numbers(&frames, interpolation, |frame| frame.emission);
        let on = |frame: &Frame| frame.on.map(|on| f64::from(u8::from(on)));
        let on = numbers(&frames, Interpolation::Step, on);
        motion.strength = emission.into_iter().chain(on).collect();
        self.scene.motions.push(motion);
        Ok(())
    }

    /// Whether what is moved has what its keys change.
    fn check_frames(
        &self,
        keys: &Keys,
        motion: &MotionDescription,
        frames: &[Frame],
    ) -> Result<(), SceneError> {
        let any = |has: fn(&Frame) -> bool| frames.iter().any(has);
        let shines = any(|f| f.emission.is_some() || f.on.is_some());
        let moves = any(|f| f.translate.is_some() || f.scale.is_some());
        let mut shapes = motion.shapes.iter().map(|&i| &self.scene.shapes[i]);
        let dark = shapes.find(|shape| shape.emission.is_none());
        let message = match dark {
            _ if !shines && !moves && !any(|f| f.rotate_deg.is_some()) => {
                "keys of a motion need `translate`, `rotate_deg`, `scale`, `emission` or `on`"
                    .into()
            }
            _ if motion.environment && moves => {
                "an environment can only turn: use `rotate_deg`".into()
            }
            _ if motion.environment && shines => {
                "the strength of an environment cannot be keyed".into()
            }
            _ if motion.environment && self.scene.environment.is_none() => {
                "the scene has no environment that could turn".into()
            }
            Some(shape) if shines => format!("shape `{}` emits no light to change", shape.name),
            _ => return Ok(()),
        };
        Err(keys.error(message))
    }
}

/// Places, among things that have two names each, of those that are named under a key for one and a key for several.
fn named(
    keys: &Keys,
    [one, several]: [&'static str; 2],
    things: &[[&str; 2]],
) -> Result<Vec<usize>, SceneError> {
    let mut found = BTreeSet::new();
    let one_name = keys.string(one)?.zip(keys.get(one));
    let one_name = one_name.map(|(name, value)| (one, value, name));
    let several_names = keys.names(several)?.unwrap_or_default().into_iter();
    let several_names = several_names.map(|Name { name, item }| (several, item, name));
    for (key, value, name) in one_name.into_iter().chain(several_names) {
        let called = |i: &usize| things[*i].contains(&name);
        found.extend((0..things.len()).filter(called));
        if !things.iter().any(|thing| thing.contains(&name)) {
            let known: Vec<&str> = things.iter().map(|thing| thing[0]).collect();
            return Err(keys.unknown_at(value.span(), key, name, &known));
        }
    }
    Ok(found.into_iter().collect())
}

fn frames(keys: &Keys) -> Result<Vec<Frame>, SceneError> {
    let mut frames: Vec<Frame> = Vec::new();
    for (i, mut table) in keys.tables("keys")?.into_iter().enumerate() {
        table.what = format!("key {i} of a motion");
        let frame = frame(&table)?;
        if frames
            .last()
            .is_some_and(|before| before.time_s >= frame.time_s)
        {
            let message = format!("{}: times of keys must ascend", table.what);
            return Err(table.error(message));
        }
        frames.push(frame);
    }
    match frames.is_empty() {
        true => {
            Err(keys.error("[[motion]] needs `keys`: [{ time = 0, translate = [0, 1, 0] }, …]"))
        }
        false => Ok(frames),
    }
}

fn frame(keys: &Keys) -> Result<Frame, SceneError> {
    let scale = match keys.get("scale") {
        Some(value) if value.get_ref().as_array().is_some() => keys.vector("scale")?,
        _ => keys.number("scale")?.map(DVec3::splat),
    };
    if let (Some(scale), Some(value)) = (scale, keys.get("scale"))
        && scale.min_element() <= 0.0
    {
        return Err(keys.wrong("scale", value, "a factor, or three, above 0"));
    }
    let frame = Frame {
        time_s: keys.required("time", keys.number("time")?)?,
        translate: keys.vector("translate")?,
        rotate_deg: keys.number("rotate_deg")?,
        scale,
        emission: keys.non_negative("emission")?,
        on: match keys.get("on") {
            Some(_) => Some(keys.boolean("on", true)?),
            None => None,
        },
    };
    keys.finish()?;
    Ok(frame)
}

/// Times and values of the keys that say something.
fn said<T>(frames: &[Frame], value: impl Fn(&Frame) -> Option<T>) -> (Vec<f64>, Vec<T>) {
    let said = |frame: &Frame| Some((frame.time_s, value(frame)?));
    frames.iter().filter_map(said).unzip()
}

fn numbers(
    frames: &[Frame],
    interpolation: Interpolation,
    value: impl Fn(&Frame) -> Option<f64>,
) -> Option<Track<f64>> {
    let (times, values) = said(frames, value);
    (!values.is_empty()).then(|| Track::<f64>::keyed(times, values, interpolation))
}

fn vectors(
    frames: &[Frame],
    interpolation: Interpolation,
    value: impl Fn(&Frame) -> Option<DVec3>,
) -> Option<Track<DVec3>> {
    let (times, values) = said(frames, value);
    (!values.is_empty()).then(|| Track::<DVec3>::keyed(times, values, interpolation))
}

#[cfg(test)]
mod tests;
