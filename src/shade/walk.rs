//! Paths vertex by vertex, for caches that keep what arrives at the vertices.
//!
//! [`PathTracer::meet`] goes along a leg to the next surface, [`PathTracer::lit`] samples a light there, and
//! [`PathTracer::scattered`] chooses the next leg. Light sampling and scattering are combined by the power heuristic
//! as in [`PathTracer::radiance`]: what a vertex sends on is `lit` and the emission that the leg after it meets.

use glam::Vec3;

use super::PathTracer;
use super::masks::MOST_MASKS;
use super::path::power_heuristic;
use super::surface::Interaction;
use crate::sample::Rng;
use crate::trace::{Caster, Hit, Ray};

/// A ray of a path, and how its direction was chosen.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// From the last vertex, or from the camera.
    pub ray: Ray,
    /// Density (1/sr) of the direction.
    pub pdf_sr: f32,
    /// Whether lights could not have been sampled in that direction.
    pub delta: bool,
}

impl Leg {
    /// A ray from a camera: all emission that it meets counts.
    pub fn from_camera(ray: Ray) -> Self {
        Self {
            ray,
            pdf_sr: 0.0,
            delta: true,
        }
    }
}

/// What a leg ends at.
pub enum Met<'a> {
    /// No surface that stops it.
    Sky {
        /// Radiance of masks on the way, weighted against light sampling.
        passed: Vec3,
        /// The environment's radiance, weighted against light sampling; 0 behind too many masks.
        sky: Vec3,
    },
    /// The first surface that is not masked out.
    Surface(Vertex<'a>),
}

impl Met<'_> {
    /// All emission that the leg gets, weighted against light sampling.
    pub fn emission(&self) -> Vec3 {
        match self {
            Self::Sky { passed, sky } => passed + sky,
            Self::Surface(vertex) => vertex.emission,
        }
    }
}

/// A vertex of a path; passing opacity masks is behind it, so its surface is opaque.
pub struct Vertex<'a> {
    /// The surface point, seen from the leg.
    pub at: Interaction<'a>,
    /// Where that is, its distance that from the start of the leg.
    pub hit: Hit,
    /// Length of the leg, scene units.
    pub distance: f32,
    /// Radiance emitted back along the leg, by masks that it passed too, weighted against light sampling.
    pub emission: Vec3,
}

/// Which part of a surface scatters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobes {
    /// Base and gloss; [`Interaction::sample_part`] chooses between them.
    All,
    /// What depends on the viewer only.
    Gloss,
}

/// Light of one sampled source that reaches a vertex, unoccluded.
#[derive(Clone, Copy, Debug)]
pub struct Lit {
    /// What the lobes asked for send back along the leg.
    pub scattered: Vec3,
    /// What the base would send back if its albedo were 1: without its colour.
    pub base: Vec3,
}

/// A leg that goes on from a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// The ray on from there.
    pub leg: Leg,
    /// Scattering × cosine / density of the lobes asked for.
    pub weight: Vec3,
    /// The same of the base if its albedo were 1.
    pub base: f32,
}

