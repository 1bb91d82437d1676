//! Ambient occlusion from cached visibility (Clarberg & Akenine-Möller 2008; Wu & Shen, 4.3).
//!
//! A record holds the visibility of `side²` equal-area directions over the hemisphere of its shading
//! normal as bits, and its ambient occlusion `(2/S) Σ V cos θ`: 1 in the open. Surfaces are opaque
//! whatever their material, so no material, texture or light is read. Where the camera sees no
//! surface the value is 1.

use glam::Vec3;
use toml::Table;

mod gather;
mod records;

use gather::{Gatherer, Scratch};
use records::VisibilityRecords;

use super::cached::{self, CachedTechnique};
use super::{CACHES, Started, TechniqueEntry, Terms};
use super::{CachedFunction, Lookup, ShadingFunction, Shot, Technique, each_pixel};
use crate::cache::Interpolation;
use crate::entry::{About, Bias, ParameterError, parameters};
use crate::sample::{Frame as LocalFrame, Rng, equal_area_hemisphere};
use crate::scene::{Needs, Scene};
use crate::shade::bsdf::cosine_sample;
use crate::trace::{Caster, Ray, offset_origin};

/// Keys the directions of the random estimate.
const STREAM: u64 = 0x616f_7261_7973;

/// The registry's entry.
pub const ENTRY: TechniqueEntry = TechniqueEntry {
    about: About {
        id: "ambient-occlusion",
        module: crate::entry::head_comment!("mod.rs"),
        aliases: &["ao"],
        summary: "ambient occlusion interpolated from records of cached visibility",
        source: "Clarberg & Akenine-Möller 2008; Wu & Shen, section 4.3",
        bias: Bias::Consistent,
        version: 1,
        failures: &[
            "contact shadows thinner than the spacing of records are blurred or missed",
            "records on both sides of a thin wall mix when their normals agree",
            "surfaces are opaque: opacity masks and glass are not looked at",
        ],
        parameters: Parameters::PARAMETERS,
    },
    build: |table| Ok(Box::new(AmbientOcclusion::new(Parameters::read(table)?))),
    contenders: cached::listed,
    units: &[&CACHES],
    default_method: "VGC+DGS",
    of_contenders: &["lookup"],
};

parameters! {
    /// Parameters of the technique, shared by reference and contenders.
    #[derive(Clone, Debug)]
    pub struct Parameters {
        /// Directions per side of the equal-area hemisphere grid.
        pub side: usize = 32, Within(1.0, 256.0);
        /// Maximum length of occlusion rays; without it the scene's.
        pub distance: Option<f32> = None, Above(0.0), "scene units";
        /// The run-time rule.
        pub lookup: Lookup = Lookup::default();
    }
}

/// The technique `ambient-occlusion`.
pub struct AmbientOcclusion {
    parameters: Parameters,
    directions: Vec<Vec3>,
}

impl AmbientOcclusion {
    /// The technique, with the directions of its hemisphere laid out.
    pub fn new(parameters: Parameters) -> Self {
        Self {
            directions: equal_area_hemisphere(parameters.side),
            parameters,
        }
    }

    fn gatherer(&self, shot: &Shot) -> Gatherer<'_> {
        Gatherer {
            directions: &self.directions,
            distance: self.distance(shot),
            diagonal: shot.scene.diagonal,
        }
    }

    fn distance(&self, shot: &Shot) -> f32 {
        self.parameters.distance.unwrap_or(shot.scene.ao_distance)
    }
}

impl Technique for AmbientOcclusion {
    fn needs(&self) -> Needs {
        Needs::GEOMETRY
    }

    fn shading_function<'a>(&'a self, shot: &'a Shot<'a>) -> Box<dyn ShadingFunction + 'a> {
        Box::new(ExactOcclusion {
            shot,
            gatherer: self.gatherer(shot),
        })
    }

    fn exposure_stops(&self, _scene: &Scene) -> f32 {
        0.0
    }

    fn reference_samples(&self, spp: u32) -> u32 {
        spp
    }

    fn reference_is_random(&self) -> bool {
        false
    }

    fn rays_per_evaluation(&self) -> u64 {
        self.directions.len() as u64
    }

    fn bytes_per_record(&self) -> u64 {
        4 + 8 * self.directions.len().div_ceil(64) as u64
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

impl CachedTechnique for AmbientOcclusion {
    fn function<'a>(
        &'a self,
        shot: &'a Shot<'a>,
        interpolation: Interpolation,
        _: u64,
    ) -> (Box<dyn CachedFunction + 'a>, Lookup) {
        let records = VisibilityRecords::new(shot, self.gatherer(shot), interpolation.gradient());
        (Box::new(records), self.parameters.lookup)
    }

    fn estimator<'a>(&'a self, shot: &'a Shot<'a>, seed: u64) -> Box<dyn ShadingFunction + 'a> {
        Box::new(SampledOcclusion {
            shot,
            distance: self.distance(shot),
            seed,
        })
    }
}

/// Ambient occlusion by one random ray, distributed by the cosine.
struct SampledOcclusion<'a> {
    shot: &'a Shot<'a>,
    distance: f32,
    seed: u64,
}

impl ShadingFunction for SampledOcclusion<'_> {
    fn pixels(&self, caster: &Caster, first_pixel: u32, pass: u32, out: &mut [[f32; 3]]) -> u64 {
        let shot = self.shot;
        each_pixel(first_pixel, out, |pixel| {
            let open = shot
                .look(caster, pixel, pass % shot.spp)
                .is_none_or(|seen| {
                    let mut rng = Rng::new(self.seed, STREAM, u64::from(pixel), u64::from(pass));
                    let local = cosine_sample([rng.next_f32(), rng.next_f32()]);
                    let site = seen.site;
                    let side =
                        offset_origin(site.position, site.geometric_normal, shot.scene.diagonal);
                    let direction = LocalFrame::from_normal(site.normal).to_world(local);
                    !caster.occluded(&Ray {
                        t_max: self.distance,
                        ..Ray::new(side, direction)
                    })
                });
            Vec3::splat(f32::from(u8::from(open)))
        })
    }
}

/// Ambient occlusion evaluated at every sample.
struct ExactOcclusion<'a> {
    shot: &'a Shot<'a>,
    gatherer: Gatherer<'a>,
}

impl ShadingFunction for ExactOcclusion<'_> {
    fn pixels(&self, caster: &Caster, first_pixel: u32, sample: u32, out: &mut [[f32; 3]]) -> u64 {
        let mut scratch = Scratch::new(self.gatherer.directions.len());
        each_pixel(first_pixel, out, |pixel| {
            let seen = self.shot.look(caster, pixel, sample);
            Vec3::splat(seen.map_or(1.0, |seen| {
                self.gatherer.gather(caster, &seen.site, &mut scratch)
            }))
        })
    }
}
