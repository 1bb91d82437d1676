//! Importance caching (Georgiev, Křivánek, Popov & Slusallek 2012; Wu & Shen, section 4.2).
//!
//! Direct and indirect light becomes a few thousand virtual point lights
//! ([`crate::shade::VirtualLights`]). The shading function is their sum with visibility, the
//! reference evaluates it at every sample. A record knows what each light sends to it, as four
//! distributions; at a camera sample the distributions of the records around it choose one light
//! each, and only those four are evaluated there, so records steer the noise and never the mean.
//!
//! Emission that the camera sees, and the environment behind everything, are exact and without noise
//! in contenders and reference alike.
//!
//! With `reference = "paths"` the reference, and the contender without records, are path traced in place
//! of summing or sampling the lights: errors then hold what the lights lack as well, and tell when
//! records beat path tracing.
//!
//! *differs:* the ball that the bound of a record covers is a share of the distance to the record's
//! M-th nearest, not the footprint of a record in the image, so that it fits any distribution.

mod distributions;
mod estimator;
mod exact;
mod records;
#[cfg(test)]
mod tests;

use toml::Table;

use self::distributions::Distributions;
use self::estimator::{Heuristic, KINDS, Rule};
use self::records::{ImportanceRecords, Settings};
use super::cached::{self, CachedTechnique};
use super::paths::{LayerPaths, RAYS_PER_SAMPLE, indirect};
use super::{CACHES, Started, TechniqueEntry, Terms};
use super::{CachedFunction, Lookup, Rendered, ShadingFunction, Shot, Technique};
use crate::cache::Interpolation;
use crate::entry::{About, Bias, ParameterError, parameters, words};
use crate::scene::{Needs, Scene};
use crate::shade::{VirtualLights, VplOptions};
use crate::trace::RayCounter;

/// The registry's entry.
pub const ENTRY: TechniqueEntry = TechniqueEntry {
    about: About {
        id: "importance-caching",
        module: crate::entry::head_comment!("mod.rs"),
        aliases: &["imc"],
        summary: "virtual point lights, sampled by what records around the point received of them",
        source: "Georgiev et al. 2012; Keller 1997; Wu & Shen, section 4.2",
        bias: Bias::Unbiased,
        version: 2,
        failures: &[
            "unbiased for the sum over the virtual lights, which lacks light that the clamped \
             distance takes away in corners and light that arrives by mirrors or glass",
            "lights that no record near the point received are left to the uniform distribution, \
             which is noisy",
            "highlights and lights close by that no record near the point has are rare and bright: \
             a few such pixels decide the RMSE of an image",
        ],
        parameters: Parameters::PARAMETERS,
    },
    build: |table| Ok(Box::new(ImportanceCaching::new(Parameters::read(table)?))),
    contenders: cached::listed,
    units: &[&CACHES],
    default_method: "VGC+DGS",
    of_contenders: &["heuristic", "alpha", "bound_radius", "lookup"],
};

words! {
    /// What references, and the contender without records, are made of.
    pub enum Reference {
        /// The virtual lights: their sum, and one of them by its power.
        Lights = "lights",
        /// Path tracing of all light.
        Paths = "paths",
    }
}

parameters! {
    /// Parameters of the technique.
    #[derive(Clone, Debug)]
    pub struct Parameters {
        /// Wanted number of virtual point lights; the set comes close to it.
        pub lights: usize = 8192, Within(1.0, 1_048_576.0);
        /// Seed of the virtual point lights, shared by reference and contenders.
        pub seed: u64 = 1, AtLeast(0.0);
        /// Least distance to a light in the geometry term, in reference and contenders.
        pub clamp: f32 = 0.01, Within(0.0, 1.0), "diagonals";
        /// What references and per-sample are made of: lights (their sum, and one of them) or paths.
        pub reference: Reference = Reference::Lights;
        /// Paths of each pixel of a reference of paths.
        pub reference_passes: u32 = 512, Within(1.0, u32::MAX as f64);
        /// How the samples of the four distributions are combined.
        pub heuristic: Heuristic = Heuristic::Balance;
        /// Confidence in the full, unoccluded, bounded and conservative distribution (alpha-max); without confidence
        /// in a distribution its lights would be lost.
        pub alpha: [f32; KINDS] = [1.0; KINDS], AboveUpTo(0.0, 1.0);
        /// Radius of the ball that the bounded distribution covers, in distances of a record to its M-th nearest.
        pub bound_radius: f32 = 0.5, Within(0.0, 1.0);
        /// The run-time rule.
        pub lookup: Lookup = Lookup::default();
    }
}

