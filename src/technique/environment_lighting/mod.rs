//! Direct light of an environment map on diffuse to glossy surfaces, with shadow rays.
//!
//! All samplers share one shading path: a `Point` is what a camera sample sees, `Illumination`
//! lights it by parallel lights or by sampling the map. Emitting shapes and other lights are not
//! looked at, and light passes no glass. Where the camera sees no surface it sees the map.

mod exposure;
mod illumination;
mod interleaving;
mod multiple;
mod product;
mod reduced;
mod rendering;
mod replay;
mod reservoirs;
mod upsampling;

use toml::Table;

use super::{
    Contender, LIGHTS, Listed, RAYS_PER_PIXEL, Rendered, SECONDS, ShadingFunction, Shot, Started,
    Technique, TechniqueEntry, Terms,
};
use crate::entry::{About, Bias, ParameterError, parameters};
use crate::environment::{
    ENVIRONMENT_SAMPLERS, EnvironmentSampler, SamplerEntry, environment_sampler,
};
use crate::scene::{Needs, Scene, SceneDescription};
use crate::suggest::advice;
use crate::trace::Caster;
use illumination::Illumination;
use multiple::{MultipleImportance, Samples};

/// The registry's entry.
pub const ENTRY: TechniqueEntry = TechniqueEntry {
    about: About {
        id: "environment-lighting",
        module: crate::entry::head_comment!("mod.rs"),
        aliases: &["environment"],
        summary: "direct light of an environment map, with shadows, under any sampler",
        source: "Wu 2024; Kollig & Keller 2003 for interleaved sampling",
        bias: Bias::Unbiased,
        version: 1,
        failures: &[
            "global light sets leave shadow edges, and highlights of single lights on very glossy surfaces",
            "only the map shines, and once: no bounces, no emitting shapes, no point, spot and directional lights, no light through glass",
        ],
        parameters: Parameters::PARAMETERS,
    },
    build: |table| {
        Ok(Box::new(EnvironmentLighting {
            parameters: Parameters::read(table)?,
        }))
    },
    contenders: || {
        let listed = |entry: &'static SamplerEntry| Listed {
            id: entry.about.id.to_owned(),
            parts: vec![&entry.about],
        };
        let reservoirs = reservoirs::VARIANTS.iter().map(|variant| Listed {
            id: variant.about.id.to_owned(),
            parts: vec![variant.about],
        });
        let samplers = ENVIRONMENT_SAMPLERS.iter().map(listed);
        samplers.chain(reservoirs).collect()
    },
    units: &[&LIGHTS, &SECONDS, &RAYS_PER_PIXEL],
    default_method: "decomposition",
    of_contenders: &[],
};

parameters! {
    /// Parameters of the technique, shared by reference and contenders.
    #[derive(Clone, Debug)]
    struct Parameters {
        /// Light samples, and as many surface samples, of the reference: at least reference_passes.
        reference_samples: u32 = 4096, Within(1.0, 1_048_576.0);
        /// Independent parts of the reference, whose spread is its noise.
        reference_passes: u32 = 16, Within(1.0, 4096.0);
        /// Light sets of global samplers, of which neighbouring pixels use different ones.
        interleaved_sets: usize = 8, Within(1.0, 64.0);
        /// Largest move of a light in the other sets, of its cluster's extent.
        perturbation: f64 = 0.1, Within(0.0, 1.0);
        /// Exposes images so that surfaces have this mean luminance; 0 keeps the scene's exposure.
        mean_luminance: f64 = 0.25, AtLeast(0.0);
    }
    check Parameters::check;
}

impl Parameters {
    fn check(&self) -> Result<(), ParameterError> {
        let (samples, passes) = (self.reference_samples, self.reference_passes);
        match samples < passes {
            false => Ok(()),
            true => Err(ParameterError::new(
                "reference_samples",
                format!(
                    "reference_samples = {samples}: expected at least reference_passes = {passes}"
                ),
            )),
        }
    }
}

/// The technique `environment-lighting`.
struct EnvironmentLighting {
    parameters: Parameters,
}

/// Keys the random numbers of the reference.
const REFERENCE_SEED: u64 = 0x656e_7672_6566;

/// A sampler at work.
struct Sampled<'a> {
    technique: &'a EnvironmentLighting,
    sampler: EnvironmentSampler,
    terms: Terms,
}

impl Contender for Sampled<'_> {
    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        let render = |shot| Ok(rendering::render(&illumination(shot)?, self));
        shots.iter().map(render).collect()
    }

    fn replay(&mut self, shot: &Shot, pixel: u32) -> Result<Vec<String>, String> {
        Ok(replay::replay(&illumination(shot)?, self, pixel))
    }
}

