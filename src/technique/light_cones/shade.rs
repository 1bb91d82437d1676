//! Making an image of texels: directions of their cones are put into the material at each camera sample.

use std::f32::consts::TAU;

use glam::Vec3;
use rayon::prelude::*;

use super::options::{Horizon, Parameters};
use super::shown::{Shown, ShownCone, ShownTexels};
use super::sight::{Address, Look, Sight, camera_ray, meet};
use super::texels::{Surfaces, frame_of, normal_of};
use crate::cache::cones::{Cone, Storage};
use crate::cache::surface::Texel;
use crate::image::Image;
use crate::sample::{Frame, Rng, hash};
use crate::shade::bsdf::{Incident, LightCone};
use crate::shade::{Depths, Interaction};
use crate::technique::Shot;
use crate::trace::{Caster, RayCounter};

/// Makes the image of a viewer.
pub(super) struct Shading<'a> {
    pub shot: &'a Shot<'a>,
    pub surfaces: &'a Surfaces,
    pub parameters: &'a Parameters,
    pub storage: Storage,
    /// Light samples of camera samples that no texel serves.
    pub samples: u32,
    pub seed: u64,
}

/// An image and what it took.
pub(super) struct Shaded {
    pub image: Image,
    pub tally: ShadingTally,
}

/// What shading took and met.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ShadingTally {
    /// Texels that were read.
    pub lookups: u64,
    /// Camera samples that no texel served.
    pub uncached: u64,
    /// Camera samples that were not finite and count as black.
    pub non_finite: u64,
}

impl ShadingTally {
    fn add(&mut self, other: &Self) {
        self.lookups += other.lookups;
        self.uncached += other.uncached;
        self.non_finite += other.non_finite;
    }
}

/// Keys the random numbers of camera samples.
const STREAM: u64 = 0x636f_6e65_7368;
/// Rows of pixels that are shaded together, column by column: neighbours read the same texels.
const BAND: usize = 8;

/// What a thread works with.
struct Workplace<'a> {
    caster: Caster<'a>,
    texels: ShownTexels,
    incident: Incident,
    tally: ShadingTally,
}

