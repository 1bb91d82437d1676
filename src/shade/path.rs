//! The path tracer: next-event estimation and BSDF sampling, combined by the power heuristic.

use glam::Vec3;

use super::light::Lights;
use super::surface::{Interaction, Surfaces};
use super::walk::{Leg, Met};
use crate::sample::Rng;
use crate::scene::Scene;
use crate::trace::{Caster, Hit, Ray, Tracer};

/// Path depth of direct lighting: emission and one scattering.
pub const DIRECT_LIGHTING: u32 = 2;

/// Estimates the light transport of a scene.
pub struct PathTracer<'a> {
    surfaces: Surfaces<'a>,
    lights: Lights<'a>,
    tracer: &'a Tracer,
}

/// Which paths are counted, by their edges after the point that the first ray starts from: 1 is emission that the ray
/// sees, 2 light scattered once.
///
/// *differs:* opacity masks are passed without an edge; Mitsuba counts one for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Depths {
    /// Shorter paths do not count: 2 leaves out emission at the end of the first ray.
    pub first: u32,
    /// Longer paths do not count.
    pub last: u32,
    /// From this depth on paths end at random, by their throughput; the mean stays the same.
    pub roulette_from: Option<u32>,
    /// Whether the environment does not count where a path comes to it straight on, through nothing but opacity masks
    /// and panes of glass.
    pub hides_sky: bool,
}

impl Depths {
    /// All paths of up to `last` edges, without roulette.
    pub fn up_to(last: u32) -> Self {
        Self {
            first: 1,
            last,
            roulette_from: None,
            hides_sky: false,
        }
    }
}

/// What a path carries from one vertex to the next.
struct Carried {
    throughput: Vec3,
    /// Density of the direction the ray was sampled with.
    pdf_sr: f32,
    /// Whether lights could not have been sampled in that direction.
    delta: bool,
}

impl<'a> PathTracer<'a> {
    /// Prepares materials and lights of a scene; `tracer` was built from its triangles.
    pub fn new(scene: &'a Scene, tracer: &'a Tracer) -> Self {
        Self {
            surfaces: Surfaces::new(scene),
            lights: Lights::new(scene),
            tracer,
        }
    }

