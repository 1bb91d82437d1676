//! Images of contenders: every camera sample lit by the budget's lights or samples.

use glam::Vec3;
use rayon::prelude::*;

use super::super::{Contender, Rendered, Seen, Stages};
use super::Parameters;
use super::illumination::{Illumination, Parallel};
use super::multiple::{MultipleImportance, Samples};
use super::upsampling::{Feature, Grid, Upsampled, upsample};
use crate::environment::{EnvironmentSampler, LightKind, LightSampler, LightSet};
use crate::image::Image;
use crate::trace::{Caster, RayCounter};

/// Renders a contender whose budget is shadow rays per shading point.
pub(super) fn render(
    illumination: &Illumination,
    parameters: &Parameters,
    (sampler, contender): (&EnvironmentSampler, &Contender),
) -> Result<Rendered, String> {
    let counter = RayCounter::default();
    let mut rendered = match sampler {
        EnvironmentSampler::PerPoint(mis) => {
            let rays = contender.budget as u32;
            let samples = Samples {
                light: rays.div_ceil(2),
                surface: rays / 2,
                stratified: mis.stratified,
            };
            let estimator = MultipleImportance::new(illumination, samples, contender.seed)
                .compensated(mis.compensated);
            let mut stages = Stages::default();
            let (image, non_finite) = stages.time("rendering", || {
                film(
                    illumination,
                    &counter,
                    &|caster, pixel, sample| match illumination.point(caster, pixel, sample) {
                        Ok((at, seen)) => {
                            seen.throughput * estimator.radiance(caster, &at, [pixel, sample])
                        }
                        Err(radiance) => radiance,
                    },
                )
            });
            Rendered {
                image,
                non_finite,
                stages,
                ..Rendered::default()
            }
        }
        EnvironmentSampler::Lights(sampler) => Global {
            illumination,
            parameters,
            counter: &counter,
        }
        .render(sampler.as_ref(), contender),
    };
    rendered.rays = counter.read();
    rendered.bytes_peak = illumination.frame.tracer.bytes() + illumination.environment.bytes();
    Ok(rendered)
}

/// Averages the sub-pixel samples of every pixel; returns the number of non-finite ones, which are
/// left black.
fn film(
    illumination: &Illumination,
    counter: &RayCounter,
    radiance: &(dyn Fn(&Caster, u32, u32) -> Vec3 + Sync),
) -> (Image, u64) {
    let frame = illumination.frame;
    let mut image = Image::new(frame.width, frame.height);
    let non_finite = image
        .pixels
        .par_chunks_mut(frame.width)
        .enumerate()
        .map(|(y, row)| {
            let caster = frame.tracer.caster(counter);
            let mut non_finite = 0;
            for (x, value) in row.iter_mut().enumerate() {
                let pixel = (y * frame.width + x) as u32;
                let mut sum = Vec3::ZERO;
                for sample in 0..frame.spp {
                    let value = radiance(&caster, pixel, sample);
                    if value.is_finite() {
                        sum += value / frame.spp as f32;
                    } else {
                        non_finite += 1;
                    }
                }
                *value = sum.into();
            }
            non_finite
        })
        .sum();
    (image, non_finite)
}

/// Position of a pixel's light set in the 4×2 pattern of interleaved sampling; the sub-pixel samples
/// of a pixel take different ones.
pub(super) fn set_of([x, y]: [usize; 2], sample: u32, sets: usize) -> usize {
    /// Neighbours are far apart in the order of sets.
    const PATTERN: [[usize; 4]; 2] = [[0, 4, 2, 6], [5, 1, 7, 3]];
    (PATTERN[y % 2][x % 4] + 3 * sample as usize) % sets
}

/// A contender with one light set for all points.
struct Global<'a> {
    illumination: &'a Illumination<'a>,
    parameters: &'a Parameters,
    counter: &'a RayCounter,
}

