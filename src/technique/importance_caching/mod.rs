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

use serde::{Deserialize, Serialize};
use toml::Table;

use self::distributions::Distributions;
use self::estimator::{Heuristic, KINDS, Rule};
use self::records::{ImportanceRecords, Settings};
use super::cached::{self, CachedTechnique};
use super::paths::{LayerPaths, RAYS_PER_SAMPLE, indirect};
use super::{CachedFunction, Lookup, Rendered, ShadingFunction, Shot, Technique};
use super::{Started, TechniqueEntry, Terms, Unit};
use crate::cache::Interpolation;
use crate::entry::{About, Bias, Parameter, ParameterError};
use crate::scene::{Needs, Scene};
use crate::shade::{VirtualLights, VplOptions};
use crate::trace::RayCounter;

/// The registry's entry.
pub const ENTRY: TechniqueEntry = TechniqueEntry {
    about: About {
        id: "importance-caching",
        module: include_str!("mod.rs"),
        aliases: &["imc"],
        summary: "virtual point lights, sampled by what records around the point received of them",
        source: "Georgiev et al. 2012; Keller 1997; Wu & Shen, section 4.2",
        bias: Bias::Unbiased,
        version: 1,
        failures: &[
            "unbiased for the sum over the virtual lights, which lacks light that the clamped \
             distance takes away in corners and light that arrives by mirrors or glass",
            "lights that no record near the point received are left to the uniform distribution, \
             which is noisy",
            "highlights and lights close by that no record near the point has are rare and bright: \
             a few such pixels decide the RMSE of an image",
        ],
        parameters: &[
            Parameter {
                key: "lights",
                default: "8192",
                unit: "",
                meaning: "wanted number of virtual point lights; the set comes close to it",
            },
            Parameter {
                key: "seed",
                default: "1",
                unit: "",
                meaning: "seed of the virtual point lights, shared by reference and contenders",
            },
            Parameter {
                key: "clamp",
                default: "0.01",
                unit: "diagonals",
                meaning: "least distance to a light in the geometry term, in reference and contenders",
            },
            Parameter {
                key: "reference",
                default: "lights",
                unit: "",
                meaning: "what references and per-sample are made of: lights (their sum, and one of \
                          them) or paths",
            },
            Parameter {
                key: "reference_passes",
                default: "512",
                unit: "",
                meaning: "paths of each pixel of a reference of paths",
            },
            Parameter {
                key: "heuristic",
                default: "balance",
                unit: "",
                meaning: "how the samples of the four distributions are combined: balance or \
                          alpha-max",
            },
            Parameter {
                key: "alpha",
                default: "[1, 1, 1, 1]",
                unit: "",
                meaning: "confidence in the full, unoccluded, bounded and conservative distribution \
                          (alpha-max)",
            },
            Parameter {
                key: "bound_radius",
                default: "0.5",
                unit: "",
                meaning: "radius of the ball that the bounded distribution covers, in distances of \
                          a record to its M-th nearest",
            },
            Parameter {
                key: "lookup",
                default: "candidates = 20, used = 6, max_angle_deg = 30",
                unit: "",
                meaning: "the run-time rule (N, M, θ_max; lambda_scaled replaces λ = 0.5/L)",
            },
        ],
    },
    build: |table| {
        let technique = ImportanceCaching::new(crate::entry::parameters(table)?)?;
        Ok(Box::new(technique))
    },
    contenders: cached::listed,
    unit: Unit::Caches,
    default_method: "VGC+DGS",
    of_contenders: &["heuristic", "alpha", "bound_radius", "lookup"],
};

/// What references, and the contender without records, are made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reference {
    /// The virtual lights: their sum, and one of them by its power.
    #[default]
    Lights,
    /// Path tracing of all light.
    Paths,
}

/// Parameters of the technique.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Wanted number of virtual point lights.
    pub lights: usize,
    /// Seed of the lights.
    pub seed: u64,
    /// r_min in diagonals of the scene.
    pub clamp: f32,
    pub reference: Reference,
    /// Paths of each pixel of a reference of paths.
    pub reference_passes: u32,
    pub heuristic: Heuristic,
    /// Confidence in the kinds of distribution, in (0, 1].
    pub alpha: [f32; KINDS],
    /// r_c in distances of a record to its M-th nearest.
    pub bound_radius: f32,
    pub lookup: Lookup,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            lights: 8192,
            seed: 1,
            clamp: 0.01,
            reference: Reference::Lights,
            reference_passes: 512,
            heuristic: Heuristic::Balance,
            alpha: [1.0; KINDS],
            bound_radius: 0.5,
            lookup: Lookup::default(),
        }
    }
}

/// The technique `importance-caching`.
pub struct ImportanceCaching {
    parameters: Parameters,
}

impl ImportanceCaching {
    /// # Errors
    /// Values out of range; the key is named.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        let error = |key: &str, message: String| {
            let key = Some(key.into());
            Err(ParameterError { key, message })
        };
        if !(1..=1 << 20).contains(&parameters.lights) {
            let message = format!("lights = {}: expected 1 to 1048576", parameters.lights);
            return error("lights", message);
        }
        if !(0.0..=1.0).contains(&parameters.clamp) {
            let message = format!("clamp = {}: expected 0 to 1 diagonals", parameters.clamp);
            return error("clamp", message);
        }
        if parameters.reference_passes == 0 {
            return error("reference_passes", "expected at least 1".into());
        }
        if !parameters.alpha.iter().all(|a| *a > 0.0 && *a <= 1.0) {
            let message = "alpha: each confidence must lie above 0 and be at most 1: without \
                           confidence in a distribution its lights would be lost"
                .into();
            return error("alpha", message);
        }
        if !(0.0..=1.0).contains(&parameters.bound_radius) {
            let message = format!(
                "bound_radius = {}: expected 0 to 1",
                parameters.bound_radius
            );
            return error("bound_radius", message);
        }
        if let Err(message) = parameters.lookup.validate() {
            return error("lookup", message);
        }
        Ok(Self { parameters })
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
        Err(ParameterError {
            key: Some("interpolation".into()),
            message: "importance caching samples by its records and interpolates no values: set \
                      interpolation = \"inverse-distance\""
                .into(),
        })
    }

    fn function<'a>(
        &'a self,
        shot: &'a Shot<'a>,
        (_, seed): (Interpolation, u64),
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
