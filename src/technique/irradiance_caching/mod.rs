//! Irradiance caching under a distribution of records (Wu & Shen, 4.1 and 4.4).
//!
//! A record holds the indirect irradiance `E = (2π/S) Σ L cos θ` of `side²` equal-area directions, `L`
//! path traced without the emission that a ray meets first (that light is direct). An image sample is
//! `ρ(ω) E / π`, `E` interpolated and `ρ` the directional albedo of the material seen: exact for
//! diffuse surfaces, and for others right when the indirect light is uniform. With gradient interpolation
//! coatings and metals see, in place of `E / π`, what the records gathered from the directions they reflect.
//! Direct light is a layer of its own, without records, the same for reference and contenders.

mod change;
mod gather;
pub mod on_demand;
mod panorama;
mod records;

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use toml::Table;

use self::gather::Gatherer;
use self::panorama::Panoramas;
use self::records::IrradianceRecords;
use super::cached::{self, CachedTechnique};
use super::paths::{Layer, LayerPaths, RAYS_PER_SAMPLE, indirect};
use super::{CACHES, Started, TechniqueEntry, Terms};
use super::{
    CachedFunction, ContenderEntry, Lookup, Passes, Seen, ShadingFunction, Shot, Technique,
};
use crate::cache::Interpolation;
use crate::entry::{About, Bias, ParameterError, parameters};
use crate::image::Image;
use crate::sample::equal_area_hemisphere;
use crate::scene::{Needs, Scene};
use crate::trace::RayCounter;

/// The registry's entry.
pub const ENTRY: TechniqueEntry = TechniqueEntry {
    about: About {
        id: "irradiance-caching",
        module: crate::entry::head_comment!("mod.rs"),
        aliases: &["irradiance", "ic"],
        summary: "indirect light interpolated from records of irradiance",
        source: "Ward et al. 1988 with records placed beforehand and the run-time rule of Wu & \
                 Shen, sections 3.3 and 4.1. Readings: hemisphere grid in a shot of the normal \
                 alone, next-event estimation at the hits, the scene's max_depth",
        bias: Bias::Consistent,
        version: 3,
        failures: &[
            "glossy reflections of indirect light are blurred to the directional albedo times the \
             mean: mirror-like coatings lose them (with gradient interpolation, to blocks of about 9°)",
            "indirect light that changes within the spacing of records is blurred: corners, contact \
             shadows, caustics",
            "bump maps turn the direct light only",
            "a thin wall lit differently on both sides of its edge mixes where normals agree",
        ],
        parameters: Parameters::PARAMETERS,
    },
    build: |table| Ok(Box::new(IrradianceCaching::new(Parameters::read(table)?))),
    contenders: || {
        let mut listed = cached::listed();
        listed.extend(CONTENDERS.iter().map(ContenderEntry::listed));
        listed
    },
    units: &[&CACHES],
    default_method: "VGC+DGS",
    of_contenders: &["lookup"],
};

/// What irradiance caching compares beside what every cached technique does.
static CONTENDERS: &[ContenderEntry<IrradianceCaching>] = &[on_demand::ENTRY];

parameters! {
    /// Parameters of the technique, shared by reference and contenders.
    #[derive(Clone, Debug)]
    struct Parameters {
        /// Directions per side of the equal-area hemisphere grid.
        side: usize = 64, Within(1.0, 256.0);
        /// Indirect, or global to add emission and direct light to reference and contenders alike.
        layer: Layer = Layer::Indirect;
        /// Paths of each pixel of the reference, and of the direct layer.
        reference_passes: u32 = 512, Within(1.0, u32::MAX as f64);
        /// The run-time rule.
        lookup: Lookup = Lookup::default();
    }
}

/// The technique `irradiance-caching`.
struct IrradianceCaching {
    parameters: Parameters,
    directions: Vec<Vec3>,
}

/// Seed of the reference.
const REFERENCE_SEED: u64 = 0;

impl IrradianceCaching {
    fn new(parameters: Parameters) -> Self {
        Self {
            directions: equal_area_hemisphere(parameters.side),
            parameters,
        }
    }

    fn paths<'a>(&self, shot: &'a Shot<'a>, seed: u64) -> LayerPaths<'a> {
        LayerPaths {
            shot,
            direct: self.parameters.layer == Layer::Global,
            indirect: Some(indirect(shot)),
            seed,
        }
    }
}

/// Light that a camera sample gets from indirect irradiance at what it sees: `ρ(ω) E / π`.
fn reflected(shot: &Shot, seen: &Seen, irradiance: Vec3) -> Vec3 {
    seen.throughput * shot.surface(seen).directional_albedo() * irradiance * FRAC_1_PI
}

impl Technique for IrradianceCaching {
    fn needs(&self) -> Needs {
        Needs::ALL
    }

    fn shading_function<'a>(&'a self, shot: &'a Shot<'a>) -> Box<dyn ShadingFunction + 'a> {
        Box::new(self.paths(shot, REFERENCE_SEED))
    }

    fn exposure_stops(&self, scene: &Scene) -> f32 {
        scene.exposure.log2()
    }

    fn reference_samples(&self, spp: u32) -> u32 {
        self.parameters.reference_passes.next_multiple_of(spp)
    }

    fn reference_is_random(&self) -> bool {
        true
    }

    fn rays_per_evaluation(&self) -> u64 {
        // A path of the shipped scenes casts about five rays.
        5 * self.directions.len() as u64
    }

    fn bytes_per_record(&self) -> u64 {
        // Irradiance and normal, the luminance of each direction in half precision, and the blocks of
        // gradient interpolation.
        24 + 2 * self.directions.len() as u64 + Panoramas::bytes_per_record(self.parameters.side)
    }

    fn rays_per_reference_sample(&self) -> u64 {
        RAYS_PER_SAMPLE
    }

    fn start<'a>(
        &'a self,
        id: &str,
        parameters: &Table,
        terms: Terms,
    ) -> Result<Started<'a>, ParameterError> {
        match CONTENDERS.iter().find(|e| e.about.answers_to(id)) {
            Some(entry) => entry.started(self, parameters, terms),
            None => cached::start(self, id, parameters, terms),
        }
    }

    /// Emission and direct light: the same estimate, pass by pass, as in the reference.
    fn shared_layer(&self, shot: &Shot) -> Option<Image> {
        if self.parameters.layer == Layer::Indirect {
            return None;
        }
        let function = LayerPaths {
            indirect: None,
            ..self.paths(shot, REFERENCE_SEED)
        };
        let mut passes = Passes::new(shot, &function);
        for _ in 0..self.reference_samples(shot.spp) {
            passes.add(&RayCounter::default());
        }
        Some(passes.mean())
    }
}

impl CachedTechnique for IrradianceCaching {
    fn function<'a>(
        &'a self,
        shot: &'a Shot<'a>,
        interpolation: Interpolation,
        seed: u64,
    ) -> (Box<dyn CachedFunction + 'a>, Lookup) {
        let gatherer = Gatherer {
            shot,
            directions: &self.directions,
            depths: indirect(shot),
            seed,
        };
        let records = IrradianceRecords::new(gatherer, interpolation.gradient());
        (Box::new(records), self.parameters.lookup)
    }

    fn estimator<'a>(&'a self, shot: &'a Shot<'a>, seed: u64) -> Box<dyn ShadingFunction + 'a> {
        Box::new(LayerPaths {
            direct: false,
            ..self.paths(shot, seed)
        })
    }
}
