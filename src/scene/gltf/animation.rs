//! Animations: keyed translations, rotations and scales of nodes.

use std::collections::HashMap;

use ::gltf::json::animation::{Animation, Channel, Interpolation, Property};
use glam::{DAffine3, DQuat, DVec3};

use super::Importer;
use super::accessor::Accessors;
use super::document::{Buffers, GltfFile, named, valid};
use super::node::Trs;
use crate::scene::SceneError;
use crate::scene::motion::{KeyedLink, Link, Turn};
use crate::scene::track::{Keyed, Track};

/// What of a node changes over time.
#[derive(Debug, Default)]
pub(super) struct Animated {
    pub translation: Option<Track<DVec3>>,
    pub rotation: Option<Track<DQuat>>,
    pub scale: Option<Track<DVec3>>,
}

impl Animated {
    /// Translation, rotation and scale at a time; what has no keys is as at rest.
    pub fn at(&self, rest: &Trs, time_s: f64) -> Trs {
        let vector =
            |track: &Option<Track<DVec3>>, rest| track.as_ref().map_or(rest, |t| t.at(time_s));
        Trs {
            translation: vector(&self.translation, rest.translation),
            rotation: self
                .rotation
                .as_ref()
                .map_or(rest.rotation, |t| t.at(time_s)),
            scale: vector(&self.scale, rest.scale),
        }
    }

    /// Times of its keys, s.
    pub fn times_s(&self) -> Vec<f64> {
        let vectors = [&self.translation, &self.scale].into_iter().flatten();
        let vectors = vectors.flat_map(Track::times_s);
        let turns = self.rotation.iter().flat_map(Track::times_s);
        vectors.chain(turns).copied().collect()
    }

    /// The same as maps, scaling last in the list: it is applied first.
    pub fn links(&self, rest: &Trs) -> [Link; 3] {
        let keyed = |link: KeyedLink| {
            Link::Keyed(KeyedLink {
                pivot: Some(DVec3::ZERO),
                ..link
            })
        };
        [
            match &self.translation {
                None => Link::Fixed(DAffine3::from_translation(rest.translation)),
                Some(track) => keyed(KeyedLink {
                    translate: Some(track.clone()),
                    ..KeyedLink::default()
                }),
            },
            match &self.rotation {
                None => Link::Fixed(DAffine3::from_quat(rest.rotation)),
                Some(track) => keyed(KeyedLink {
                    turn: Some(Turn::Quaternion(track.clone())),
                    ..KeyedLink::default()
                }),
            },
            match &self.scale {
                None => Link::Fixed(DAffine3::from_scale(rest.scale)),
                Some(track) => keyed(KeyedLink {
                    scale: Some(track.clone()),
                    ..KeyedLink::default()
                }),
            },
        ]
    }
}

impl Importer<'_> {
    /// What the animations do to nodes, by the index of the node. All of them are played together; one that
    /// animates what an earlier one does is left out.
    pub(super) fn animations(
        &mut self,
        buffers: &Buffers,
    ) -> Result<HashMap<usize, Animated>, SceneError> {
        let mut taken: HashMap<(usize, &str), usize> = HashMap::new();
        let mut nodes = HashMap::new();
        for (i, animation) in self.file.root().animations.iter().enumerate() {
            let place = named("animation", i, animation.name.as_deref());
            let mut own = HashMap::new();
            for (c, channel) in animation.channels.iter().enumerate() {
                let place = format!("{place}, channel {c}");
                let Some(property) = valid(&channel.target.path).map(word) else {
                    return Err(self.file.error(place, "its path is unknown"));
                };
                let node = channel.target.node.value();
                if own.insert((node, property), channel).is_some() {
                    let node = self.file.node_place(node);
                    let message = format!("animates the {property} of {node} a second time");
                    return Err(self.file.error(place, message));
                }
            }
            if let Some(earlier) = own.keys().filter_map(|target| taken.get(target)).min() {
                self.note(format!(
                    "{place} is left out: it moves what animation {earlier} moves"
                ));
                continue;
            }
            taken.extend(own.keys().map(|target| (*target, i)));
            for (c, channel) in animation.channels.iter().enumerate() {
                if valid(&channel.target.path) == Some(Property::MorphTargetWeights) {
                    self.note("animated weights of morph targets are left out");
                    continue;
                }
                let place = format!("{place}, channel {c}");
                self.channel(animation, channel, &place, buffers, &mut nodes)?;
            }
        }
        Ok(nodes)
    }

    fn channel(
        &self,
        animation: &Animation,
        channel: &Channel,
        place: &str,
        buffers: &Buffers,
        nodes: &mut HashMap<usize, Animated>,
    ) -> Result<(), SceneError> {
        let file = self.file;
        let index = channel.target.node.value();
        let Some(node) = file.root().nodes.get(index) else {
            return Err(file.error(place, format!("animates node {index}, which is not there")));
        };
        if node.matrix.is_some() {
            let message = format!(
                "{} has a matrix, which cannot be animated",
                file.node_place(index)
            );
            return Err(file.error(place, message));
        }
        let Some(sampler) = animation.samplers.get(channel.sampler.value()) else {
            return Err(file.error(place, "its sampler is not there"));
        };
        let keys = Keys {
            accessors: Accessors { file, buffers },
            place,
            interpolation: valid(&sampler.interpolation)
                .ok_or_else(|| file.error(place, "its interpolation is unknown"))?,
            times_s: times(file, buffers, place, sampler.input.value())?,
        };
        let output = sampler.output.value();
        let node: &mut Animated = nodes.entry(index).or_default();
        match valid(&channel.target.path) {
            Some(Property::Translation) => node.translation = Some(keys.track(output, vector)?),
            Some(Property::Rotation) => node.rotation = Some(keys.track(output, rotation)?),
            Some(Property::Scale) => node.scale = Some(keys.track(output, vector)?),
            _ => {}
        }
        Ok(())
    }
}

