//! Shades an image from finished records: a block of pixels goes from camera rays through lookups to pixels on one
//! thread. Samples that no record serves are evaluated afterwards, by all threads.

use glam::Vec3;
use rayon::prelude::*;

use super::Records;
use super::lookup::MOST_USED;
use crate::cache::{Neighbour, SearchSpace, Weighted, inverse_distance_weights};
use crate::image::Image;
use crate::technique::shot::{TILE, tile_pixels};
use crate::technique::{Seen, Shot};
use crate::trace::{Caster, RayCounter};

/// Pixels along a side of a block, a multiple of [`TILE`].
const BLOCK: usize = 32;
/// Most queries that are sorted and answered together.
const RUN: usize = 1 << 14;

/// Shades all samples of a shot from finished records.
pub(super) struct Shader<'a> {
    pub shot: &'a Shot<'a>,
    pub records: &'a Records<'a>,
    pub counter: &'a RayCounter,
}

/// An image made from records.
#[derive(Default)]
pub(super) struct Shaded {
    pub image: Image,
    pub lookups: u64,
    /// Values that were left out.
    pub non_finite: u64,
}

/// A pixel with samples that no record serves.
struct Waiting {
    /// Place in the array of blocks.
    place: usize,
    /// Values of the samples that see a surface, `None` where one is waited for.
    values: Vec<Option<[f32; 3]>>,
    /// What the samples see that are waited for, in order.
    seen: Vec<Seen>,
}

/// What a block adds to the image besides its pixels.
#[derive(Default)]
struct BlockCounts {
    lookups: u64,
    non_finite: u64,
    waiting: Vec<Waiting>,
}

impl Shader<'_> {
    pub fn image(&self) -> Shaded {
        let shot = self.shot;
        let across = shot.width.div_ceil(BLOCK);
        let count = across * shot.height.div_ceil(BLOCK);
        let mut blocks = vec![[0.0f32; 3]; count * BLOCK * BLOCK];
        let done: Vec<BlockCounts> = blocks
            .par_chunks_mut(BLOCK * BLOCK)
            .enumerate()
            .map_init(
                || Worker::new(self),
                |worker, (block, pixels)| {
                    let corner = [block % across * BLOCK, block / across * BLOCK];
                    let mut counts = worker.shade_block(corner, pixels);
                    let first = block * BLOCK * BLOCK;
                    counts.waiting.iter_mut().for_each(|w| w.place += first);
                    counts
                },
            )
            .collect();
        let mut shaded = Shaded {
            image: Image::new(shot.width, shot.height),
            ..Shaded::default()
        };
        let mut waiting = Vec::new();
        for counts in done {
            shaded.lookups += counts.lookups;
            shaded.non_finite += counts.non_finite;
            waiting.extend(counts.waiting);
        }
        shaded.non_finite += self.serve(waiting, &mut blocks);
        let rows = shaded.image.pixels.par_chunks_mut(shot.width.max(1));
        rows.enumerate().for_each(|(y, row)| {
            for (x, strip) in row.chunks_mut(BLOCK).enumerate() {
                let block = y / BLOCK * across + x;
                let first = (block * BLOCK + y % BLOCK) * BLOCK;
                strip.copy_from_slice(&blocks[first..first + strip.len()]);
            }
        });
        shaded
    }

    /// Evaluates the samples that are waited for and completes their pixels; returns the number of values that are
    /// not finite.
    fn serve(&self, waiting: Vec<Waiting>, blocks: &mut [[f32; 3]]) -> u64 {
        let seen: Vec<&Seen> = waiting.iter().flat_map(|pixel| &pixel.seen).collect();
        let function = self.records.function.as_ref();
        let values: Vec<[f32; 3]> = seen
            .into_par_iter()
            .map_init(
                || self.shot.tracer.caster(self.counter),
                |caster, seen| function.shade_missed(caster, seen),
            )
            .collect();
        let mut values = values.into_iter();
        let mut non_finite = 0;
        for pixel in waiting {
            let mut mean = PixelMean::default();
            for value in pixel.values {
                mean.add(value.or_else(|| values.next()).unwrap_or_default());
            }
            blocks[pixel.place] = mean.over(self.shot.spp, function.background());
            non_finite += mean.non_finite;
        }
        non_finite
    }
}

