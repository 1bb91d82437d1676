//! Images of contenders: every camera sample lit by the budget's lights or samples.

use glam::Vec3;
use rayon::prelude::*;

use super::super::{Rendered, Stages, Terms};
use super::illumination::{Illumination, Parallel};
use super::interleaving::set_of;
use super::multiple::{MultipleImportance, Samples};
use super::product;
use super::reduced::{Reduced, indirect_cost};
use super::{Parameters, Sampled};
use crate::environment::{EnvironmentSampler, LightKind, LightSampler, LightSet};
use crate::image::Image;
use crate::memory::released;
use crate::trace::{Caster, RayCounter};

/// Renders a contender whose budget is shadow rays per shading point.
pub(super) fn render(illumination: &Illumination, job: &Sampled) -> Rendered {
    let terms = &job.terms;
    let counter = RayCounter::default();
    let mut rendered = match &job.sampler {
        EnvironmentSampler::PerPoint(mis) => {
            let rays = terms.budget as u32;
            let samples = Samples {
                light: rays.div_ceil(2),
                surface: rays / 2,
                stratified: mis.stratified,
            };
            let estimator = MultipleImportance::new(illumination, samples, terms.seed)
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
        EnvironmentSampler::Product {
            parameters,
            unbiased,
        } => product::render(illumination, parameters, *unbiased, terms, &counter),
        EnvironmentSampler::Lights(sampler) => Global {
            illumination,
            parameters: &job.technique.parameters,
            counter: &counter,
        }
        .render(sampler.as_ref(), terms),
    };
    rendered.rays = counter.read();
    rendered
}

/// Averages the sub-pixel samples of every pixel; returns the number of non-finite ones, which are
/// left black.
fn film(
    illumination: &Illumination,
    counter: &RayCounter,
    radiance: &(dyn Fn(&Caster, u32, u32) -> Vec3 + Sync),
) -> (Image, u64) {
    let shot = illumination.shot;
    let mut image = Image::new(shot.width, shot.height);
    let non_finite = image
        .pixels
        .par_chunks_mut(shot.width)
        .enumerate()
        .map(|(y, row)| {
            let caster = shot.tracer.caster(counter);
            let mut non_finite = 0;
            for (x, value) in row.iter_mut().enumerate() {
                let pixel = (y * shot.width + x) as u32;
                let mut sum = Vec3::ZERO;
                for sample in 0..shot.spp {
                    let value = radiance(&caster, pixel, sample);
                    if value.is_finite() {
                        sum += value / shot.spp as f32;
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

/// A contender with one light set for all points.
struct Global<'a> {
    illumination: &'a Illumination<'a>,
    parameters: &'a Parameters,
    counter: &'a RayCounter,
}

impl Global<'_> {
    fn render(&self, sampler: &dyn LightSampler, terms: &Terms) -> Rendered {
        let map = self.illumination.environment.for_lights();
        let mut rendered = Rendered::default();
        let cost = rendered.stages.time("upsampling", || {
            indirect_cost(
                self.illumination,
                sampler.reduction(),
                terms.budget,
                self.counter,
            )
        });
        let (set, versions) = rendered.stages.time("light_generation", || {
            let set = sampler.lights_within(&map, terms.budget, cost, terms.seed);
            let Parameters {
                interleaved_sets,
                perturbation,
                ..
            } = *self.parameters;
            let versions = set.interleaved(interleaved_sets, perturbation, terms.seed);
            (set, versions)
        });
        let of_kind = |low: bool| -> Vec<Vec<Parallel>> {
            let reduced = sampler.reduction() > 1;
            let chosen =
                |kind| sampler.shades(kind) && (reduced && kind == LightKind::Indirect) == low;
            versions
                .iter()
                .map(|lights| {
                    let lights = lights.iter().filter(|l| chosen(l.kind));
                    self.illumination.parallel(lights)
                })
                .collect()
        };
        let sets = [of_kind(false), of_kind(true)];
        let [full, low] = &sets;
        if low.iter().all(Vec::is_empty) {
            let (image, non_finite) = rendered
                .stages
                .time("rendering", || self.full_resolution(full));
            rendered.image = image;
            rendered.non_finite = non_finite;
        } else {
            Reduced {
                illumination: self.illumination,
                counter: self.counter,
                rays: terms.budget,
                sets: &sets,
            }
            .render(sampler.reduction(), &mut rendered);
        }
        rendered.bytes_cache = released(sets);
        describe(&mut rendered, set);
        let texels = map.width() * map.height();
        if texels < terms.budget {
            rendered.notes.push(format!(
                "{} lights stand for whole texels of the map, {texels} in all: a finer map gives better ones",
                terms.budget
            ));
        }
        rendered
    }

    fn full_resolution(&self, sets: &[Vec<Parallel>]) -> (Image, u64) {
        let width = self.illumination.shot.width;
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
}

fn describe(rendered: &mut Rendered, set: LightSet) {
    rendered.found.extend(set.found.iter().copied());
    rendered.notes.extend(set.notes.iter().cloned());
    rendered.lights = Some(set);
}