impl Global<'_> {
    fn render(&self, sampler: &dyn LightSampler, contender: &Contender) -> Rendered {
        let map = self.illumination.environment;
        let mut rendered = Rendered::default();
        let (set, versions) = rendered.stages.time("light_generation", || {
            let count = sampler.affordable(map, contender.budget);
            let set = sampler.lights(map, count, contender.seed);
            let Parameters {
                interleaved_sets,
                perturbation,
                ..
            } = *self.parameters;
            let versions = set.interleaved(interleaved_sets, perturbation, contender.seed);
            (set, versions)
        });
        let of_kind = |low: bool| -> Vec<Vec<Parallel>> {
            let reduced = sampler.reduction() > 1;
            let chosen = |kind| (reduced && kind == LightKind::Indirect) == low;
            versions
                .iter()
                .map(|lights| {
                    let lights = lights.iter().filter(|l| chosen(l.kind));
                    self.illumination.parallel(lights)
                })
                .collect()
        };
        let (full, low) = (of_kind(false), of_kind(true));
        if low.iter().all(Vec::is_empty) {
            let (image, non_finite) = rendered
                .stages
                .time("rendering", || self.full_resolution(&full));
            rendered.image = image;
            rendered.non_finite = non_finite;
        } else {
            self.reduced(&[full, low], sampler.reduction(), &mut rendered);
        }
        describe(&mut rendered, set);
        rendered
    }

    fn full_resolution(&self, sets: &[Vec<Parallel>]) -> (Image, u64) {
        let width = self.illumination.frame.width;
        film(
            self.illumination,
            self.counter,
            &|caster, pixel, sample| match self.illumination.point(caster, pixel, sample) {
                Ok((at, seen)) => {
                    let position = [pixel as usize % width, pixel as usize / width];
                    let lights = &sets[set_of(position, sample, sets.len())];
                    seen.throughput * self.illumination.lit(caster, &at, lights)
                }
                Err(radiance) => radiance,
            },
        )
    }

    /// The first sets at every pixel, the second ones at every `reduction`-th row and column, from
    /// where their light is carried to the pixels between.
    fn reduced(&self, sets: &[Vec<Vec<Parallel>>; 2], reduction: usize, rendered: &mut Rendered) {
        let frame = self.illumination.frame;
        let mut sums = vec![Vec3::ZERO; frame.pixels()];
        let (mut fallbacks, mut underflows) = (0u64, 0u64);
        for sample in 0..frame.spp {
            let grid = Grid::new(frame, reduction, sample);
            let shaded: Vec<Shaded> = rendered
                .stages
                .time("rendering", || self.shade(sets, &grid, sample));
            let carried = rendered.stages.time("upsampling", || {
                let features = self.features(&shaded);
                let low: Vec<Vec3> = grid
                    .pixels()
                    .map(|pixel| shaded[pixel as usize].indirect)
                    .collect();
                let from_low = upsample(frame, &grid, (&features, &low));
                self.fill_gaps(&sets[1], &shaded, (from_low, sample))
            });
            for ((sum, own), carried) in sums.iter_mut().zip(&shaded).zip(&carried.values) {
                let value = own.direct + *carried;
                if value.is_finite() {
                    *sum += value / frame.spp as f32;
                } else {
                    rendered.non_finite += 1;
                }
            }
            fallbacks += carried.fallbacks;
            underflows += carried.underflows;
        }
        rendered.image = Image {
            width: frame.width,
            height: frame.height,
            pixels: sums.into_iter().map(Into::into).collect(),
        };
        let samples = frame.pixels() as f64 * f64::from(frame.spp);
        rendered.found.extend([
            ("upsampling_fallbacks", fallbacks as f64 / samples),
            ("upsampling_underflows", underflows as f64 / samples),
        ]);
    }

    /// Direct light of every pixel, and indirect light of those on the grid.
    fn shade(&self, sets: &[Vec<Vec<Parallel>>; 2], grid: &Grid, sample: u32) -> Vec<Shaded> {
        let illumination = self.illumination;
        let frame = illumination.frame;
        let mut shaded = vec![Shaded::default(); frame.pixels()];
        shaded
            .par_chunks_mut(frame.width)
            .enumerate()
            .for_each(|(y, row)| {
                let caster = frame.tracer.caster(self.counter);
                for (x, out) in row.iter_mut().enumerate() {
                    let pixel = (y * frame.width + x) as u32;
                    let (at, seen) = match illumination.point(&caster, pixel, sample) {
                        Ok(surface) => surface,
                        Err(radiance) => {
                            out.direct = radiance;
                            continue;
                        }
                    };
                    out.seen = Some(seen);
                    let direct = &sets[0][set_of([x, y], sample, sets[0].len())];
                    out.direct = seen.throughput * illumination.lit(&caster, &at, direct);
                    if let Some(position) = grid.position(x, y) {
                        let indirect = &sets[1][set_of(position, sample, sets[1].len())];
                        out.indirect = illumination.lit(&caster, &at, indirect);
                    }
                }
            });
        shaded
    }

    fn features(&self, shaded: &[Shaded]) -> Vec<Option<Feature>> {
        shaded
            .par_iter()
            .map(|own| {
                let seen = own.seen.as_ref()?;
                let at = self.illumination.surface(seen);
                Some(Feature::new(&at, seen.depth))
            })
            .collect()
    }

    /// Shades the surface pixels that no neighbour on the grid could serve.
    fn fill_gaps(
        &self,
        sets: &[Vec<Parallel>],
        shaded: &[Shaded],
        (from_low, sample): (Upsampled, u32),
    ) -> Carried {
        let frame = self.illumination.frame;
        let values: Vec<Vec3> = from_low
            .values
            .par_iter()
            .zip(shaded)
            .enumerate()
            .map(|(pixel, (value, own))| match (value, &own.seen) {
                (_, None) => Vec3::ZERO,
                (Some(value), Some(seen)) => seen.throughput * *value,
                (None, Some(seen)) => {
                    let caster = frame.tracer.caster(self.counter);
                    let at = self.illumination.surface(seen);
                    let position = [pixel % frame.width, pixel / frame.width];
                    let lights = &sets[set_of(position, sample, sets.len())];
                    seen.throughput * self.illumination.lit(&caster, &at, lights)
                }
            })
            .collect();
        let gaps = from_low.values.iter().zip(shaded);
        Carried {
            values,
            fallbacks: gaps
                .filter(|(v, s)| v.is_none() && s.seen.is_some())
                .count() as u64,
            underflows: from_low.underflows,
        }
    }
}