impl Shading<'_> {
    /// The image of what a viewer sees.
    pub fn image(&self, sight: &Sight, counter: &RayCounter) -> Shaded {
        let mut image = Image::new(self.shot.width, self.shot.height);
        let width = self.shot.width.max(1);
        let start = || Workplace {
            caster: self.shot.tracer.caster(counter),
            texels: ShownTexels::default(),
            incident: Incident::new(
                self.parameters.shading_samples as usize,
                self.parameters.horizon == Horizon::Renormalised,
            ),
            tally: ShadingTally::default(),
        };
        let tallies: Vec<ShadingTally> = image
            .pixels
            .par_chunks_mut(BAND * width)
            .enumerate()
            .map_init(start, |workplace, (band, pixels)| {
                workplace.tally = ShadingTally::default();
                self.band(workplace, sight, band * BAND * width, pixels);
                workplace.tally
            })
            .collect();
        let mut tally = ShadingTally::default();
        tallies.iter().for_each(|band| tally.add(band));
        Shaded { image, tally }
    }

    /// Shades rows of pixels from pixel `first` on.
    fn band(
        &self,
        workplace: &mut Workplace,
        sight: &Sight,
        first: usize,
        pixels: &mut [[f32; 3]],
    ) {
        let samples = self.shot.spp as usize;
        let width = self.shot.width.max(1);
        for column in 0..width {
            for index in (column..pixels.len()).step_by(width) {
                let pixel = first + index;
                let mut sum = Vec3::ZERO;
                for sample in 0..samples {
                    let radiance = match sight.looks[pixel * samples + sample] {
                        Some(look) => self.seen(workplace, look, [pixel, sample]),
                        None => {
                            let number = [pixel as u32, sample as u32];
                            self.emission(&workplace.caster, None, number)
                        }
                    };
                    match radiance.is_finite() {
                        true => sum += radiance,
                        false => workplace.tally.non_finite += 1,
                    }
                }
                pixels[index] = (sum / samples.max(1) as f32).into();
            }
        }
    }

    /// Emission that a camera sample gets: of the surface that it meets or the sky, and of masks on its way.
    fn emission(
        &self,
        caster: &Caster,
        at: Option<&Interaction>,
        [pixel, sample]: [u32; 2],
    ) -> Vec3 {
        let paths = &self.shot.paths;
        if paths.surfaces().has_masks() {
            return meet(self.shot, caster, self.seed, [pixel, sample]).emission();
        }
        match at {
            Some(at) => paths.lights().emitted(at),
            None => {
                let ray = camera_ray(self.shot, self.seed, pixel, sample);
                paths.lights().environment(ray.direction)
            }
        }
    }

    /// Radiance that a camera sample of a pixel gets of the surface that it meets.
    fn seen(&self, workplace: &mut Workplace, look: Look, [pixel, sample]: [usize; 2]) -> Vec3 {
        let item = pixel as u64 | u64::from(self.shot.viewer) << 48;
        let number = u64::from(self.shot.frame) << 32 | sample as u64;
        let rng = &mut Rng::new(self.seed, STREAM, item, number);
        let paths = &self.shot.paths;
        let mut at = paths.surfaces().interact(&look.hit, look.direction);
        at.bsdf.opacity = 1.0;
        let straight = self.straight(&workplace.caster, &at, rng);
        let scattered = match look.address {
            Some(address) => self.cached(workplace, &at, &address),
            None if at.bsdf.is_delta() => Some(Vec3::ZERO),
            None => None,
        };
        let scattered = scattered.unwrap_or_else(|| {
            workplace.tally.uncached += 1;
            self.sampled(&workplace.caster, &at, rng)
        });
        let number = [pixel as u32, sample as u32];
        self.emission(&workplace.caster, Some(&at), number) + straight + scattered
    }

    /// What a surface sends to its viewer of the light of its texels, where they hold some.
    fn cached(
        &self,
        workplace: &mut Workplace,
        at: &Interaction,
        address: &Address,
    ) -> Option<Vec3> {
        let (grid, filter) = (&self.surfaces.grid, self.parameters.filter);
        let (mut scattered, mut weights) = (Vec3::ZERO, 0.0);
        workplace.incident.clear();
        address.for_each_texel(grid, filter, |texel, weight| {
            workplace.tally.lookups += 1;
            let make = |shown: &mut Shown| self.show(texel, shown);
            if let Some(cones) = workplace.texels.get(texel, make) {
                for cone in cones {
                    let incident = &mut workplace.incident;
                    scattered += self.scattered(at, cone, weight, incident);
                }
                weights += weight;
            }
        });
        if weights > 0.0 && !workplace.incident.is_empty() {
            scattered += at.scattered(&mut workplace.incident);
        }
        (weights > 0.0).then(|| scattered / weights)
    }

    /// Makes what is shown of a texel.
    fn show(&self, texel: Texel, shown: &mut Shown) {
        (shown.known, shown.used) = (false, 0);
        let Some((point, words)) = self.surfaces.blocks.texel(texel) else {
            return;
        };
        let entry = self.storage.read(words);
        if entry.count <= 0.0 || !point.is_somewhere() {
            return;
        }
        let back = texel.block.surface().back;
        let orientation = self.parameters.orientation;
        let (scene, triangle) = (self.shot.scene, point.triangle);
        let normal = normal_of(scene, triangle, back);
        let frame = frame_of(scene, triangle, normal, orientation);
        // The directions of a texel stay the same, so that they do not flicker.
        let turn = hash(texel.block.bits() ^ u64::from(texel.index) << 58) >> 40;
        let turn = <[f32; 2]>::from((TAU * (turn as f32 / (1 << 24) as f32)).sin_cos());
        for (place, cone) in shown.cones.iter_mut().zip(entry.cones()) {
            let axis = frame.to_world(cone.axis).normalize();
            *place = ShownCone::of(&Cone { axis, ..*cone }, turn);
        }
        (shown.known, shown.used) = (true, entry.cones().len());
    }

    /// Light that reaches the viewer without being spread: through glass, and by mirrors.
    fn straight(&self, caster: &Caster, at: &Interaction, rng: &mut Rng) -> Vec3 {
        let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        if !at.bsdf.has_delta() {
            return Vec3::ZERO;
        }
        let Some(sample) = at.sample(u).filter(|sample| sample.delta) else {
            return Vec3::ZERO;
        };
        let paths = &self.shot.paths;
        let ray = paths.lights().spawn(at, sample.direction);
        let seen = paths.radiance(caster, ray, rng, Depths::up_to(1));
        sample.weight * Vec3::from(seen)
    }

    /// What a surface sends to its viewer of a cone, where that is known in closed form; its directions join the others
    /// otherwise. A texel of little weight gets its part of the directions.
    fn scattered(
        &self,
        at: &Interaction,
        cone: &ShownCone,
        weight: f32,
        incident: &mut Incident,
    ) -> Vec3 {
        if let Some(scattering) = at.lambertian() {
            let height = cone.frame.normal.dot(at.facing_shading_normal());
            if height >= cone.sine {
                // All of it is above the surface: the mean cosine is known.
                let cosine = height * 0.5 * (1.0 + cone.cosine);
                return cone.light * scattering * (cosine * weight);
            }
        }
        let most = self.parameters.shading_samples;
        let wanted = most as f32 * weight;
        let whole = wanted as u32;
        let samples = whole + u32::from((whole as f32) < wanted);
        let samples = samples.clamp(1, most) as usize;
        let Frame {
            tangent,
            bitangent,
            normal,
        } = cone.frame;
        incident.add(LightCone {
            axes: [tangent, bitangent, normal].map(|v| at.to_local(v)),
            height: cone.height,
            power: cone.light * weight,
            directions: samples,
        });
        Vec3::ZERO
    }

    /// What a surface sends to its viewer of light samples of its own.
    fn sampled(&self, caster: &Caster, at: &Interaction, rng: &mut Rng) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for _ in 0..self.samples {
            let Some(light) = self.shot.paths.lights().sample(at, rng) else {
                continue;
            };
            let scattered = at.evaluate(light.direction) * light.radiance / light.pdf_sr;
            if scattered != Vec3::ZERO && !self.shot.paths.occluded(caster, &light.shadow_ray) {
                sum += scattered;
            }
        }
        sum / self.samples.max(1) as f32
    }
}