/// The technique `importance-caching`.
pub struct ImportanceCaching {
    parameters: Parameters,
}

impl ImportanceCaching {
    /// The technique with its parameters.
    pub fn new(parameters: Parameters) -> Self {
        Self { parameters }
    }

    /// No records yet, of a shot.
    fn records<'a>(&self, shot: &'a Shot<'a>, seed: u64) -> ImportanceRecords<'a> {
        let rule = Rule {
            heuristic: self.parameters.heuristic,
            alpha: self.parameters.alpha,
        };
        let settings = Settings {
            rule,
            lookup: self.parameters.lookup,
            bound_radius: self.parameters.bound_radius,
            seed,
        };
        ImportanceRecords::new(shot, self.lights(shot), settings)
    }

    /// The lights of a shot: a function of the scene and the technique's own seed.
    fn lights<'a>(&self, shot: &'a Shot<'a>) -> VirtualLights<'a> {
        let options = VplOptions {
            count: self.parameters.lights,
            seed: self.parameters.seed,
            max_depth: shot.scene.max_depth,
            clamp: self.parameters.clamp,
        };
        // A few rays for each light, the same for all contenders: not charged.
        VirtualLights::new(&shot.paths, &options, &RayCounter::default())
    }
}

/// Seed of references of paths.
const REFERENCE_SEED: u64 = 0;

/// All light, path traced.
fn paths<'a>(shot: &'a Shot<'a>, seed: u64) -> LayerPaths<'a> {
    LayerPaths {
        shot,
        direct: true,
        indirect: Some(indirect(shot)),
        seed,
    }
}

impl Technique for ImportanceCaching {
    fn needs(&self) -> Needs {
        Needs::ALL
    }

    fn shading_function<'a>(&'a self, shot: &'a Shot<'a>) -> Box<dyn ShadingFunction + 'a> {
        match self.parameters.reference {
            Reference::Lights => Box::new(exact::AllLights::new(shot, self.lights(shot))),
            Reference::Paths => Box::new(paths(shot, REFERENCE_SEED)),
        }
    }

    fn exposure_stops(&self, scene: &Scene) -> f32 {
        scene.exposure.log2()
    }

    fn reference_samples(&self, spp: u32) -> u32 {
        match self.parameters.reference {
            Reference::Lights => spp,
            Reference::Paths => self.parameters.reference_passes.next_multiple_of(spp),
        }
    }

    fn reference_is_random(&self) -> bool {
        self.parameters.reference == Reference::Paths
    }

    fn rays_per_reference_sample(&self) -> u64 {
        match self.parameters.reference {
            Reference::Lights => 1 + self.parameters.lights as u64,
            Reference::Paths => RAYS_PER_SAMPLE,
        }
    }

    fn rays_per_evaluation(&self) -> u64 {
        self.parameters.lights as u64
    }

    fn bytes_per_record(&self) -> u64 {
        Distributions::bytes_per_record(self.parameters.lights) as u64
    }

    fn start<'a>(
        &'a self,
        id: &str,
        parameters: &Table,
        terms: Terms,
    ) -> Result<Started<'a>, ParameterError> {
        cached::start(self, id, parameters, terms)
    }
}

impl CachedTechnique for ImportanceCaching {
    fn accepts(&self, interpolation: &Interpolation) -> Result<(), ParameterError> {
        if interpolation.gradient().is_none() {
            return Ok(());
        }
        Err(ParameterError::new(
            "interpolation",
            "importance caching samples by its records and interpolates no values: set \
             interpolation = \"inverse-distance\"",
        ))
    }

    fn function<'a>(
        &'a self,
        shot: &'a Shot<'a>,
        _: Interpolation,
        seed: u64,
    ) -> (Box<dyn CachedFunction + 'a>, Lookup) {
        (Box::new(self.records(shot, seed)), self.parameters.lookup)
    }

    fn estimator<'a>(&'a self, shot: &'a Shot<'a>, seed: u64) -> Box<dyn ShadingFunction + 'a> {
        match self.parameters.reference {
            Reference::Lights => Box::new(exact::OneLight::new(shot, self.lights(shot), seed)),
            Reference::Paths => Box::new(paths(shot, seed)),
        }
    }

    fn is_noisy(&self) -> bool {
        true
    }

    fn finish(&self, shot: &Shot, rendered: &mut Rendered) {
        exact::add_background(shot, &mut rendered.image);
        if shot.paths.lights().is_dark() {
            let note = "nothing shines in this scene: all images are black";
            rendered.notes.push(note.into());
        }
    }
}
