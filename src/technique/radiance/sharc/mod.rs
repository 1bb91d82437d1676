//! The contender `sharc`: radiance in the cells of a world-space hash grid, allocated where paths come by, as NVIDIA's
//! Spatially Hashed Radiance Cache keeps it. It stands for what engines do today.
//!
//! Of each frame and pass one random pixel of each 5 × 5 sends a path that feeds the cache (`path`): what arrives at its
//! first diffuse vertices goes into their cells (`key`). A path may end on a cell known from earlier frames; where none
//! is known it goes on to the scene's `max_depth`. The samples of all viewers are sorted and merged at once (`table`).
//! Then as many camera paths a pixel as the budget says are followed to the first cell that is known behind the first
//! scattering.
//!
//! *Differs:* cells hold the light on diffuse bases without the base's colour, and the gloss above a base is followed
//! with its chance, where SHaRC stores all that is sent to whoever came by first. Numbers are 32-bit floats. All
//! vertices behind a stored one count, not the next three alone. Sides of cells are powers of two scene units, nearest
//! to `cell_pixels` projected pixels.

mod key;
mod path;
mod table;
#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::key::{Grid, Key};
use self::path::{Query, Rule, Tally, Walk};
use self::table::{Ages, Cell, Merged, Sample, Table};
use super::camera::{first_leg, viewer_key};
use super::cells::cell_numbers;
use super::filter::{Filter, FilterParameters};
use super::layers::{LayerVertex, Layers, Setting, Smoothing};
use crate::entry::{About, Bias, parameters};
use crate::image::{Image, ImageMean};
use crate::sample::Rng;
use crate::shade::Vertex;
use crate::technique::truth::Truth;
use crate::technique::{Contender, ContenderEntry, Rendered, Shot, Terms};
use crate::trace::{Caster, RayCounter};

/// Entry in the technique's list.
pub const ENTRY: ContenderEntry<Truth> = ContenderEntry {
    about: About {
        id: "sharc",
        module: crate::entry::head_comment!("mod.rs"),
        aliases: &["radiance-hash"],
        summary: "radiance in hashed cells by distance, fed by few paths of each frame, where camera paths end",
        source: "NVIDIA SHaRC 1.6; Binder, Fricke & Keller 2018 for the hashing",
        bias: Bias::Biased,
        version: 5,
        failures: &[
            "detail of indirect light below the size of a cell is lost, and light leaks between surfaces that share one",
            "where things or lights move, cells trail behind by up to `history` frames, and those of what has gone stay for `stale_frames`",
            "cells are blocks of one colour: with query = \"primary\" they are seen",
            "samples with heavy weights are limited, which darkens",
            "paths that end on a cell count light of more than max_depth edges",
        ],
        parameters: Parameters::PARAMETERS,
    },
    start: |_, table, terms| {
        let parameters = Parameters::read(table)?;
        Ok(Box::new(Sharc {
            table: Table::new(parameters.capacity),
            origins: Vec::new(),
            parameters,
            terms,
        }))
    },
};

parameters! {
    #[derive(Clone, Copy, Debug)]
    struct Parameters {
        /// Side of a cell in projected pixels of whoever looks, within a factor √2.
        cell_pixels: f32 = 6.0, Within(0.01, 1024.0), "pixels";
        /// Slots of the hash table, 32 bytes each.
        capacity: usize = 1 << 20, Within(1.0, 268_435_456.0);
        /// Pixels along a side of the tiles that send one feeding path each, in every frame and pass.
        update_tile: usize = 5, Within(1.0, 1024.0), "pixels";
        /// Vertices of a feeding path that are stored.
        update_vertices: u32 = 4, Within(1.0, 64.0);
        /// Whether feeding paths may end on the cache.
        resampling: bool = true;
        /// Whether rare bright samples of the cache are limited.
        limit: bool = true;
        /// Samples that a cell must have to be read.
        least_samples: u32 = 1, Within(1.0, 65535.0);
        /// Frames that the mean of a cell reaches back.
        history: u32 = 64, Within(1.0, 1024.0), "frames";
        /// Frames without a sample after which a cell is given up.
        stale_frames: u32 = 64, Within(8.0, 1024.0), "frames";
        /// Where camera paths may end on the cache.
        query: Query = Query::Secondary;
        /// Whether images are smoothed, by the filter of `hash-cache` on what the camera sees first.
        smoothed: bool = false;
        /// Kernel and edge-stopping of the filter.
        kernel: FilterParameters = FilterParameters::default();
    }
}

/// Keys the random numbers of feeding paths and of camera paths.
const STREAMS: [u64; 2] = [0x7368_6172_6375, 0x7368_6172_6371];

