//! A record with gradients (Ward & Heckbert 1992), from a stratified cosine-distributed hemisphere.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use crate::sample::{Frame as LocalFrame, Rng};
use crate::shade::Depths;
use crate::technique::irradiance_caching::gather::{cast, travelled};
use crate::technique::{Shot, Site};
use crate::trace::RayCounter;

/// Keys the paths of these records.
const STREAM: u64 = 0x6f6e_6465_6d61;

/// Indirect irradiance at a point and how it changes around it. Columns of the gradients belong to
/// the colour channels.
#[derive(Clone, Copy, Debug)]
pub struct Record {
    pub site: Site,
    pub irradiance: Vec3,
    /// By rotation of the normal, per radian.
    pub rotation: Mat3,
    /// By translation, per scene unit.
    pub translation: Mat3,
    /// Harmonic mean of the distances that the rays travelled; infinite if nothing is near.
    pub mean_distance: f32,
    /// Least distance of the rays that are more than 10° above the surface.
    pub least_distance: f32,
    /// Radiances that were not finite and count as 0.
    pub non_finite: u64,
}

/// Strata of the hemisphere.
#[derive(Clone, Copy, Debug)]
pub struct Strata {
    /// M: polar.
    pub polar: usize,
    /// N ≈ π M: azimuthal.
    pub azimuthal: usize,
}

impl Strata {
    /// About `rays` strata with N ≈ π M.
    pub fn of(rays: usize) -> Self {
        let polar = ((rays as f64 / std::f64::consts::PI).sqrt().round() as usize).max(1);
        Self {
            polar,
            azimuthal: rays.div_ceil(polar).max(1),
        }
    }
}

/// Radiance and distance of each stratum, azimuth by azimuth.
struct Hemisphere {
    strata: Strata,
    radiance: Vec<Vec3>,
    distance: Vec<f32>,
}

/// What a record is evaluated with.
pub struct Evaluator<'a> {
    pub shot: &'a Shot<'a>,
    pub strata: Strata,
    pub depths: Depths,
    pub seed: u64,
}

impl Evaluator<'_> {
    /// The record at a site; `pixel` keys its paths.
    pub fn evaluate(&self, site: &Site, pixel: u32, counter: &RayCounter) -> Record {
        let Strata { polar, azimuthal } = self.strata;
        let local = LocalFrame::from_normal(site.normal);
        let mut hemisphere = Hemisphere {
            strata: self.strata,
            radiance: Vec::with_capacity(polar * azimuthal),
            distance: Vec::with_capacity(polar * azimuthal),
        };
        let (mut non_finite, mut least, mut inverse) = (0, f32::INFINITY, 0.0f64);
        let aim = |i: usize| {
            let mut rng = Rng::new(self.seed, STREAM, u64::from(pixel), i as u64);
            let (k, j) = (i / polar, i % polar);
            let sin = ((j as f32 + rng.next_f32()) / polar as f32).sqrt().min(1.0);
            let azimuth = TAU * (k as f32 + rng.next_f32()) / azimuthal as f32;
            let cos = (1.0 - sin * sin).sqrt();
            let direction = local.to_world(polar_vector(azimuth) * sin + Vec3::Z * cos);
            (rng, cos, direction)
        };
        let strata = polar * azimuthal;
        let trace = |task: usize| {
            let caster = self.shot.tracer.caster(counter);
            let start = task * RAYS_A_TASK;
            let aimed: Vec<(Rng, f32, Vec3)> =
                (start..strata.min(start + RAYS_A_TASK)).map(aim).collect();
            let directions: Vec<Vec3> = aimed.iter().map(|(_, _, direction)| *direction).collect();
            let rays = cast(self.shot, &caster, site, &directions);
            let follow = |((mut rng, cos, _), (ray, hit))| {
                let distance = travelled(&hit);
                let paths = &self.shot.paths;
                (
                    paths.follow(&caster, ray, hit, &mut rng, self.depths),
                    distance,
                    cos,
                )
            };
            aimed.into_iter().zip(rays).map(follow).collect::<Vec<_>>()
        };
        let rays: Vec<Vec<(Vec3, f32, f32)>> = (0..strata.div_ceil(RAYS_A_TASK))
            .into_par_iter()
            .map(trace)
            .collect();
        for (radiance, distance, cos) in rays.into_iter().flatten() {
            let finite = radiance.is_finite();
            non_finite += u64::from(!finite);
            hemisphere
                .radiance
                .push(if finite { radiance } else { Vec3::ZERO });
            let distance = distance.max(self.shot.scene.diagonal * 1e-6);
            hemisphere.distance.push(distance);
            inverse += 1.0 / f64::from(distance);
            if cos > SIN_10_DEGREES {
                least = least.min(distance);
            }
        }
        let count = hemisphere.radiance.len() as f32;
        let to_world = Mat3::from_cols(local.tangent, local.bitangent, local.normal);
        Record {
            site: *site,
            irradiance: hemisphere.radiance.iter().sum::<Vec3>() * (PI / count),
            rotation: to_world * hemisphere.rotation(),
            translation: to_world * hemisphere.translation(),
            mean_distance: (f64::from(count) / inverse) as f32,
            least_distance: least,
            non_finite,
        }
    }
}

