//! Filling a cache along camera paths (Roth et al. 2020, section 3.2).
//!
//! Every one of the first ℓ_store vertices of a path that has a diffuse base gives a sample of the light on it: what
//! lights send there, and what the next ℓ_len vertices send back along the path. In the paper's equation 1 the product
//! of throughputs ends one vertex early, because the energy of the last one is reflected already; and it is divided by
//! no albedo: the base's share of the scattering is used instead, which also has a value on black surfaces.

use glam::Vec3;
use rayon::prelude::*;

use super::camera::{jittered, viewer_key};
use crate::cache::hash::Sample;
use crate::entry::words;
use crate::sample::Rng;
use crate::shade::{Interaction, Leg, Lobes, Met, PathTracer};
use crate::technique::Shot;
use crate::trace::{Caster, Ray, RayCounter};

words! {
    /// What becomes of diffuse surfaces under a coating.
    pub enum Coatings {
        /// Their base is cached, the coating is followed.
        Cached = "cached",
        /// They are followed like other glossy surfaces: only Lambertian ones are cached, as the paper's text says.
        Followed = "followed",
    }
}

/// How long paths are, and what is stored of them.
#[derive(Clone, Copy, Debug)]
pub struct SubPaths {
    /// ℓ_store: vertices that are stored.
    pub stored: usize,
    /// ℓ_len: vertices behind a stored one whose light counts.
    pub length: usize,
    pub coatings: Coatings,
}

impl SubPaths {
    /// ℓ_rec: most vertices of a path.
    pub fn most(&self) -> usize {
        self.stored + self.length
    }

    /// Whether the light on a surface is cached.
    pub fn caches(&self, at: &Interaction) -> bool {
        match self.coatings {
            Coatings::Cached => at.bsdf.has_base(),
            Coatings::Followed => at.bsdf.has_base() && at.gloss_chance() == 0.0,
        }
    }
}

/// A vertex that a path has left behind.
struct Passed {
    /// Scattering × cosine / density towards the next vertex, of all lobes and of the base without its colour.
    weight: Vec3,
    base: f32,
    /// What it gives to the cache, if it is stored.
    sample: Option<Sample>,
}

/// A path that fills a cache.
#[derive(Default)]
struct FillingPath {
    passed: Vec<Passed>,
}

impl FillingPath {
    /// Adds light that vertex `last` sends back (`scattered`) to the vertices before it, and to itself what its base
    /// gets of it.
    fn add(&mut self, last: usize, scattered: Vec3, base: Vec3, length: usize) {
        if let Some(sample) = &mut self.passed[last].sample {
            sample.value += base;
        }
        let mut carried = scattered;
        for vertex in self.passed[last.saturating_sub(length)..last]
            .iter_mut()
            .rev()
        {
            if let Some(sample) = &mut vertex.sample {
                sample.value += vertex.base * carried;
            }
            carried *= vertex.weight;
        }
    }

    /// Adds emission that the leg from the last vertex met.
    fn add_emission(&mut self, emission: Vec3, length: usize) {
        if emission == Vec3::ZERO {
            return;
        }
        if let Some(vertex) = self.passed.last() {
            let (scattered, base) = (vertex.weight * emission, vertex.base * emission);
            self.add(self.passed.len() - 1, scattered, base, length);
        }
    }

    /// Whether what follows the last vertex still counts for one that is stored.
    fn goes_on(&self, rule: &SubPaths) -> bool {
        let count = self.passed.len();
        let first = count.saturating_sub(1 + rule.length);
        count < rule.stored || self.passed[first..].iter().any(|v| v.sample.is_some())
    }

