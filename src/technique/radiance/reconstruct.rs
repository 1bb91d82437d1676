//! Reconstruction from a cache (Roth et al. 2020, section 3.3): camera samples are followed through gloss until a
//! surface without any, and the light on diffuse bases is looked up.

use glam::Vec3;

use super::camera::{jittered, viewer_key};
use super::fill::SubPaths;
use super::layers::{GlossVertex, LayerRow, LayerVertex};
use crate::cache::hash::{Grid, HashCells, Look};
use crate::entry::words;
use crate::sample::{Frame, Rng, hash};
use crate::shade::{Interaction, Leg, Lobes, Met, Vertex};
use crate::technique::Shot;
use crate::trace::{Caster, Ray};

words! {
    /// What is shown where a cell has no samples.
    pub enum Holes {
        /// The mean of neighbouring pixels.
        Neighbours = "neighbours",
        /// The finest coarser cell that has samples.
        Coarser = "coarser",
    }
}

/// How a cache is read.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    pub sub_paths: SubPaths,
    /// s_j: jitter in cells.
    pub jitter: f32,
    /// Side of a cell in projected pixels.
    pub cell_pixels: f32,
    /// Samples that a cell must have.
    pub least_samples: u32,
    pub holes: Holes,
    pub seed: u64,
    /// Number of the camera sample among all of the sequence.
    pub number: u64,
}

impl Reading {
    /// The level that is read at the end of a path of this length, scene units.
    fn level(&self, shot: &Shot, grid: &Grid, path_length: f32) -> u32 {
        let finest = grid.levels();
        let [_, half] = shot.view.half_tangents(shot.width, shot.height);
        let pixel = path_length * (2.0 * half / shot.height as f64) as f32;
        let wanted = pixel * self.cell_pixels / grid.cell_size(finest);
        let coarser = wanted.max(1.0).log2().floor() as u32;
        finest.saturating_sub(coarser)
    }

    /// A key of the cell that is read without jitter for what the camera sees; `None` for surfaces that are not cached
    /// and for holes.
    pub fn cell(&self, shot: &Shot, cells: &HashCells, seen: &Vertex) -> Option<u64> {
        if !self.sub_paths.caches(&seen.at) {
            return None;
        }
        let (position, normal) = (seen.at.position, seen.at.facing_normal());
        let wanted = self.level(shot, cells.grid(), seen.distance);
        let coarsest = match self.holes {
            Holes::Neighbours => wanted,
            Holes::Coarser => 0,
        };
        let is_known = |level: &u32| match cells.look(*level, position, normal) {
            Look::Found { samples, .. } => samples >= self.least_samples,
            Look::Absent | Look::Empty => false,
        };
        let level = (coarsest..=wanted).rev().find(is_known)?;
        let key = cells.grid().key_at(level, position)?;
        Some(hash(key) ^ u64::from(level))
    }
}

/// What reading took and met.
#[derive(Clone, Copy, Debug, Default)]
pub struct Read {
    pub lookups: u64,
    /// Lookups that found no samples, or no cell.
    pub misses: u64,
    /// Looks at places without a cell; a map without keys would have read another cell there.
    pub absent: u64,
    /// Paths that were still glossy at their last vertex.
    pub cut: u64,
    /// Values that were not finite and count as black.
    pub non_finite: u64,
    /// Layers that were used.
    pub depth: usize,
}

impl Read {
    pub fn add(&mut self, other: &Self) {
        self.lookups += other.lookups;
        self.misses += other.misses;
        self.absent += other.absent;
        self.cut += other.cut;
        self.non_finite += other.non_finite;
        self.depth = self.depth.max(other.depth);
    }
}

/// Keys the random numbers of camera samples.
const STREAM: u64 = 0x7265_636f_6e73;
/// Jittered places that are tried.
const TRIES: usize = 3;

/// Follows the camera samples of one row of pixels and puts their vertices into layers.
pub fn row(
    shot: &Shot,
    cells: &HashCells,
    reading: &Reading,
    caster: &Caster,
    mut layers: LayerRow,
    y: usize,
) -> Read {
    let mut reader = Reader {
        shot,
        cells,
        reading,
        read: Read::default(),
    };
    let size = [shot.width, shot.height];
    let origin = shot.view.origin.as_vec3();
    let mut randoms: Vec<Rng> = (0..shot.width)
        .map(|x| {
            let pixel = (y * shot.width + x) as u64;
            Rng::new(
                reading.seed,
                STREAM ^ viewer_key(shot),
                pixel,
                reading.number,
            )
        })
        .collect();
    let directions: Vec<Vec3> = randoms
        .iter_mut()
        .enumerate()
        .map(|(x, rng)| jittered(shot, [x, y], size, rng))
        .collect();
    let mut hits = vec![None; directions.len()];
    caster.closest_bundle(origin, &directions, f32::INFINITY, &mut hits);
    for (x, rng) in randoms.iter_mut().enumerate() {
        let leg = Leg::from_camera(Ray::new(origin, directions[x]));
        let met = shot.paths.meet_from(caster, leg, hits[x], rng);
        reader.follow(caster, met, &mut layers, x, rng);
    }
    reader.read
}