struct Sharc {
    parameters: Parameters,
    terms: Terms,
    table: Table,
    /// Where the viewers of the frame before stood.
    origins: Vec<DVec3>,
}

/// What is kept of a sequence that was interrupted.
#[derive(Serialize, Deserialize)]
struct Memory {
    cells: Vec<(u32, Key, Cell)>,
    origins: Vec<DVec3>,
}

impl Contender for Sharc {
    fn remembers(&self) -> bool {
        true
    }

    fn memory(&self) -> Result<Vec<u8>, String> {
        let memory = Memory {
            cells: self.table.stored(),
            origins: self.origins.clone(),
        };
        postcard::to_allocvec(&memory).map_err(|error| error.to_string())
    }

    fn recall(&mut self, memory: &[u8]) -> Result<(), String> {
        if !memory.is_empty() {
            let memory: Memory = postcard::from_bytes(memory).map_err(|error| error.to_string())?;
            self.table = Table::restored(self.parameters.capacity, &memory.cells)?;
            self.origins = memory.origins;
        }
        Ok(())
    }

    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        let mut images: Vec<Rendered> = shots.iter().map(|_| Rendered::default()).collect();
        let mut samples = Vec::new();
        for (shot, rendered) in shots.iter().zip(&mut images) {
            samples.extend(self.fed(shot, rendered));
        }
        if let Some(first) = images.first_mut() {
            let merged = first.stages.time("resolve", || self.merge(shots, samples));
            for rendered in &mut images {
                self.report(&merged, rendered);
            }
            // What viewers share is held once.
            images[0].bytes_cache = self.table.bytes();
        }
        for (shot, rendered) in shots.iter().zip(&mut images) {
            self.show(shot, rendered);
        }
        Ok(images)
    }

    /// Camera paths end on these with query = "primary"; with "secondary" on those of what they see next.
    fn cells(&self, shot: &Shot) -> Option<Vec<f32>> {
        let grid = Grid::new(shot, self.parameters.cell_pixels);
        let least = self.parameters.least_samples as f32;
        let key = |seen: &Vertex| {
            let at = &seen.at;
            let place = grid.place(at.position, at.facing_normal());
            let key = place.filter(|_| at.bsdf.has_base())?.key;
            let is_known = self
                .table
                .get(key)
                .is_some_and(|cell| cell.samples >= least);
            is_known.then(|| u64::from(key.hash()))
        };
        Some(cell_numbers(shot, key))
    }
}

impl Sharc {
    fn rule(&self) -> Rule {
        Rule {
            query: self.parameters.query,
            least_samples: self.parameters.least_samples as f32,
            resampling: self.parameters.resampling,
            stored: self.parameters.update_vertices,
            limit: self.parameters.limit,
        }
    }

