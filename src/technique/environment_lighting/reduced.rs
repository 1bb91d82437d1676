//! Indirect lights at reduced resolution (Wu 2024, section 3.4).
//!
//! Pixels that resemble no neighbour on the grid are shaded themselves; their share is measured before
//! lights are made, so that the budget of rays holds.

use glam::Vec3;
use rayon::prelude::*;

use super::super::{Rendered, Seen};
use super::illumination::{Illumination, Parallel};
use super::interleaving::set_of;
use super::upsampling::{Feature, Grid, upsample};
use crate::image::Image;
use crate::trace::RayCounter;

/// Shadow rays of an indirect light per surface pixel at this reduction and budget of rays: one for each block, and one
/// for each pixel that is shaded itself, as counted at the first sub-pixel sample.
pub(super) fn indirect_cost(
    illumination: &Illumination,
    reduction: usize,
    rays: usize,
    counter: &RayCounter,
) -> f64 {
    if reduction == 1 {
        return 1.0;
    }
    let grid = Grid::new(illumination.shot, reduction, 0);
    let features = features(illumination, &look(illumination, counter, 0));
    let low = vec![Vec3::ZERO; grid.pixels().count()];
    let carried = upsample(&grid, &features, &low, rays);
    let (mut surfaces, mut gaps) = (0u64, 0u64);
    for (feature, value) in features.iter().zip(&carried) {
        surfaces += u64::from(feature.is_some());
        gaps += u64::from(feature.is_some() && value.is_none());
    }
    let on_grid = grid.pixels().filter(|&p| features[p as usize].is_some());
    (on_grid.count() as f64 + gaps as f64) / surfaces.max(1) as f64
}

fn look(illumination: &Illumination, counter: &RayCounter, sample: u32) -> Vec<Option<Seen>> {
    let shot = illumination.shot;
    let mut seen = vec![None; shot.pixels()];
    seen.par_chunks_mut(shot.width)
        .enumerate()
        .for_each(|(y, row)| {
            let caster = shot.tracer.caster(counter);
            for (x, out) in row.iter_mut().enumerate() {
                *out = shot.look(&caster, (y * shot.width + x) as u32, sample);
            }
        });
    seen
}

fn features(illumination: &Illumination, seen: &[Option<Seen>]) -> Vec<Option<Feature>> {
    seen.par_iter()
        .map(|seen| {
            let seen = seen.as_ref()?;
            Some(Feature::new(&illumination.shot.surface(seen), seen.depth))
        })
        .collect()
}

/// A contender whose indirect lights are shaded on a grid.
pub(super) struct Reduced<'a> {
    pub illumination: &'a Illumination<'a>,
    pub counter: &'a RayCounter,
    /// Shadow rays per shading point.
    pub rays: usize,
    /// Interleaved sets of lights for every pixel, and of those for the grid.
    pub sets: &'a [Vec<Vec<Parallel>>; 2],
}

/// A pixel under both kinds of lights.
#[derive(Clone, Copy, Default)]
struct Shaded {
    /// The background's radiance where nothing was hit.
    direct: Vec3,
    /// On the grid only; without the throughput.
    indirect: Vec3,
}

impl Reduced<'_> {
    /// Fills in the image and what there is to tell.
    pub fn render(&self, reduction: usize, rendered: &mut Rendered) {
        let shot = self.illumination.shot;
        let mut sums = vec![Vec3::ZERO; shot.pixels()];
        let mut gaps = 0u64;
        for sample in 0..shot.spp {
            let grid = Grid::new(shot, reduction, sample);
            let (seen, shaded) = rendered
                .stages
                .time("rendering", || self.shade(&grid, sample));
            let carried = rendered.stages.time("upsampling", || {
                let features = features(self.illumination, &seen);
                let low: Vec<Vec3> = grid
                    .pixels()
                    .map(|pixel| shaded[pixel as usize].indirect)
                    .collect();
                upsample(&grid, &features, &low, self.rays)
            });
            gaps += count_gaps(&seen, &carried);
            let carried = rendered
                .stages
                .time("rendering", || self.fill_gaps(&seen, &carried, sample));
            for ((sum, own), carried) in sums.iter_mut().zip(&shaded).zip(&carried) {
                let value = own.direct + *carried;
                if value.is_finite() {
                    *sum += value / shot.spp as f32;
                } else {
                    rendered.non_finite += 1;
                }
            }
        }
        rendered.image = Image {
            width: shot.width,
            height: shot.height,
            pixels: sums.into_iter().map(Into::into).collect(),
        };
        let samples = shot.pixels() as f64 * f64::from(shot.spp);
        rendered
            .found
            .push(("upsampling_fallbacks", gaps as f64 / samples));
    }

    /// Direct light of every pixel, and indirect light of those on the grid.
    fn shade(&self, grid: &Grid, sample: u32) -> (Vec<Option<Seen>>, Vec<Shaded>) {
        let illumination = self.illumination;
        let shot = illumination.shot;
        let mut pixels = vec![(None, Shaded::default()); shot.pixels()];
        pixels
            .par_chunks_mut(shot.width)
            .enumerate()
            .for_each(|(y, row)| {
                let caster = shot.tracer.caster(self.counter);
                for (x, (seen_there, out)) in row.iter_mut().enumerate() {
                    let pixel = (y * shot.width + x) as u32;
                    let (at, seen) = match illumination.point(&caster, pixel, sample) {
                        Ok(surface) => surface,
                        Err(radiance) => {
                            out.direct = radiance;
                            continue;
                        }
                    };
                    *seen_there = Some(seen);
                    let [full, low] = self.sets;
                    let direct = &full[set_of([x, y], sample, full.len())];
                    out.direct = seen.throughput * illumination.lit(&caster, &at, direct);
                    if let Some(position) = grid.position(x, y) {
                        let indirect = &low[set_of(position, sample, low.len())];
                        out.indirect = illumination.lit(&caster, &at, indirect);
                    }
                }
            });
        pixels.into_iter().unzip()
    }

    /// Indirect light of all pixels: what was carried to them, or else shaded there.
    fn fill_gaps(&self, seen: &[Option<Seen>], carried: &[Option<Vec3>], sample: u32) -> Vec<Vec3> {
        let shot = self.illumination.shot;
        let sets = &self.sets[1];
        carried
            .par_iter()
            .zip(seen)
            .enumerate()
            .map_init(
                || shot.tracer.caster(self.counter),
                |caster, (pixel, (value, seen))| match (value, seen) {
                    (_, None) => Vec3::ZERO,
                    (Some(value), Some(seen)) => seen.throughput * *value,
                    (None, Some(seen)) => {
                        let at = self.illumination.shot.surface(seen);
                        let position = [pixel % shot.width, pixel / shot.width];
                        let lights = &sets[set_of(position, sample, sets.len())];
                        seen.throughput * self.illumination.lit(caster, &at, lights)
                    }
                },
            )
            .collect()
    }
}

fn count_gaps(seen: &[Option<Seen>], carried: &[Option<Vec3>]) -> u64 {
    let pairs = seen.iter().zip(carried);
    pairs.filter(|(s, v)| s.is_some() && v.is_none()).count() as u64
}