    /// The materials.
    pub fn surfaces(&self) -> &Surfaces<'a> {
        &self.surfaces
    }

    /// The lights.
    pub fn lights(&self) -> &Lights<'a> {
        &self.lights
    }

    /// The structure rays are cast into.
    pub fn tracer(&self) -> &'a Tracer {
        self.tracer
    }

    /// One estimate of the radiance that arrives along `ray`, against its direction. Passing a pane of glass counts as an edge,
    /// passing an opacity mask does not. The result is not finite only where a light or material is; sums must leave it out.
    pub fn radiance(&self, caster: &Caster, ray: Ray, rng: &mut Rng, depths: Depths) -> [f32; 3] {
        let hit = caster.closest(&ray);
        self.follow(caster, ray, hit, rng, depths).into()
    }

    /// What a ray meets behind all that shines, and the ray from there; `None` where that is nothing.
    pub fn behind_lights(&self, caster: &Caster, mut ray: Ray) -> Option<(Ray, Hit)> {
        // More lights than this one behind another are not looked through.
        for _ in 0..64 {
            let hit = caster.closest(&ray)?;
            let at = self.surfaces.interact(&hit, ray.direction);
            if !self.lights.shines(&at) {
                return Some((ray, hit));
            }
            ray = self.lights.spawn(&at, ray.direction);
        }
        None
    }

    /// [`PathTracer::radiance`] along a ray whose first hit is known.
    pub fn follow(
        &self,
        caster: &Caster,
        mut ray: Ray,
        mut hit: Option<Hit>,
        rng: &mut Rng,
        depths: Depths,
    ) -> Vec3 {
        let mut sum = Vec3::ZERO;
        let mut carried = Carried {
            throughput: Vec3::ONE,
            pdf_sr: 0.0,
            delta: true,
        };
        let mut hides_sky = depths.hides_sky;
        for depth in 1..=depths.last {
            let leg = Leg {
                ray,
                pdf_sr: carried.pdf_sr,
                delta: carried.delta,
            };
            let vertex = match self.meet_from(caster, leg, hit, rng) {
                Met::Sky { passed, sky } => {
                    if depth >= depths.first {
                        let sky = if hides_sky { Vec3::ZERO } else { sky };
                        sum += carried.throughput * (passed + sky);
                    }
                    break;
                }
                Met::Surface(vertex) => vertex,
            };
            let at = &vertex.at;
            if depth >= depths.first {
                sum += carried.throughput * vertex.emission;
            }
            if depth == depths.last {
                break;
            }
            if !at.bsdf.is_delta() && depth + 1 >= depths.first {
                sum += carried.throughput * self.sampled_light(caster, at, rng);
            }
            let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
            let Some(sample) = at.sample(u) else { break };
            hides_sky &= at.goes_straight(&sample);
            carried = Carried {
                throughput: carried.throughput * sample.weight,
                pdf_sr: sample.pdf_sr,
                delta: sample.delta,
            };
            if carried.throughput == Vec3::ZERO || !survives(&mut carried, depth, depths, rng) {
                break;
            }
            ray = self.lights.spawn(at, sample.direction);
            hit = caster.closest(&ray);
        }
        sum
    }

    /// Emission of a surface towards its viewer and light that it scatters once: one light sample
    /// and one sampled direction. Not finite only where a light or material is.
    pub fn direct(&self, caster: &Caster, at: &Interaction, rng: &mut Rng) -> Vec3 {
        let mut sum = self.lights.emitted(at);
        if !at.bsdf.is_delta() {
            sum += self.sampled_light(caster, at, rng);
        }
        let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        if let Some(sample) = at.sample(u) {
            let leg = Leg {
                ray: self.lights.spawn(at, sample.direction),
                pdf_sr: sample.pdf_sr,
                delta: sample.delta,
            };
            sum += sample.weight * self.meet(caster, leg, rng).emission();
        }
        sum
    }

    /// Light of one sampled source that the surface sends to its viewer.
    fn sampled_light(&self, caster: &Caster, at: &Interaction, rng: &mut Rng) -> Vec3 {
        let Some(light) = self.lights.sample(at, rng) else {
            return Vec3::ZERO;
        };
        let scattered = at.evaluate(light.direction) * light.radiance;
        if scattered == Vec3::ZERO || self.occluded(caster, &light.shadow_ray) {
            return Vec3::ZERO;
        }
        let weight = if light.delta {
            1.0
        } else {
            power_heuristic(light.pdf_sr, at.pdf(light.direction))
        };
        scattered * (weight / light.pdf_sr)
    }
}

fn survives(carried: &mut Carried, depth: u32, depths: Depths, rng: &mut Rng) -> bool {
    if depths.roulette_from.is_none_or(|from| depth < from) {
        return true;
    }
    let chance = carried.throughput.max_element().clamp(0.05, 0.95);
    carried.throughput /= chance;
    rng.next_f32() < chance
}

/// Veach's power heuristic with exponent 2 for one sample of each of two techniques.
pub(super) fn power_heuristic(pdf: f32, other: f32) -> f32 {
    if pdf <= 0.0 {
        return 0.0;
    }
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}

#[cfg(test)]
mod tests {
    use super::power_heuristic;

    #[test]
    fn weights_of_both_techniques_add_up_to_one() {
        for (a, b) in [(1.0, 2.0), (1e30, 1e-30), (1e-30, 1e30), (3.0, 0.0)] {
            let sum: f32 = power_heuristic(a, b) + power_heuristic(b, a);
            assert!((sum - 1.0).abs() < 1e-6, "{a} {b}");
        }
    }
}