    fn walk<'a>(&'a self, shot: &'a Shot<'a>) -> Walk<'a> {
        let grid = Grid::new(shot, self.parameters.cell_pixels);
        Walk::new(shot, grid, &self.table, self.rule())
    }

    /// Number of a pass of a frame among all of the sequence.
    fn number(&self, shot: &Shot, pass: u64) -> u64 {
        u64::from(shot.frame) * self.terms.budget as u64 + pass
    }

    /// The samples that feeding paths of one shot bring, tile by tile and pass by pass.
    fn fed(&self, shot: &Shot, rendered: &mut Rendered) -> Vec<Sample> {
        let counter = RayCounter::default();
        let tile = self.parameters.update_tile;
        let [columns, rows] = [shot.width, shot.height].map(|side| side.div_ceil(tile));
        let tiles: Vec<(Vec<Sample>, Tally)> = rendered.stages.time("update", || {
            (0..columns * rows)
                .into_par_iter()
                .map_init(
                    || shot.tracer.caster(&counter),
                    |caster, index| {
                        let corner = [index % columns * tile, index / columns * tile];
                        self.fed_by_tile(shot, caster, corner)
                    },
                )
                .collect()
        });
        let mut samples = Vec::new();
        let mut tally = Tally::default();
        for (brought, counted) in tiles {
            samples.extend(brought);
            tally.add(&counted);
        }
        rendered.rays += counter.read();
        count(&tally, rendered);
        samples
    }

    /// The samples of the tile whose top left pixel this is.
    fn fed_by_tile(
        &self,
        shot: &Shot,
        caster: &Caster,
        [left, top]: [usize; 2],
    ) -> (Vec<Sample>, Tally) {
        let tile = self.parameters.update_tile;
        let (width, height) = (shot.width.min(left + tile), shot.height.min(top + tile));
        let pixel = (top * shot.width + left) as u64;
        let mut walk = self.walk(shot);
        let mut samples = Vec::new();
        for pass in 0..self.terms.budget as u64 {
            let stream = STREAMS[0] ^ viewer_key(shot);
            let mut rng = Rng::new(self.terms.seed, stream, pixel, self.number(shot, pass));
            let x = left + rng.below(width - left);
            let y = top + rng.below(height - top);
            let leg = first_leg(shot, [x, y], &mut rng);
            walk.feed(caster, leg, &mut rng, &mut samples);
        }
        (samples, walk.tally)
    }

    /// Merges what all viewers brought. Adjacent levels are mixed in where a viewer has moved.
    fn merge(&mut self, shots: &[Shot], samples: Vec<Sample>) -> Merged {
        let origins: Vec<DVec3> = shots.iter().map(|shot| shot.view.origin).collect();
        let ages = Ages {
            history: self.parameters.history,
            stale: self.parameters.stale_frames,
            blend: !self.origins.is_empty() && self.origins != origins,
        };
        self.origins = origins;
        self.table.merge(samples, &ages)
    }

    fn report(&self, merged: &Merged, rendered: &mut Rendered) {
        let occupied = self.table.occupied() as f64;
        rendered.found.extend([
            ("cells", occupied),
            ("occupancy", occupied / self.table.capacity() as f64),
            ("stored_samples", merged.samples as f64),
            ("cells_updated", merged.cells as f64),
            ("evicted", merged.evicted as f64),
            ("blended", merged.blended as f64),
            ("dropped_samples", merged.dropped as f64),
        ]);
        if merged.dropped > 0 {
            // The same words of every frame are one note of the job.
            let note = "samples found no slot in the hash table and were dropped: capacity is too small; dropped_samples has how many";
            rendered.notes.push(note.into());
        }
    }

    /// Makes an image of camera paths that end on the cache.
    fn show(&self, shot: &Shot, rendered: &mut Rendered) {
        let counter = RayCounter::default();
        let setting = Setting {
            smoothing: Smoothing::Plain,
            filter: Filter::new(self.parameters.kernel),
            exposure: shot.scene.exposure,
        };
        let smoothed = self.parameters.smoothed;
        let mut layers = smoothed.then(|| Layers::new(shot.width, shot.height, 1));
        let mut image = Image::new(shot.width, shot.height);
        let mut mean = ImageMean::new(shot.width, shot.height);
        let mut tally = Tally::default();
        for pass in 0..self.terms.budget as u64 {
            let row = |y: usize, put: &mut dyn FnMut(usize, LayerVertex)| {
                self.row(shot, y, pass, &counter, put)
            };
            let counted: Vec<Tally> = rendered.stages.time("rendering", || match &mut layers {
                Some(layers) => layers.fill(|mut layers, y| {
                    let counted = row(y, &mut |x, vertex| layers.put(0, x, &vertex));
                    (1, counted)
                }),
                None => {
                    let rows = image.pixels.par_chunks_mut(shot.width.max(1));
                    let put = |(y, pixels): (usize, &mut [[f32; 3]])| {
                        row(y, &mut |x, vertex| pixels[x] = vertex.sent().into())
                    };
                    rows.enumerate().map(put).collect()
                }
            });
            counted.iter().for_each(|counted| tally.add(counted));
            if let Some(layers) = &mut layers {
                image = rendered.stages.time("filter", || layers.image(&setting).0);
            }
            mean.add(&image);
        }
        rendered.image = mean.image();
        rendered.rays += counter.read();
        count(&tally, rendered);
    }

    /// Follows the camera paths of a row of pixels in one pass; `put` gets columns and what the camera sees first there.
    fn row(
        &self,
        shot: &Shot,
        y: usize,
        pass: u64,
        counter: &RayCounter,
        put: &mut dyn FnMut(usize, LayerVertex),
    ) -> Tally {
        let caster = shot.tracer.caster(counter);
        let mut walk = self.walk(shot);
        let number = self.number(shot, pass);
        let stream = STREAMS[1] ^ viewer_key(shot);
        for x in 0..shot.width {
            let pixel = (y * shot.width + x) as u64;
            let mut rng = Rng::new(self.terms.seed, stream, pixel, number);
            let leg = first_leg(shot, [x, y], &mut rng);
            put(x, walk.shown(&caster, leg, &mut rng));
        }
        walk.tally
    }
}

/// Adds what following paths counted.
fn count(tally: &Tally, rendered: &mut Rendered) {
    rendered.lookups += tally.lookups;
    rendered.non_finite += tally.non_finite;
    match rendered.found.iter_mut().find(|(key, _)| *key == "misses") {
        Some((_, misses)) => *misses += tally.misses as f64,
        None => rendered.found.push(("misses", tally.misses as f64)),
    }
}
