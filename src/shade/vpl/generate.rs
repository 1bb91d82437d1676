//! Light paths and the lights they leave behind.

use glam::Vec3;
use rayon::prelude::*;

use super::{Emission, Facing, LANES, VirtualLight, VirtualLights, VplOptions};
use crate::sample::Rng;
use crate::scene::PointLight;
use crate::shade::light::Source;
use crate::shade::surface::Interaction;
use crate::shade::{DIRECT_LIGHTING, Leg, Met, PathTracer, Vertex};
use crate::trace::{Caster, RayCounter, offset_origin};

/// Keys the random numbers of light paths and of the pilot.
const STREAM: u64 = 0x7670_6c00;
const PILOT_STREAM: u64 = 0x7670_6c01;
/// Paths of the pilot.
const PILOT: usize = 1024;

/// What all paths of a set share.
struct Paths<'a> {
    scene: &'a PathTracer<'a>,
    diagonal: f32,
    seed: u64,
    stream: u64,
    count: usize,
    /// Surface points of a path, specular ones included.
    longest: u32,
    /// Moves the low-discrepancy points.
    shift: [f64; 2],
}

impl<'a> VirtualLights<'a> {
    /// Traces light paths; empty where nothing shines or `max_depth` < 2.
    pub fn new(scene: &'a PathTracer<'a>, options: &VplOptions, counter: &RayCounter) -> Self {
        let diagonal = scene.lights().diagonal();
        let mut set = Self {
            clamp_distance: options.clamp * diagonal,
            disk: std::f32::consts::PI * 0.25 * diagonal * diagonal,
            paths_of_scene: scene,
            lights: Vec::new(),
            facing: Vec::new(),
            on_surfaces: 0,
            finite: 0,
            paths: 0,
            dropped: 0,
        };
        let dark = scene.lights().is_dark();
        if dark || options.max_depth < DIRECT_LIGHTING || options.count == 0 {
            return set;
        }
        let mut shift = Rng::new(options.seed, STREAM, u64::MAX, 0);
        let mut paths = Paths {
            scene,
            diagonal,
            seed: options.seed,
            stream: PILOT_STREAM,
            count: PILOT,
            longest: options.max_depth - DIRECT_LIGHTING,
            shift: [shift.next_f64(), shift.next_f64()],
        };
        let pilot = paths.trace(counter);
        // A pilot without a single light still starts some paths.
        let per_path = (pilot.len() as f64 / PILOT as f64).max(1.0 / 16.0);
        let parallel = scene.lights().parallel();
        let parallel = parallel
            .map(|(direction, irradiance)| VirtualLight::at_infinity(direction, irradiance));
        let points = scene.lights().points().map(VirtualLight::at_point);
        let exact: Vec<_> = parallel.chain(points).collect();
        let wanted = options.count.saturating_sub(exact.len()) as f64;
        paths.count = ((wanted / per_path).round() as usize).max(1);
        paths.stream = STREAM;
        set.paths = paths.count;
        let mut lights = paths.trace(counter);
        lights.extend(exact);
        let before = lights.len();
        lights.retain(VirtualLight::is_finite);
        set.dropped = before - lights.len();
        lights.retain(VirtualLight::shines);
        [set.on_surfaces, set.finite] = sort(&mut lights, diagonal);
        set.facing = lights[..set.on_surfaces]
            .chunks(LANES)
            .map(Facing::new)
            .collect();
        set.lights = lights;
        set
    }
}