impl PathTracer<'_> {
    /// What a leg meets. `rng` decides whether opacity masks are passed.
    pub fn meet(&self, caster: &Caster, leg: Leg, rng: &mut Rng) -> Met<'_> {
        let hit = caster.closest(&leg.ray);
        self.meet_from(caster, leg, hit, rng)
    }

    /// As [`PathTracer::meet`], of a leg whose first hit is known.
    pub fn meet_from(
        &self,
        caster: &Caster,
        mut leg: Leg,
        mut hit: Option<Hit>,
        rng: &mut Rng,
    ) -> Met<'_> {
        let mut distance = 0.0;
        // Masks that shine do so with all of their light, passed or not.
        let mut passed = Vec3::ZERO;
        for _ in 0..MOST_MASKS {
            let Some(met) = hit else {
                return Met::Sky {
                    passed,
                    sky: self.sky(&leg),
                };
            };
            let mut at = self.surfaces().interact(&met, leg.ray.direction);
            distance += met.t;
            let opacity = at.bsdf.opacity;
            let emission = passed + self.emission(&at, distance, &leg);
            if opacity >= 1.0 || rng.next_f32() < opacity {
                at.bsdf.opacity = 1.0;
                return Met::Surface(Vertex {
                    at,
                    hit: Hit { t: distance, ..met },
                    distance,
                    emission,
                });
            }
            passed = emission;
            leg.ray = self.lights().spawn(&at, leg.ray.direction);
            hit = caster.closest(&leg.ray);
        }
        Met::Sky {
            passed,
            sky: Vec3::ZERO,
        }
    }

    /// The radiance that arrives against a leg by paths of up to `depth` edges, and the leg's length where it ends at
    /// a surface.
    pub fn arriving(
        &self,
        caster: &Caster,
        mut leg: Leg,
        depth: u32,
        rng: &mut Rng,
    ) -> (Vec3, Option<f32>) {
        let (mut sum, mut throughput) = (Vec3::ZERO, Vec3::ONE);
        let mut length = None;
        for edge in 1..=depth {
            let vertex = match self.meet(caster, leg, rng) {
                Met::Sky { passed, sky } => {
                    sum += throughput * (passed + sky);
                    break;
                }
                Met::Surface(vertex) => vertex,
            };
            length.get_or_insert(vertex.distance);
            sum += throughput * vertex.emission;
            if edge == depth {
                break;
            }
            if !vertex.at.bsdf.is_delta()
                && let Some(lit) = self.lit(caster, &vertex.at, Lobes::All, rng)
            {
                sum += throughput * lit.scattered;
            }
            let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
            let Some(scattered) = self.scattered(&vertex.at, Lobes::All, u) else {
                break;
            };
            throughput *= scattered.weight;
            if throughput == Vec3::ZERO {
                break;
            }
            leg = scattered.leg;
        }
        (sum, length)
    }

    fn sky(&self, leg: &Leg) -> Vec3 {
        let direction = leg.ray.direction;
        let radiance = self.lights().environment(direction);
        if leg.delta || radiance == Vec3::ZERO {
            return radiance;
        }
        radiance * power_heuristic(leg.pdf_sr, self.lights().pdf_environment(direction))
    }

    fn emission(&self, at: &Interaction, distance: f32, leg: &Leg) -> Vec3 {
        let radiance = self.lights().emitted(at);
        if leg.delta || radiance == Vec3::ZERO {
            return radiance;
        }
        radiance * power_heuristic(leg.pdf_sr, self.lights().pdf_emitted(at, distance))
    }

    /// One sampled light; `None` where none reaches the surface or the lobes send nothing of it back.
    pub fn lit(
        &self,
        caster: &Caster,
        at: &Interaction,
        lobes: Lobes,
        rng: &mut Rng,
    ) -> Option<Lit> {
        let light = self.lights().sample(at, rng)?;
        let (value, base, pdf) = match lobes {
            Lobes::All => (
                at.evaluate(light.direction),
                at.base_share(light.direction),
                at.part_pdf(light.direction),
            ),
            Lobes::Gloss => (
                at.evaluate_gloss(light.direction),
                0.0,
                at.gloss_pdf(light.direction),
            ),
        };
        let nothing = value == Vec3::ZERO && base == 0.0;
        if nothing || light.radiance == Vec3::ZERO || self.occluded(caster, &light.shadow_ray) {
            return None;
        }
        let weight = if light.delta {
            1.0
        } else {
            power_heuristic(light.pdf_sr, pdf)
        };
        let arriving = light.radiance * (weight / light.pdf_sr);
        Some(Lit {
            scattered: value * arriving,
            base: base * arriving,
        })
    }

    /// The leg that goes on from a surface; `None` absorbs the path.
    pub fn scattered(&self, at: &Interaction, lobes: Lobes, u: [f32; 3]) -> Option<Scattered> {
        let (sample, base) = match lobes {
            Lobes::All => {
                let sample = at.sample_part(u)?;
                let base = if sample.delta {
                    0.0
                } else {
                    at.base_share(sample.direction) / sample.pdf_sr
                };
                (sample, base)
            }
            Lobes::Gloss => (at.sample_gloss(u)?, 0.0),
        };
        Some(Scattered {
            leg: Leg {
                ray: self.lights().spawn(at, sample.direction),
                pdf_sr: sample.pdf_sr,
                delta: sample.delta,
            },
            weight: sample.weight,
            base,
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::image::luminance;
    use crate::scene::{
        ColourSource, Material, Needs, Scene, SceneDescription, ShapeDescription, ShapeSource,
        View, find_scene,
    };
    use crate::shade::Depths;
    use crate::trace::{RayCounter, Tracer};

    /// Walking vertex by vertex is path tracing.
    #[test]
    fn walked_paths_bring_the_radiance_of_path_tracing() {
        const PATHS: u64 = 60_000;
        for name in ["still-puzzle", "hard-cases"] {
            let description = find_scene(name).expect("an embedded scene");
            let scene = Scene::build(&description, Needs::ALL).expect("a scene");
            let tracer = Tracer::new(&scene.positions, &scene.triangles);
            let paths = PathTracer::new(&scene, &tracer);
            let counter = RayCounter::default();
            let caster = tracer.caster(&counter);
            let view = &scene.views[0];
            let (mut walked, mut traced) = ([0.0f64; 2], [0.0f64; 2]);
            for i in 0..PATHS {
                let mut rng = Rng::new(1, 2, i, 0);
                let [x, y] = [rng.next_f64() * 64.0, rng.next_f64() * 36.0];
                let ray = Ray::new(view.origin.as_vec3(), view.direction(x, y, [64, 36]));
                let radiance = paths.radiance(&caster, ray, &mut rng, Depths::up_to(4));
                add(&mut traced, luminance(radiance));
                let leg = Leg::from_camera(ray);
                let (radiance, _) = paths.arriving(&caster, leg, 4, &mut rng);
                add(&mut walked, luminance(radiance.into()));
            }
            let mean = |sums: [f64; 2]| sums[0] / PATHS as f64;
            let variance = |sums: [f64; 2]| sums[1] / PATHS as f64 - mean(sums).powi(2);
            let deviation = ((variance(walked) + variance(traced)) / PATHS as f64).sqrt();
            let off = mean(walked) - mean(traced);
            assert!(off.abs() < 4.0 * deviation, "{name}: {off} ± {deviation}");
        }
    }

    /// Half of all legs pass the lamp.
    #[test]
    fn masks_shine_with_all_their_light_as_in_path_tracing() {
        let mut lamp = ShapeDescription::new("lamp", ShapeSource::Rectangle);
        lamp.emission = Some([4.0; 3]);
        let eye = [DVec3::Z * 2.0, DVec3::ZERO, DVec3::Y];
        let description = SceneDescription {
            views: vec![View::look_at("v", eye, 60.0, [8, 8])],
            shapes: vec![lamp],
            materials: vec![Material {
                opacity: Some(ColourSource::Constant([0.5; 3])),
                ..Material::diffuse("half", [0.5; 3])
            }],
            ..SceneDescription::default()
        };
        let scene = Scene::build(&description, Needs::ALL).expect("a scene");
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        let paths = PathTracer::new(&scene, &tracer);
        let counter = RayCounter::default();
        let caster = tracer.caster(&counter);
        let ray = Ray::new(Vec3::Z, -Vec3::Z);
        let (mut met, count) = (0, 100);
        for i in 0..count {
            let mut rng = Rng::new(1, 2, i, 0);
            let traced = paths.radiance(&caster, ray, &mut rng, Depths::up_to(3));
            let leg = Leg::from_camera(ray);
            let (walked, length) = paths.arriving(&caster, leg, 3, &mut rng);
            assert_eq!((traced, walked), ([4.0; 3], Vec3::splat(4.0)));
            met += u64::from(length.is_some());
        }
        assert!((30..70).contains(&met), "{met}");
    }

    fn add(sums: &mut [f64; 2], value: f32) {
        let value = f64::from(value);
        sums[0] += value;
        sums[1] += value * value;
    }
}