/// Rays that one task traces.
const RAYS_A_TASK: usize = 512;
const SIN_10_DEGREES: f32 = 0.173_648_18;

fn polar_vector(azimuth: f32) -> Vec3 {
    let (sin, cos) = azimuth.sin_cos();
    Vec3::new(cos, sin, 0.0)
}

/// The matrix whose column `c` is `direction` times channel `c` of `colour`.
fn outer(direction: Vec3, colour: Vec3) -> Mat3 {
    Mat3::from_cols(
        direction * colour.x,
        direction * colour.y,
        direction * colour.z,
    )
}

/// What a ray through a stratum brings.
struct Stratum {
    radiance: Vec3,
    /// To where it comes from.
    distance: f32,
}

impl Hemisphere {
    fn at(&self, k: usize, j: usize) -> Stratum {
        let i = k * self.strata.polar + j;
        Stratum {
            radiance: self.radiance[i],
            distance: self.distance[i],
        }
    }

    /// Sine of the lower bound of polar stratum `j`.
    fn sine_below(&self, j: usize) -> f32 {
        (j as f32 / self.strata.polar as f32).sqrt()
    }

    /// Sine at the centre of polar stratum `j`.
    fn sine(&self, j: usize) -> f32 {
        ((j as f32 + 0.5) / self.strata.polar as f32).sqrt()
    }

    /// `(π/MN) Σ_k v_k Σ_j −tan θ_j L_jk`, `v_k` at azimuth `φ_k − π/2`.
    fn rotation(&self) -> Mat3 {
        let Strata { polar, azimuthal } = self.strata;
        let mut sum = Mat3::ZERO;
        for k in 0..azimuthal {
            let azimuth = TAU * (k as f32 + 0.5) / azimuthal as f32;
            let tilted: Vec3 = (0..polar)
                .map(|j| {
                    let sin = self.sine(j);
                    self.at(k, j).radiance * (-sin / (1.0 - sin * sin).max(1e-6).sqrt())
                })
                .sum();
            sum += outer(polar_vector(azimuth - FRAC_PI_2), tilted);
        }
        sum * (PI / (polar * azimuthal) as f32)
    }

    /// The sum over the edges between strata: radiance differences times how fast an edge moves,
    /// which the nearer of its two sides tells.
    fn translation(&self) -> Mat3 {
        let Strata { polar, azimuthal } = self.strata;
        let mut sum = Mat3::ZERO;
        for k in 0..azimuthal {
            let azimuth = TAU * (k as f32 + 0.5) / azimuthal as f32;
            let radial: Vec3 = (1..polar)
                .map(|j| {
                    let sin = self.sine_below(j);
                    let rate = sin * (1.0 - sin * sin);
                    self.step(self.at(k, j), self.at(k, j - 1)) * rate
                })
                .sum();
            sum += outer(polar_vector(azimuth), radial * (TAU / azimuthal as f32));
            let before = (k + azimuthal - 1) % azimuthal;
            let around: Vec3 = (0..polar)
                .map(|j| {
                    let sin = self.sine(j);
                    let cosine = |sin: f32| (1.0 - sin * sin).max(0.0).sqrt();
                    let height = cosine(self.sine_below(j)) - cosine(self.sine_below(j + 1));
                    let rate = cosine(sin) * height / sin;
                    self.step(self.at(k, j), self.at(before, j)) * rate
                })
                .sum();
            let edge = TAU * k as f32 / azimuthal as f32;
            sum += outer(polar_vector(edge + FRAC_PI_2), around);
        }
        sum
    }

    fn step(&self, here: Stratum, there: Stratum) -> Vec3 {
        (here.radiance - there.radiance) / here.distance.min(there.distance)
    }
}