impl<'a> Paths<'a> {
    /// The lights of all paths, in the order of the paths.
    fn trace(&self, counter: &RayCounter) -> Vec<VirtualLight<'a>> {
        const GRAIN: usize = 64;
        let chunks: Vec<Vec<VirtualLight<'a>>> = (0..self.count.div_ceil(GRAIN))
            .into_par_iter()
            .map(|chunk| {
                let caster = self.scene.tracer().caster(counter);
                let mut lights = Vec::new();
                let first = chunk * GRAIN;
                for path in first..(first + GRAIN).min(self.count) {
                    self.trace_one(&caster, path, &mut lights);
                }
                lights
            })
            .collect();
        chunks.into_iter().flatten().collect()
    }

    fn trace_one(&self, caster: &Caster, path: usize, lights: &mut Vec<VirtualLight<'a>>) {
        // Powers of the reciprocal of the plastic number: the R2 sequence.
        const STEP: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];
        let mut rng = Rng::new(self.seed, self.stream, path as u64, 0);
        let choice = (path as f64 + rng.next_f64()) / self.count as f64;
        let point = [0, 1].map(|a| (self.shift[a] + path as f64 * STEP[a]).fract());
        let sources = self.scene.lights();
        let Some(start) = sources.emit(choice.min(1.0 - f64::EPSILON), point, &mut rng) else {
            return;
        };
        let share = 1.0 / self.count as f32;
        lights.extend(start.source.map(|source| self.direct(&source, share)));
        let mut power = start.power * share;
        let mut ray = start.ray;
        for _ in 0..self.longest {
            let leg = Leg::from_camera(ray);
            let Met::Surface(Vertex { at, .. }) = self.scene.meet(caster, leg, &mut rng) else {
                break;
            };
            if !at.bsdf.is_delta() {
                lights.push(self.indirect(&at, power));
            }
            let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
            let Some(sample) = at.sample(u) else { break };
            let mut weight = sample.weight;
            if !sample.delta {
                weight *= at.adjoint(sample.direction);
            }
            let survival = (weight.element_sum() / 3.0).min(1.0);
            if survival.is_nan() || rng.next_f32() >= survival {
                break;
            }
            power = power * weight / survival;
            ray = sources.spawn(&at, sample.direction);
        }
    }

    /// The start of a path as a light.
    fn direct(&self, source: &Source, share: f32) -> VirtualLight<'a> {
        match *source {
            Source::Surface {
                position,
                normal,
                intensity,
            } => VirtualLight {
                position,
                end: offset_origin(position, normal, self.diagonal),
                normal,
                emission: Emission::Cosine {
                    intensity: intensity * share,
                    shading_normal: normal,
                },
            },
            Source::Infinity {
                direction,
                irradiance,
            } => VirtualLight::at_infinity(direction, irradiance * share),
        }
    }

    /// A surface point that `power` has reached, as a light.
    fn indirect(&self, at: &Interaction<'a>, power: Vec3) -> VirtualLight<'a> {
        let normal = at.facing_normal();
        let emission = match at.lambertian() {
            Some(scattering) => {
                let shading_normal = at.facing_shading_normal();
                // The part of the adjoint factor that belongs to the incident direction; the other
                // part makes the outgoing cosine geometric.
                let turned = if shading_normal == normal {
                    1.0
                } else {
                    at.view.dot(shading_normal) / at.view.dot(normal)
                };
                Emission::Cosine {
                    intensity: scattering * power * turned,
                    shading_normal,
                }
            }
            None => Emission::Glossy {
                at: Box::new(*at),
                power,
            },
        };
        VirtualLight {
            position: at.position,
            end: offset_origin(at.position, normal, self.diagonal),
            normal,
            emission,
        }
    }
}

impl Facing {
    fn new(lights: &[VirtualLight]) -> Self {
        let row = |of: fn(&VirtualLight) -> Vec3, axis: usize| {
            std::array::from_fn(|lane| lights.get(lane).map_or(0.0, |light| of(light)[axis]))
        };
        Self {
            position: [0, 1, 2].map(|axis| row(|light| light.position, axis)),
            normal: [0, 1, 2].map(|axis| row(|light| light.normal, axis)),
        }
    }
}

impl<'a> VirtualLight<'a> {
    fn at_point(light: &'a PointLight) -> Self {
        Self {
            position: light.position,
            end: light.position,
            normal: Vec3::Y,
            emission: Emission::Point(light),
        }
    }

    fn at_infinity(direction: Vec3, irradiance: Vec3) -> Self {
        Self {
            position: Vec3::ZERO,
            end: Vec3::ZERO,
            normal: direction,
            emission: Emission::Infinity { irradiance },
        }
    }

    fn power(&self) -> Vec3 {
        match self.emission {
            Emission::Cosine { intensity, .. } => intensity,
            Emission::Glossy { power, .. } => power,
            Emission::Point(light) => light.intensity.into(),
            Emission::Infinity { irradiance } => irradiance,
        }
    }

    fn is_finite(&self) -> bool {
        self.power().is_finite() && self.position.is_finite() && self.normal.is_finite()
    }

    fn shines(&self) -> bool {
        self.power().max_element() > 0.0
    }
}

/// Sorts along a space-filling curve: those on surfaces, then points, then those at infinity by
/// direction. Returns the number of the first and of the first two. Equal keys keep the order of
/// their paths.
fn sort(lights: &mut [VirtualLight], diagonal: f32) -> [usize; 2] {
    let key = |light: &VirtualLight| match light.emission {
        Emission::Infinity { .. } => (2, curve(light.normal * 0.5 + 0.5)),
        Emission::Point(_) => (1, curve(light.position / diagonal + 0.5)),
        _ => (0, curve(light.position / diagonal + 0.5)),
    };
    lights.sort_by_key(key);
    [1, 2].map(|kind| lights.partition_point(|light| key(light).0 < kind))
}

/// Position along a Z-curve of a point in the unit cube, 20 bits an axis.
fn curve(point: Vec3) -> u64 {
    let spread = |x: f32| {
        let mut x = (x.clamp(0.0, 1.0) * 1_048_575.0) as u64;
        for (shift, mask) in [
            (32, 0x001f_0000_0000_ffff),
            (16, 0x001f_0000_ff00_00ff),
            (8, 0x100f_00f0_0f00_f00f),
            (4, 0x10c3_0c30_c30c_30c3),
            (2, 0x1249_2492_4924_9249),
        ] {
            x = (x | x << shift) & mask;
        }
        x
    };
    spread(point.x) | spread(point.y) << 1 | spread(point.z) << 2
}