    /// Follows a path from what its first leg met and appends its samples.
    fn trace<'p>(
        &mut self,
        paths: &'p PathTracer,
        caster: &Caster,
        mut met: Met<'p>,
        rule: &SubPaths,
        rng: &mut Rng,
        samples: &mut Vec<Sample>,
    ) {
        self.passed.clear();
        loop {
            let vertex = match met {
                Met::Sky { passed, sky } => {
                    self.add_emission(passed + sky, rule.length);
                    break;
                }
                Met::Surface(vertex) => vertex,
            };
            self.add_emission(vertex.emission, rule.length);
            let index = self.passed.len();
            if index == rule.most() {
                break;
            }
            let at = &vertex.at;
            let stored = index < rule.stored && rule.caches(at);
            self.passed.push(Passed {
                weight: Vec3::ZERO,
                base: 0.0,
                sample: stored.then(|| Sample {
                    position: at.position,
                    normal: at.facing_normal(),
                    value: Vec3::ZERO,
                }),
            });
            if !self.goes_on(rule) {
                break;
            }
            if !at.bsdf.is_delta()
                && let Some(lit) = paths.lit(caster, at, Lobes::All, rng)
            {
                self.add(index, lit.scattered, lit.base, rule.length);
            }
            let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
            let Some(scattered) = paths.scattered(at, Lobes::All, u) else {
                break;
            };
            self.passed[index].weight = scattered.weight;
            self.passed[index].base = scattered.base;
            met = paths.meet(caster, scattered.leg, rng);
        }
        samples.extend(self.passed.iter().filter_map(|vertex| vertex.sample));
    }
}

/// One filling pass over a shot.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    pub seed: u64,
    /// Number of the pass among all of the sequence.
    pub number: u64,
    /// The caching resolution factor: paths along a side of a pixel.
    pub resolution_factor: f32,
}

/// Keys the random numbers of filling paths.
const STREAM: u64 = 0x6669_6c6c_6361;
/// Paths along a side of the tiles whose camera rays are cast together.
const TILE: usize = 8;

/// The samples of one path through each place of the caching resolution, in the order of tiles.
pub fn samples(shot: &Shot, pass: &Pass, rule: &SubPaths, counter: &RayCounter) -> Vec<Sample> {
    let scaled = |size: usize| ((size as f32 * pass.resolution_factor).round() as usize).max(1);
    let size = [scaled(shot.width), scaled(shot.height)];
    let bands: Vec<Vec<Sample>> = (0..size[1].div_ceil(TILE))
        .into_par_iter()
        .map_init(
            || (shot.tracer.caster(counter), FillingPath::default()),
            |(caster, path), band| {
                let mut samples = Vec::new();
                for left in (0..size[0]).step_by(TILE) {
                    let tile = Tile {
                        size,
                        corner: [left, band * TILE],
                    };
                    tile.fill(shot, pass, rule, caster, path, &mut samples);
                }
                samples
            },
        )
        .collect();
    bands.concat()
}

/// Neighbouring paths of the caching resolution.
struct Tile {
    size: [usize; 2],
    corner: [usize; 2],
}

impl Tile {
    fn fill(
        &self,
        shot: &Shot,
        pass: &Pass,
        rule: &SubPaths,
        caster: &Caster,
        path: &mut FillingPath,
        samples: &mut Vec<Sample>,
    ) {
        let end = [0, 1].map(|axis| (self.corner[axis] + TILE).min(self.size[axis]));
        let mut randoms = Vec::with_capacity(TILE * TILE);
        let mut directions = Vec::with_capacity(TILE * TILE);
        for y in self.corner[1]..end[1] {
            for x in self.corner[0]..end[0] {
                let place = (y * self.size[0] + x) as u64;
                let mut rng = Rng::new(pass.seed, STREAM ^ viewer_key(shot), place, pass.number);
                directions.push(jittered(shot, [x, y], self.size, &mut rng));
                randoms.push(rng);
            }
        }
        let origin = shot.view.origin.as_vec3();
        let mut hits = vec![None; directions.len()];
        caster.closest_bundle(origin, &directions, f32::INFINITY, &mut hits);
        for ((direction, hit), rng) in directions.iter().zip(hits).zip(&mut randoms) {
            let leg = Leg::from_camera(Ray::new(origin, *direction));
            let met = shot.paths.meet_from(caster, leg, hit, rng);
            path.trace(&shot.paths, caster, met, rule, rng, samples);
        }
    }
}
