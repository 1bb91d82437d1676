//! Path tracing: a technique of its own, whose contenders trace fewer paths, and the truth of others.

use glam::Vec3;

use super::{
    ContenderEntry, RAYS_PER_PIXEL, SAMPLES, SECONDS, ShadingFunction, Shot, Started, Technique,
    TechniqueEntry, Terms, each_pixel, path_samples, running_mean,
};
use crate::entry::{About, Bias, ParameterError, parameters};
use crate::sample::Rng;
use crate::scene::{Needs, Scene};
use crate::shade::Depths;
use crate::suggest::advice;
use crate::trace::Caster;

/// Keys the random numbers of the reference's paths.
const STREAM: u64 = 0x7472_7574_6800;
/// Keys those of contenders.
const CONTENDER_STREAM: u64 = 0x6366_6e74_6472;

/// What path tracing compares.
static CONTENDERS: &[ContenderEntry<Truth>] = &[path_samples::ENTRY, running_mean::ENTRY];

/// The registry's entry of path tracing.
pub const PATH_TRACING: TechniqueEntry = TechniqueEntry {
    about: About {
        id: "path-tracing",
        module: crate::entry::head_comment!("truth.rs"),
        aliases: &["pt"],
        summary: "path tracing with next-event estimation, to the scene's max_depth",
        source: "Kajiya 1986; Veach 1997, power heuristic",
        bias: Bias::Unbiased,
        version: 3,
        failures: &["caustics of small lights through smooth glass converge slowly"],
        parameters: Parameters::PARAMETERS,
    },
    build: |table| {
        Ok(Box::new(Truth {
            may_hide_lights: true,
            ..Truth::new(table, None, CONTENDERS)?
        }))
    },
    contenders: || CONTENDERS.iter().map(ContenderEntry::listed).collect(),
    units: &[&SAMPLES, &SECONDS, &RAYS_PER_PIXEL],
    default_method: "reference",
    of_contenders: &[],
};

parameters! {
    /// Parameters of path-traced truths.
    #[derive(Clone, Debug)]
    pub(super) struct Parameters {
        /// Seed of the camera paths.
        seed: u64 = 1, AtLeast(0.0);
        /// Paths of each pixel of the reference; without it spp.
        reference_passes: Option<u32> = None, Within(1.0, u32::MAX as f64);
    }
}

/// A path-traced technique.
pub struct Truth {
    parameters: Parameters,
    /// Replaces the scene's.
    max_depth: Option<u32>,
    contenders: &'static [ContenderEntry<Truth>],
    /// Whether lights are out of sight in scenes that ask for it: not where others are compared with it, which see them.
    may_hide_lights: bool,
}

impl Truth {
    pub(super) fn new(
        table: &toml::Table,
        max_depth: Option<u32>,
        contenders: &'static [ContenderEntry<Truth>],
    ) -> Result<Self, ParameterError> {
        Ok(Self {
            parameters: Parameters::read(table)?,
            max_depth,
            contenders,
            may_hide_lights: false,
        })
    }

    /// The paths of a contender, independent of the reference's.
    pub(super) fn contender_paths<'a>(&self, shot: &'a Shot<'a>, seed: u64) -> TracedPaths<'a> {
        TracedPaths {
            shot,
            stream: CONTENDER_STREAM,
            seed,
            max_depth: self.max_depth.unwrap_or(shot.scene.max_depth),
            hides_lights: self.may_hide_lights && shot.scene.hides_lights,
        }
    }
}

impl Technique for Truth {
    fn needs(&self) -> Needs {
        Needs::ALL
    }

    fn shading_function<'a>(&'a self, shot: &'a Shot<'a>) -> Box<dyn ShadingFunction + 'a> {
        Box::new(TracedPaths {
            shot,
            stream: STREAM,
            seed: self.parameters.seed,
            max_depth: self.max_depth.unwrap_or(shot.scene.max_depth),
            hides_lights: self.may_hide_lights && shot.scene.hides_lights,
        })
    }

    fn exposure_stops(&self, scene: &Scene) -> f32 {
        scene.exposure.log2()
    }

    fn reference_samples(&self, spp: u32) -> u32 {
        self.parameters.reference_passes.unwrap_or(spp)
    }

    fn reference_is_random(&self) -> bool {
        true
    }

    fn rays_per_evaluation(&self) -> u64 {
        1
    }

    fn start<'a>(
        &'a self,
        id: &str,
        parameters: &toml::Table,
        terms: Terms,
    ) -> Result<Started<'a>, ParameterError> {
        match self.contenders.iter().find(|e| e.about.answers_to(id)) {
            Some(entry) => entry.started(self, parameters, terms),
            None => {
                let known: Vec<&str> = self.contenders.iter().map(|e| e.about.id).collect();
                let message = format!("no contender is called `{id}`; {}", advice(id, &known));
                Err(ParameterError::new("id", message))
            }
        }
    }
}

/// One path per pixel and sample, uniformly jittered in the pixel.
pub(super) struct TracedPaths<'a> {
    shot: &'a Shot<'a>,
    /// Keys the random numbers, with the seed.
    stream: u64,
    seed: u64,
    max_depth: u32,
    hides_lights: bool,
}

impl ShadingFunction for TracedPaths<'_> {
    fn pixels(&self, caster: &Caster, first_pixel: u32, sample: u32, out: &mut [[f32; 3]]) -> u64 {
        let width = self.shot.width;
        each_pixel(first_pixel, out, |pixel| {
            let mut rng = Rng::new(self.seed, self.stream, u64::from(pixel), u64::from(sample));
            let x = (pixel as usize % width) as f64 + rng.next_f64();
            let y = (pixel as usize / width) as f64 + rng.next_f64();
            let ray = self.shot.ray_through(x, y);
            let depths = Depths {
                hides_sky: self.hides_lights,
                ..Depths::up_to(self.max_depth)
            };
            let paths = &self.shot.paths;
            if !self.hides_lights {
                return paths.radiance(caster, ray, &mut rng, depths).into();
            }
            match paths.behind_lights(caster, ray) {
                Some((ray, hit)) => paths.follow(caster, ray, Some(hit), &mut rng, depths),
                None => Vec3::ZERO,
            }
        })
    }
}
