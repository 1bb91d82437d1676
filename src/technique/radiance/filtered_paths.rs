//! The contender `filtered-paths`: as many paths through each pixel as `paths` traces, smoothed with the filter of the
//! hash cache.
//!
//! There is one layer, of what the camera sees first: the mean of a pixel's paths is split into the light on the
//! diffuse base, without its colour, and what the gloss reflects; normals, lengths and albedo are means as well.

use glam::Vec3;

use super::camera::first_leg;
use super::filter::{Filter, FilterParameters};
use super::layers::{GlossVertex, LayerVertex, Layers, Setting, Smoothing};
use crate::entry::{About, Bias, parameters};
use crate::sample::Rng;
use crate::shade::{Leg, Lobes, Met};
use crate::technique::truth::Truth;
use crate::technique::{Contender, ContenderEntry, Rendered, Shot, Terms};
use crate::trace::{Caster, RayCounter};

/// Entry in the technique's list.
pub const ENTRY: ContenderEntry<Truth> = ContenderEntry {
    about: About {
        id: "filtered-paths",
        module: crate::entry::head_comment!("filtered_paths.rs"),
        aliases: &[],
        summary: "paths of the frame alone, smoothed with the filter of the hash cache",
        source: "Kajiya 1986; filter of Roth et al. 2020, equations 2 to 6",
        bias: Bias::Biased,
        version: 5,
        failures: &[
            "shadows and reflections finer than the kernel are blurred where luminances are alike",
        ],
        parameters: Parameters::PARAMETERS,
    },
    start: |_, table, terms| {
        Ok(Box::new(FilteredPaths {
            parameters: Parameters::read(table)?,
            terms,
        }))
    },
};

parameters! {
    #[derive(Clone, Copy, Debug)]
    struct Parameters {
        /// Kernel and edge-stopping of the filter.
        kernel: FilterParameters = FilterParameters::default();
    }
}

/// Keys the random numbers of the paths.
const STREAM: u64 = 0x6669_6c74_7061;

struct FilteredPaths {
    parameters: Parameters,
    terms: Terms,
}

impl Contender for FilteredPaths {
    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        Ok(shots.iter().map(|shot| self.shot(shot)).collect())
    }
}

impl FilteredPaths {
    fn shot(&self, shot: &Shot) -> Rendered {
        let mut rendered = Rendered::default();
        let counter = RayCounter::default();
        let mut layers = Layers::new(shot.width, shot.height, 1);
        let non_finite = rendered.stages.time("rendering", || {
            layers.fill(|mut row, y| {
                let caster = shot.tracer.caster(&counter);
                let mut non_finite = 0;
                for x in 0..shot.width {
                    let (vertex, left_out) = self.pixel(shot, &caster, [x, y]);
                    row.put(0, x, &vertex);
                    non_finite += left_out;
                }
                (1, non_finite)
            })
        });
        let setting = Setting {
            smoothing: Smoothing::Plain,
            filter: Filter::new(self.parameters.kernel),
            exposure: shot.scene.exposure,
        };
        let (image, _) = rendered.stages.time("filter", || layers.image(&setting));
        rendered.image = image;
        rendered.rays = counter.read();
        rendered.non_finite = non_finite.iter().sum();
        rendered
    }

    /// The mean of the pixel's paths as a vertex, and how many were not finite and are left out.
    fn pixel(&self, shot: &Shot, caster: &Caster, [x, y]: [usize; 2]) -> (LayerVertex, u64) {
        let pixel = (y * shot.width + x) as u64;
        let mut mean = Mean::default();
        let mut non_finite = 0;
        for sample in 0..self.terms.budget as u64 {
            let number = u64::from(shot.frame) * self.terms.budget as u64 + sample;
            let mut rng = Rng::new(self.terms.seed, STREAM, pixel, number);
            let leg = first_leg(shot, [x, y], &mut rng);
            let vertex = path(shot, caster, leg, &mut rng);
            if is_finite(&vertex) {
                mean.add(&vertex);
            } else {
                non_finite += 1;
            }
        }
        (mean.vertex(), non_finite)
    }
}