/// A pixel under both kinds of lights.
#[derive(Clone, Copy, Default)]
struct Shaded {
    /// The background's radiance where nothing was hit.
    direct: Vec3,
    /// On the grid only; without the throughput.
    indirect: Vec3,
    seen: Option<Seen>,
}

/// Indirect light of every pixel.
struct Carried {
    values: Vec<Vec3>,
    fallbacks: u64,
    underflows: u64,
}

fn describe(rendered: &mut Rendered, set: LightSet) {
    rendered.found.extend(set.found.iter().copied());
    rendered.notes.extend(set.notes.iter().cloned());
    rendered.lights = Some(set);
}

#[cfg(test)]
mod tests {
    use super::set_of;

    #[test]
    fn every_tile_uses_every_set() {
        for sample in 0..4 {
            let mut seen = [0; 8];
            for y in 6..8 {
                for x in 4..8 {
                    seen[set_of([x, y], sample, 8)] += 1;
                }
            }
            assert_eq!(seen, [1; 8]);
        }
        let of_pixel: Vec<usize> = (0..4).map(|s| set_of([3, 1], s, 8)).collect();
        assert!((1..4).all(|s| !of_pixel[..s].contains(&of_pixel[s])));
        assert_eq!(set_of([3, 1], 2, 1), 0);
    }
}