/// The times of the keys of a sampler, s.
fn times(
    file: &GltfFile,
    buffers: &Buffers,
    place: &str,
    input: usize,
) -> Result<Vec<f64>, SceneError> {
    let times = Accessors { file, buffers }.vectors::<1>(input)?;
    let ascend = times.windows(2).all(|pair| pair[0][0] < pair[1][0]);
    match ascend && times.iter().all(|time| time[0].is_finite()) {
        true => Ok(times.iter().map(|time| f64::from(time[0])).collect()),
        false => Err(file.error(place, format!("its times (accessor {input}) do not ascend"))),
    }
}

/// Keys of a channel, without their values.
struct Keys<'a> {
    accessors: Accessors<'a>,
    place: &'a str,
    interpolation: Interpolation,
    times_s: Vec<f64>,
}

impl Keys<'_> {
    /// With the values of an accessor, one a key, or for cubic splines one between two slopes.
    fn track<const N: usize, T: Keyed>(
        self,
        output: usize,
        value: fn([f32; N]) -> T,
    ) -> Result<Track<T>, SceneError> {
        let fail = |message: String| self.accessors.file.error(self.place, message);
        let stored = self.accessors.vectors::<N>(output)?;
        let each = match self.interpolation {
            Interpolation::CubicSpline => 3,
            _ => 1,
        };
        let (found, expected) = (stored.len(), each * self.times_s.len());
        if found != expected {
            return Err(fail(format!(
                "has {found} values (accessor {output}), {expected} are expected"
            )));
        }
        if let Some(at) = stored.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
            return Err(fail(format!(
                "value {at} (accessor {output}) is not finite"
            )));
        }
        let keys = || stored.iter().skip(each / 2).step_by(each);
        if N == 4 && keys().any(|v| v.iter().all(|c| *c == 0.0)) {
            return Err(fail(format!("a rotation (accessor {output}) is zero")));
        }
        let values = keys().map(|v| value(*v).regular()).collect();
        Ok(match self.interpolation {
            Interpolation::Step => Track::step(self.times_s, values),
            Interpolation::Linear => Track::linear(self.times_s, values),
            Interpolation::CubicSpline => {
                let slopes = stored
                    .chunks_exact(3)
                    .map(|key| [value(key[0]), value(key[2])]);
                Track::cubic(self.times_s, values, slopes.collect())
            }
        })
    }
}

fn word(property: Property) -> &'static str {
    match property {
        Property::Translation => "translation",
        Property::Rotation => "rotation",
        Property::Scale => "scale",
        Property::MorphTargetWeights => "weights",
    }
}

fn vector(stored: [f32; 3]) -> DVec3 {
    DVec3::from(stored.map(f64::from))
}

fn rotation(stored: [f32; 4]) -> DQuat {
    DQuat::from_array(stored.map(f64::from))
}
