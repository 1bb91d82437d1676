//! Making an image of texels: directions of their cones are put into the material at each camera sample.

use glam::Vec3;
use rayon::prelude::*;

use super::options::{Horizon, Parameters};
use super::sight::{Addresses, Sight, camera_ray};
use super::texels::{Surfaces, frame_of};
use crate::cache::cones::{Cone, Storage};
use crate::cache::surface::Texel;
use crate::image::Image;
use crate::sample::{Frame, Rng, hash};
use crate::shade::{Depths, Interaction};
use crate::technique::Shot;
use crate::trace::{Caster, Hit, Ray, RayCounter};

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
pub(super) struct Shown {
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
/// The golden ratio's fractional part: turns of directions, one after another.
const GOLDEN_TURN: f32 = 0.618_034;

impl Shading<'_> {
    /// The image of what a viewer sees.
    pub fn image(&self, sight: &Sight, counter: &RayCounter) -> Shown {
        let mut image = Image::new(self.shot.width, self.shot.height);
        let width = self.shot.width.max(1);
        let tallies: Vec<ShadingTally> = image
            .pixels
            .par_chunks_mut(width)
            .enumerate()
            .map_init(
                || self.shot.tracer.caster(counter),
                |caster, (y, row)| self.row(caster, (y * width, row), sight),
            )
            .collect();
        let mut tally = ShadingTally::default();
        tallies.iter().for_each(|row| tally.add(row));
        Shown { image, tally }
    }

    fn row(
        &self,
        caster: &Caster,
        (first, row): (usize, &mut [[f32; 3]]),
        sight: &Sight,
    ) -> ShadingTally {
        let addresses = Addresses::new(self.shot, self.surfaces, self.parameters);
        let mut tally = ShadingTally::default();
        let samples = self.shot.spp as usize;
        for (pixel, value) in (first..).zip(row) {
            let mut sum = Vec3::ZERO;
            for sample in 0..samples {
                let ray = camera_ray(self.shot, pixel as u32, sample as u32);
                let seen = (ray, sight.hits[pixel * samples + sample]);
                let item = pixel as u64 | u64::from(self.shot.viewer) << 48;
                let number = u64::from(self.shot.frame) << 32 | sample as u64;
                let mut rng = Rng::new(self.seed, STREAM, item, number);
                let radiance = self.radiance(caster, (&addresses, seen), &mut rng, &mut tally);
                match radiance.is_finite() {
                    true => sum += radiance,
                    false => tally.non_finite += 1,
                }
            }
            *value = (sum / samples.max(1) as f32).into();
        }
        tally
    }

    /// Radiance along a camera ray.
    fn radiance(
        &self,
        caster: &Caster,
        (addresses, (ray, hit)): (&Addresses, (Ray, Option<Hit>)),
        rng: &mut Rng,
        tally: &mut ShadingTally,
    ) -> Vec3 {
        let paths = &self.shot.paths;
        let Some(hit) = hit else {
            return paths.lights().environment(ray.direction);
        };
        let at = paths.surfaces().interact(&hit, ray.direction);
        let mut sum = paths.lights().emitted(&at) + self.straight(caster, &at, rng);
        if let Some(address) = addresses.of(&hit, ray.direction) {
            let texels = address.texels(&self.surfaces.grid, self.parameters.filter);
            let (mut scattered, mut weights) = (Vec3::ZERO, 0.0);
            for (texel, weight) in texels {
                tally.lookups += 1;
                if let Some(light) = self.scattered(&at, (texel, weight)) {
                    scattered += light * weight;
                    weights += weight;
                }
            }
            if weights > 0.0 {
                sum += scattered / weights;
            } else {
                tally.uncached += 1;
                sum += self.sampled(caster, &at, rng);
            }
        }
        sum
    }

    /// Light that reaches the viewer without being spread: through masks and glass, and by mirrors.
    fn straight(&self, caster: &Caster, at: &Interaction, rng: &mut Rng) -> Vec3 {
        let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        let Some(sample) = at.sample(u).filter(|sample| sample.delta) else {
            return Vec3::ZERO;
        };
        let paths = &self.shot.paths;
        let ray = paths.lights().spawn(at, sample.direction);
        let seen = paths.radiance(caster, ray, rng, Depths::up_to(1));
        sample.weight * Vec3::from(seen)
    }

    /// What a surface sends to its viewer of the light of a texel; `None` where that was never updated. A texel of little
    /// weight gets its part of the directions.
    fn scattered(&self, at: &Interaction, (texel, weight): (Texel, f32)) -> Option<Vec3> {
        let (point, words) = self.surfaces.blocks.texel(texel)?;
        let entry = self.storage.read(words);
        if entry.count <= 0.0 || !point.is_somewhere() {
            return None;
        }
        let back = texel.block.surface().back;
        let orientation = self.parameters.orientation;
        let frame = frame_of(self.shot.scene, (point.triangle, back), orientation);
        // The directions of a texel stay the same, so that they do not flicker.
        let turn = hash(texel.block.bits() ^ u64::from(texel.index) << 58) >> 40;
        let turn = turn as f32 / (1 << 24) as f32;
        let cones = entry.carried(|axis| frame.to_world(axis).normalize());
        let samples = (self.parameters.shading_samples as f32 * weight).ceil() as u32;
        let of_cone = |cone: &Cone| self.scattered_of(at, cone, (samples.max(1), turn));
        Some(cones.cones().iter().map(of_cone).sum())
    }

    fn scattered_of(&self, at: &Interaction, cone: &Cone, (samples, turn): (u32, f32)) -> Vec3 {
        let normal = at.facing_shading_normal();
        let height = cone.axis.dot(normal);
        if let Some(scattering) = at.lambertian()
            && height >= cone.half_angle.sin()
        {
            // All of it is above the surface: the mean cosine is known.
            let cosine = height * 0.5 * (1.0 + cone.half_angle.cos());
            return cone.light * scattering * cosine;
        }
        let frame = Frame::from_normal(cone.axis);
        let (mut sum, mut above) = (Vec3::ZERO, 0);
        for i in 0..samples {
            let u = (i as f32 + 0.5) / samples as f32;
            let direction = cone.direction(&frame, [u, (turn + i as f32 * GOLDEN_TURN).fract()]);
            sum += at.evaluate(direction);
            above += u32::from(direction.dot(normal) > 0.0);
        }
        let count = match self.parameters.horizon {
            Horizon::Lost => samples,
            Horizon::Renormalised => above.max(1),
        };
        cone.light * sum / count as f32
    }

    /// What a surface sends to its viewer of light samples of its own.
    fn sampled(&self, caster: &Caster, at: &Interaction, rng: &mut Rng) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for _ in 0..self.samples {
            let Some(light) = self.shot.paths.lights().sample(at, rng) else {
                continue;
            };
            let scattered = at.evaluate(light.direction) * light.radiance / light.pdf_sr;
            if scattered != Vec3::ZERO && !caster.occluded(&light.shadow_ray) {
                sum += scattered;
            }
        }
        sum / self.samples.max(1) as f32
    }
}