/// Reads a cache for one shot.
struct Reader<'a> {
    shot: &'a Shot<'a>,
    cells: &'a HashCells,
    reading: &'a Reading,
    read: Read,
}

impl<'a> Reader<'a> {
    fn follow(
        &mut self,
        caster: &Caster,
        mut met: Met<'a>,
        layers: &mut LayerRow,
        x: usize,
        rng: &mut Rng,
    ) {
        let most = self.reading.sub_paths.most();
        let mut path_length = 0.0;
        let mut behind: Option<LayerVertex> = None;
        for layer in 0..=most {
            let segment = match &met {
                Met::Sky { .. } => self.shot.scene.diagonal,
                Met::Surface(vertex) => vertex.distance,
            };
            if let Some(mut vertex) = behind.take() {
                vertex.segment = segment;
                layers.put(layer - 1, x, &vertex);
            }
            if layer == most {
                self.read.cut += 1;
                return;
            }
            self.read.depth = self.read.depth.max(layer + 1);
            let at = match met {
                Met::Sky { passed, sky } => {
                    let emission = self.finite(passed + sky);
                    let sky = LayerVertex {
                        emission,
                        ..LayerVertex::default()
                    };
                    layers.put(layer, x, &sky);
                    return;
                }
                Met::Surface(vertex) => vertex,
            };
            path_length += at.distance;
            let mut vertex = self.seen(&at, path_length, rng);
            let next = self.reflected(caster, &at.at, &mut vertex, rng);
            let Some(leg) = next else {
                layers.put(layer, x, &vertex);
                return;
            };
            behind = Some(vertex);
            met = self.shot.paths.meet(caster, leg, rng);
        }
    }

    /// A vertex with the cached light on it.
    fn seen(&mut self, met: &Vertex, path_length: f32, rng: &mut Rng) -> LayerVertex {
        let at = &met.at;
        let mut vertex = LayerVertex {
            normal: at.facing_normal(),
            path_length,
            emission: self.finite(met.emission),
            ..LayerVertex::default()
        };
        if self.reading.sub_paths.caches(at) {
            vertex.albedo = Some(self.finite(at.base_albedo()));
            (vertex.base, vertex.hole) = self.light(at.position, vertex.normal, path_length, rng);
        }
        vertex
    }

    /// Adds what the vertex reflects of lights, and gives the leg on which more is found.
    fn reflected(
        &mut self,
        caster: &Caster,
        at: &Interaction,
        vertex: &mut LayerVertex,
        rng: &mut Rng,
    ) -> Option<Leg> {
        let lobes = match vertex.albedo {
            Some(_) => Lobes::Gloss,
            None => Lobes::All,
        };
        if lobes == Lobes::Gloss && at.gloss_chance() == 0.0 {
            return None;
        }
        let mut gloss = GlossVertex {
            mirror: matches!(at.bsdf.model, crate::shade::bsdf::Model::Mirror(_)),
            ..GlossVertex::default()
        };
        let samples_lights = match lobes {
            Lobes::All => !at.bsdf.is_delta(),
            Lobes::Gloss => !at.bsdf.gloss_is_delta(),
        };
        if samples_lights && let Some(lit) = self.shot.paths.lit(caster, at, lobes, rng) {
            gloss.light = self.finite(lit.scattered);
        }
        let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        let scattered = self.shot.paths.scattered(at, lobes, u);
        if let Some(scattered) = &scattered {
            gloss.throughput = self.finite(scattered.weight);
        }
        vertex.gloss = Some(gloss);
        scattered.map(|scattered| scattered.leg)
    }

    /// The light on a surface point, and whether it is a guess of coarser cells.
    fn light(
        &mut self,
        position: Vec3,
        normal: Vec3,
        path_length: f32,
        rng: &mut Rng,
    ) -> (Vec3, bool) {
        let grid = self.cells.grid();
        let level = self.reading.level(self.shot, grid, path_length);
        let reach = grid.cell_size(level) * self.reading.jitter;
        if reach > 0.0 {
            let frame = Frame::from_normal(normal);
            for _ in 0..TRIES {
                let [u, v] = [0; 2].map(|_| 2.0 * rng.next_f32() - 1.0);
                let place = position + (frame.tangent * u + frame.bitangent * v) * reach;
                if let Some(light) = self.look(level, place, normal) {
                    return (light, false);
                }
            }
        }
        if let Some(light) = self.look(level, position, normal) {
            return (light, false);
        }
        let is_hole = self.reading.holes == Holes::Neighbours;
        for level in (0..level).rev() {
            if let Some(light) = self.look(level, position, normal) {
                return (light, is_hole);
            }
        }
        (Vec3::ZERO, true)
    }

    fn look(&mut self, level: u32, position: Vec3, normal: Vec3) -> Option<Vec3> {
        self.read.lookups += 1;
        let look = self.cells.look(level, position, normal);
        if let Look::Found { value, samples } = look
            && samples >= self.reading.least_samples
        {
            return Some(value);
        }
        self.read.misses += 1;
        self.read.absent += u64::from(look == Look::Absent);
        None
    }

    fn finite(&mut self, value: Vec3) -> Vec3 {
        if value.is_finite() {
            return value;
        }
        self.read.non_finite += 1;
        Vec3::ZERO
    }
}
