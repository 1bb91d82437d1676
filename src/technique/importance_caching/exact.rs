//! What needs no records: the sum over all lights, one light at random, and the background.

use glam::Vec3;
use rayon::prelude::*;

use super::records::receiver;
use crate::image::Image;
use crate::sample::Rng;
use crate::shade::{Gathering, VirtualLights};
use crate::technique::{ShadingFunction, Shot, each_pixel};
use crate::trace::{Caster, RayCounter};

/// Keys the choice of lights without records.
const STREAM: u64 = 0x6f6e_656c_6967;

/// The reference: all lights at every sample.
pub struct AllLights<'a> {
    shot: &'a Shot<'a>,
    lights: VirtualLights<'a>,
}

impl<'a> AllLights<'a> {
    pub fn new(shot: &'a Shot<'a>, lights: VirtualLights<'a>) -> Self {
        Self { shot, lights }
    }
}

impl ShadingFunction for AllLights<'_> {
    fn pixels(&self, caster: &Caster, first_pixel: u32, sample: u32, out: &mut [[f32; 3]]) -> u64 {
        let mut gathering = Gathering::default();
        let mut broken = 0;
        let unsound = each_pixel(first_pixel, out, |pixel| {
            let Some(seen) = self.shot.look(caster, pixel, sample) else {
                return background(self.shot, caster, pixel, sample);
            };
            let to = receiver(self.shot, &seen);
            let (sum, non_finite) = self.lights.sum(caster, &to, &mut gathering);
            let emitted = self.shot.paths.lights().emitted(&to.at);
            broken += non_finite;
            (emitted + sum) * seen.throughput
        });
        broken + unsound
    }
}

/// The contender without records: one light at random, by its power.
pub struct OneLight<'a> {
    shot: &'a Shot<'a>,
    lights: VirtualLights<'a>,
    /// Running sums of the lights' powers.
    sums: Vec<f64>,
    seed: u64,
}

impl<'a> OneLight<'a> {
    pub fn new(shot: &'a Shot<'a>, lights: VirtualLights<'a>, seed: u64) -> Self {
        let powers = lights.powers();
        let sums = powers
            .iter()
            .scan(0.0, |sum, &power| {
                *sum += f64::from(power);
                Some(*sum)
            })
            .collect();
        Self {
            shot,
            lights,
            sums,
            seed,
        }
    }

    /// A light and the reciprocal of its probability.
    fn choose(&self, rng: &mut Rng) -> Option<(usize, f32)> {
        let total = *self.sums.last()?;
        let target = rng.next_f64() * total;
        let light = self.sums.partition_point(|&s| s <= target);
        let light = light.min(self.sums.len() - 1);
        let before = if light == 0 {
            0.0
        } else {
            self.sums[light - 1]
        };
        Some((light, (total / (self.sums[light] - before)) as f32))
    }
}

impl ShadingFunction for OneLight<'_> {
    fn pixels(&self, caster: &Caster, first_pixel: u32, pass: u32, out: &mut [[f32; 3]]) -> u64 {
        let shot = self.shot;
        each_pixel(first_pixel, out, |pixel| {
            let sample = pass % shot.spp;
            let Some(seen) = shot.look(caster, pixel, sample) else {
                return background(shot, caster, pixel, sample);
            };
            let to = receiver(shot, &seen);
            let mut sum = shot.paths.lights().emitted(&to.at);
            let mut rng = Rng::new(self.seed, STREAM, u64::from(pixel), u64::from(pass));
            if let Some((light, factor)) = self.choose(&mut rng) {
                let lit = self.lights.unoccluded(&to, light);
                if lit != Vec3::ZERO && !self.lights.occluded(caster, &to, light) {
                    sum += lit * factor;
                }
            }
            sum * seen.throughput
        })
    }
}

/// The environment where a camera sample sees no surface, through mirrors and glass as well.
fn background(shot: &Shot, caster: &Caster, pixel: u32, sample: u32) -> Vec3 {
    match shot.look_out(caster, pixel, sample) {
        Ok(_) => Vec3::ZERO,
        Err(missed) => missed.throughput * shot.paths.lights().environment(missed.direction),
    }
}

/// Adds the environment to an image of surfaces.
pub fn add_background(shot: &Shot, image: &mut Image) {
    if shot.scene.environment.is_none() {
        return;
    }
    let counter = RayCounter::default();
    let rows = image.pixels.par_chunks_mut(shot.width).enumerate();
    rows.for_each(|(y, row)| {
        let caster = shot.tracer.caster(&counter);
        for (pixel, value) in (y as u32 * shot.width as u32..).zip(row) {
            let samples = (0..shot.spp).filter(|&s| shot.look(&caster, pixel, s).is_none());
            let sum: Vec3 = samples.map(|s| background(shot, &caster, pixel, s)).sum();
            *value = (Vec3::from(*value) + sum / shot.spp as f32).into();
        }
    });
}