fn illumination<'a>(shot: &'a Shot<'a>) -> Result<Illumination<'a>, String> {
    Illumination::new(shot)
        .ok_or_else(|| "the scene has no environment; name one with `environment`".into())
}

impl Technique for EnvironmentLighting {
    fn needs(&self) -> Needs {
        Needs {
            emitters: false,
            ..Needs::ALL
        }
    }

    fn fits(&self, scene: &SceneDescription) -> Result<(), String> {
        match scene.environment {
            Some(_) => Ok(()),
            None => Err(format!(
                "{} needs an environment and scene `{}` has none: name a map, for example \
                 environment = \"afternoon\"; `lightbench list maps` shows them",
                ENTRY.about.id, scene.name
            )),
        }
    }

    fn shading_function<'a>(&'a self, shot: &'a Shot<'a>) -> Box<dyn ShadingFunction + 'a> {
        let parameters = &self.parameters;
        Box::new(Exact {
            illumination: Illumination::new(shot),
            spp: shot.spp,
            samples: Samples {
                light: parameters
                    .reference_samples
                    .div_ceil(parameters.reference_passes),
                surface: parameters
                    .reference_samples
                    .div_ceil(parameters.reference_passes),
                stratified: true,
            },
        })
    }

    fn exposure_stops(&self, scene: &Scene) -> f32 {
        if self.parameters.mean_luminance > 0.0 {
            0.0
        } else {
            scene.exposure.log2()
        }
    }

    fn reference_samples(&self, _spp: u32) -> u32 {
        self.parameters.reference_passes
    }

    fn reference_is_random(&self) -> bool {
        true
    }

    fn rays_per_evaluation(&self) -> u64 {
        2 * u64::from(self.parameters.reference_samples)
    }

    /// All sub-pixel samples of a pass count as one.
    fn rays_per_reference_sample(&self) -> u64 {
        let Parameters {
            reference_samples,
            reference_passes,
            ..
        } = self.parameters;
        1 + 2 * u64::from(reference_samples.div_ceil(reference_passes))
    }

    fn decides_exposure(&self) -> bool {
        self.parameters.mean_luminance > 0.0
    }

    fn exposure(&self, first: &Shot) -> f32 {
        match Illumination::new(first) {
            Some(illumination) if self.parameters.mean_luminance > 0.0 => {
                exposure::exposure(&illumination, self.parameters.mean_luminance)
            }
            _ => 1.0,
        }
    }

    fn start<'a>(
        &'a self,
        id: &str,
        parameters: &Table,
        terms: Terms,
    ) -> Result<Started<'a>, ParameterError> {
        let variants = reservoirs::VARIANTS;
        if let Some(variant) = variants.iter().find(|v| v.about.answers_to(id)) {
            return Ok(Started {
                id: variant.about.id.to_owned(),
                parts: vec![variant.about],
                contender: variant.start(parameters, terms)?,
            });
        }
        let entry = environment_sampler(id).ok_or_else(|| {
            let samplers = ENVIRONMENT_SAMPLERS.iter().map(|e| e.about.id);
            let known: Vec<&str> = samplers
                .chain(variants.iter().map(|v| v.about.id))
                .collect();
            let message = format!(
                "no sampler of environment maps is called `{id}`; {}",
                advice(id, &known)
            );
            ParameterError::new("id", message)
        })?;
        Ok(Started {
            id: entry.about.id.to_owned(),
            parts: vec![&entry.about],
            contender: Box::new(Sampled {
                technique: self,
                sampler: (entry.build)(parameters)?,
                terms,
            }),
        })
    }
}

/// The reference: in each pass all sub-pixel samples with a part of the light samples.
struct Exact<'a> {
    /// `None`: everything is black.
    illumination: Option<Illumination<'a>>,
    spp: u32,
    samples: Samples,
}

impl ShadingFunction for Exact<'_> {
    fn pixels(&self, caster: &Caster, first_pixel: u32, pass: u32, out: &mut [[f32; 3]]) -> u64 {
        let Some(illumination) = &self.illumination else {
            return 0;
        };
        let estimator = MultipleImportance::new(illumination, self.samples, REFERENCE_SEED);
        let mut non_finite = 0;
        for (pixel, value) in (first_pixel..).zip(out) {
            let mut sum = glam::Vec3::ZERO;
            for sample in 0..self.spp {
                let radiance = match illumination.point(caster, pixel, sample) {
                    Ok((at, seen)) => {
                        let key = [pixel, pass * self.spp + sample];
                        seen.throughput * estimator.radiance(caster, &at, key)
                    }
                    Err(radiance) => radiance,
                };
                if radiance.is_finite() {
                    sum += radiance / self.spp as f32;
                } else {
                    non_finite += 1;
                }
            }
            *value = sum.into();
        }
        non_finite
    }
}