/// Sum of the samples of a pixel that see a surface.
#[derive(Default)]
struct PixelMean {
    sum: [f64; 3],
    hits: u32,
    non_finite: u64,
}

impl PixelMean {
    fn add(&mut self, value: [f32; 3]) {
        self.hits += 1;
        if value.iter().all(|v| v.is_finite()) {
            (0..3).for_each(|c| self.sum[c] += f64::from(value[c]));
        } else {
            self.non_finite += 1;
        }
    }

    /// The mean over all samples; those that see no surface have the background's value.
    fn over(&self, spp: u32, background: [f32; 3]) -> [f32; 3] {
        let open = f64::from(spp - self.hits);
        std::array::from_fn(|c| {
            ((self.sum[c] + open * f64::from(background[c])) / f64::from(spp)) as f32
        })
    }
}

/// What one thread needs to shade blocks.
struct Worker<'a> {
    shader: &'a Shader<'a>,
    caster: Caster<'a>,
    space: SearchSpace,
    seen: Vec<Seen>,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    values: Vec<Option<[f32; 3]>>,
}

impl<'a> Worker<'a> {
    fn new(shader: &'a Shader<'a>) -> Self {
        Self {
            shader,
            caster: shader.shot.tracer.caster(shader.counter),
            space: SearchSpace::default(),
            seen: Vec::new(),
            positions: Vec::new(),
            normals: Vec::new(),
            values: Vec::new(),
        }
    }

    fn shade_block(&mut self, [left, top]: [usize; 2], pixels: &mut [[f32; 3]]) -> BlockCounts {
        let shot = self.shader.shot;
        let background = self.shader.records.function.background();
        pixels.fill(PixelMean::default().over(shot.spp, background));
        self.seen.clear();
        for y in (top..(top + BLOCK).min(shot.height)).step_by(TILE) {
            for x in (left..(left + BLOCK).min(shot.width)).step_by(TILE) {
                let tile = tile_pixels(shot, [x, y], top + BLOCK);
                shot.look_tile(&self.caster, &tile, 0..shot.spp, &mut self.seen);
            }
        }
        self.look_up();
        let mut counts = BlockCounts {
            lookups: self.seen.len() as u64,
            ..BlockCounts::default()
        };
        let mut first = 0;
        for samples in self.seen.chunk_by(|a, b| a.pixel == b.pixel) {
            let values = &self.values[first..first + samples.len()];
            first += samples.len();
            let pixel = samples[0].pixel as usize;
            let place = (pixel / shot.width - top) * BLOCK + pixel % shot.width - left;
            if values.iter().any(Option::is_none) {
                let missed = samples.iter().zip(values).filter(|(_, v)| v.is_none());
                counts.waiting.push(Waiting {
                    place,
                    values: values.to_vec(),
                    seen: missed.map(|(seen, _)| *seen).collect(),
                });
                continue;
            }
            let mut mean = PixelMean::default();
            values.iter().flatten().for_each(|value| mean.add(*value));
            pixels[place] = mean.over(shot.spp, background);
            counts.non_finite += mean.non_finite;
        }
        counts
    }

    /// Values of what was seen, from records.
    fn look_up(&mut self) {
        let records = self.shader.records;
        let function = records.function.as_ref();
        let diagonal = self.shader.shot.scene.diagonal;
        let power = records.interpolation.power();
        self.values.clear();
        self.values.resize(self.seen.len(), None);
        for (seen, values) in self.seen.chunks(RUN).zip(self.values.chunks_mut(RUN)) {
            self.positions.clear();
            self.positions.extend(seen.iter().map(|s| s.site.position));
            self.normals.clear();
            self.normals.extend(seen.iter().map(|s| s.site.normal));
            let caster = &self.caster;
            let answer = |query: usize, neighbours: &[Neighbour]| {
                let mut weights = [0.0; MOST_USED];
                let weights = &mut weights[..neighbours.len()];
                inverse_distance_weights(neighbours, diagonal, power, weights);
                let near = Weighted {
                    neighbours,
                    weights,
                };
                values[query] = function.shade(caster, &seen[query], near);
            };
            let (positions, normals) = (&self.positions, &self.normals);
            let space = &mut self.space;
            records.search.answer_run(space, positions, normals, answer);
        }
    }
}