/// One path, as its first vertex and the light that it brings there.
fn path(shot: &Shot, caster: &Caster, leg: Leg, rng: &mut Rng) -> LayerVertex {
    let mut first = LayerVertex::default();
    let met = match shot.paths.meet(caster, leg, rng) {
        Met::Sky { passed, sky } => {
            first.emission = passed + sky;
            return first;
        }
        Met::Surface(vertex) => vertex,
    };
    let at = &met.at;
    first.emission = met.emission;
    first.normal = at.facing_normal();
    first.path_length = met.distance;
    let albedo = if at.bsdf.has_base() {
        at.base_albedo()
    } else {
        Vec3::ZERO
    };
    first.albedo = at.bsdf.has_base().then_some(albedo);
    let mut gloss = Vec3::ZERO;
    let last = shot.scene.max_depth;
    if last > 1 {
        if !at.bsdf.is_delta()
            && let Some(lit) = shot.paths.lit(caster, at, Lobes::All, rng)
        {
            first.base += lit.base;
            gloss += lit.scattered - albedo * lit.base;
        }
        let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        if let Some(scattered) = shot.paths.scattered(at, Lobes::All, u) {
            let (radiance, length) = shot.paths.arriving(caster, scattered.leg, last - 1, rng);
            first.base += scattered.base * radiance;
            gloss += (scattered.weight - albedo * scattered.base) * radiance;
            first.segment = length.unwrap_or(shot.scene.diagonal);
        }
    }
    if at.gloss_chance() > 0.0 {
        first.gloss = Some(GlossVertex {
            light: gloss,
            ..GlossVertex::default()
        });
        if at.gloss_chance() == 1.0 {
            return first;
        }
    }
    // Where the gloss does not decide, the next leg goes anywhere.
    first.segment = 0.0;
    first
}

fn is_finite(vertex: &LayerVertex) -> bool {
    let gloss = vertex.gloss.unwrap_or_default().light;
    let albedo = vertex.albedo.unwrap_or_default();
    [vertex.emission, vertex.base, gloss, albedo]
        .iter()
        .all(|v| v.is_finite())
}

/// The mean of vertices.
#[derive(Default)]
struct Mean {
    sum: LayerVertex,
    count: f32,
    surfaces: f32,
    bases: f32,
}

impl Mean {
    fn add(&mut self, vertex: &LayerVertex) {
        self.count += 1.0;
        self.sum.emission += vertex.emission;
        if vertex.normal == Vec3::ZERO {
            return;
        }
        self.surfaces += 1.0;
        self.sum.normal += vertex.normal;
        self.sum.path_length += vertex.path_length;
        self.sum.segment += vertex.segment;
        if let Some(albedo) = vertex.albedo {
            self.bases += 1.0;
            self.sum.albedo = Some(self.sum.albedo.unwrap_or_default() + albedo);
            self.sum.base += vertex.base;
        }
        if let Some(gloss) = vertex.gloss {
            let sum = self.sum.gloss.get_or_insert_default();
            sum.light += gloss.light;
        }
    }

    /// Emission, albedo and gloss are those of the whole pixel; lengths, normals and light those of where there are any.
    fn vertex(mut self) -> LayerVertex {
        if self.count == 0.0 {
            return LayerVertex::default();
        }
        self.sum.emission /= self.count;
        self.sum.normal = self.sum.normal.normalize_or_zero();
        self.sum.path_length /= self.surfaces.max(1.0);
        self.sum.segment /= self.surfaces.max(1.0);
        self.sum.base /= self.bases.max(1.0);
        self.sum.albedo = self.sum.albedo.map(|albedo| albedo / self.count);
        if let Some(gloss) = &mut self.sum.gloss {
            gloss.light /= self.count;
        }
        self.sum
    }
}
