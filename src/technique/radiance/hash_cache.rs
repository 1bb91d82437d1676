//! The contender `hash-cache`: a world-space cache of diffuse light in the cells of a linkless octree, filled along
//! camera paths, read with jitter and smoothed bounce by bounce (Roth et al. 2020).
//!
//! Of each frame, `samples` paths through each place of the caching resolution fill the cache (`fill`), then as many
//! camera samples a pixel are reconstructed from it (`reconstruct`), each smoothed on its own (`layers`, `filter`);
//! the image is their mean. All viewers fill before any of them is shown.
//!
//! *Differs:* diffuse bases under a coating are cached as well (`coatings`), their gloss is followed; lights are sampled
//! for rough gloss, so that point lights shine on it; keys are kept in the maps, so that a place without a cell is a
//! miss and never another cell's colour; maps lead to blocks of 4³ cells, which takes a sixth of the memory (`map = "cuckoo"` is
//! the paper's; what is found is the same).

use super::cells::cell_numbers;
use super::fill::{Coatings, Pass, SubPaths, samples};
use super::filter::{Filter, FilterParameters};
use super::layers::{Filled, Layers, Setting, Smoothing};
use super::reconstruct::{Holes, Read, Reading, row};
use crate::cache::hash::{
    HashCells, LevelSize, MapKind, Options, Precision, Update, foreseen_bytes,
};
use crate::entry::{About, Bias, parameters};
use crate::image::ImageMean;
use crate::scene::Scene;
use crate::technique::truth::Truth;
use crate::technique::{Contender, ContenderEntry, Film, Foreseen, Rendered, Shot, Terms};
use crate::trace::RayCounter;

/// Entry in the technique's list.
pub const ENTRY: ContenderEntry<Truth> = ContenderEntry {
    about: About {
        id: "hash-cache",
        module: crate::entry::head_comment!("hash_cache.rs"),
        aliases: &["hashcache"],
        summary: "diffuse light in the cells of an octree of hash maps, with jitter and layered filtering",
        source: "Roth, Weier, Bauszat, Hinkenjann & Li 2020",
        bias: Bias::Biased,
        version: 5,
        failures: &[
            "light that takes more than sub_path_length bounces is missing",
            "detail below the size of a cell is lost, and light leaks between surfaces that share one",
            "cells are those of the first frame: what moves is not cached where it moves to",
            "light that changes trails behind until the cache is wiped",
        ],
        parameters: Parameters::PARAMETERS,
    },
    start: |_, table, terms| {
        Ok(Box::new(HashCache {
            parameters: Parameters::read(table)?,
            terms,
            cells: None,
        }))
    },
};

parameters! {
    #[derive(Clone, Copy, Debug)]
    struct Parameters {
        /// Halvings of the cube around the scene: the finest level has 2^levels cells a side.
        levels: u32 = 10, Within(0.0, 20.0);
        /// Hash maps of the levels.
        map: MapKind = MapKind::Blocks;
        /// Numbers of a cell: 24 bytes of half floats as the paper, or 40 bytes.
        precision: Precision = Precision::Single;
        /// CRF: filling paths along a side of a pixel.
        caching_resolution: f32 = 1.0, Within(0.0, 16.0);
        /// ℓ_store: vertices of a path that are stored.
        stored_vertices: usize = 3, Within(1.0, 64.0);
        /// ℓ_len: vertices behind a stored one whose light counts.
        sub_path_length: usize = 3, Within(0.0, 64.0);
        /// What becomes of diffuse surfaces under a coating.
        coatings: Coatings = Coatings::Cached;
        /// Camera samples that a pixel is made of; without it as many as fill the cache.
        reconstruction: Option<u32> = None, Within(1.0, 65536.0);
        /// s_j: jitter of lookups in the tangent plane, in cells.
        jitter: f32 = 0.5, Within(0.0, 16.0);
        /// Side of the cells that are read, in projected pixels.
        cell_pixels: f32 = 1.0, Within(0.01, 1024.0);
        /// Samples that a cell must have to be shown.
        least_samples: u32 = 1, Within(1.0, 65535.0);
        /// What is shown where a cell has none.
        holes: Holes = Holes::Neighbours;
        /// Which layers are smoothed.
        filter: Smoothing = Smoothing::Layered;
        /// Kernel and edge-stopping of the filter.
        kernel: FilterParameters = FilterParameters::default();
        /// Frame at whose beginning the cache is wiped, because the light changes.
        wipe: Option<u32> = None, AtLeast(0.0);
    }
}

struct HashCache {
    parameters: Parameters,
    terms: Terms,
    /// Built of the first frame's scene.
    cells: Option<HashCells>,
}

impl Contender for HashCache {
    fn remembers(&self) -> bool {
        true
    }

    fn memory(&self) -> Result<Vec<u8>, String> {
        let Some(cells) = &self.cells else {
            return Ok(Vec::new());
        };
        postcard::to_allocvec(&cells.memory()).map_err(|error| error.to_string())
    }

    fn rebuild(&mut self, first: &[Shot]) -> Result<(), String> {
        self.cells = first.first().map(|shot| self.built(shot)).transpose()?;
        Ok(())
    }

    fn recall(&mut self, memory: &[u8]) -> Result<(), String> {
        if memory.is_empty() {
            return Ok(());
        }
        let memory: Vec<_> = postcard::from_bytes(memory).map_err(|error| error.to_string())?;
        match &mut self.cells {
            Some(cells) => cells.recall(&memory),
            None => Err("what was remembered lies in cells that are not built yet".into()),
        }
    }

    fn foreseen(&self, scene: &Scene, film: Film) -> Option<Foreseen> {
        let pixels = (film.width * film.height) as f64;
        let paths = pixels * f64::from(self.parameters.caching_resolution).powi(2);
        let samples = paths * self.parameters.stored_vertices as f64;
        let depth = self.sub_paths().most();
        Some(Foreseen {
            cache: foreseen_bytes(&scene.positions, &scene.triangles, self.options()),
            work: (pixels * Layers::bytes_per_pixel(depth) as f64)
                .max(samples * Update::BYTES_PER_SAMPLE as f64),
        })
    }

    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        let mut images: Vec<Rendered> = shots.iter().map(|_| Rendered::default()).collect();
        let (Some(first), Some(rendered)) = (shots.first(), images.first_mut()) else {
            return Ok(images);
        };
        let mut cells = match self.cells.take() {
            Some(cells) => cells,
            None => rendered.stages.time("cells", || self.built(first))?,
        };
        if self.parameters.wipe == Some(first.frame) {
            cells.wipe();
        }
        for (shot, rendered) in shots.iter().zip(&mut images) {
            self.fill(&mut cells, shot, rendered);
        }
        for (shot, rendered) in shots.iter().zip(&mut images) {
            self.show(&cells, shot, rendered);
            rendered.found.extend(sizes(&cells));
        }
        // What viewers share is held once.
        images[0].bytes_cache = cells.bytes();
        self.cells = Some(cells);
        Ok(images)
    }

    fn cells(&self, shot: &Shot) -> Option<Vec<f32>> {
        let cells = self.cells.as_ref()?;
        let reading = self.reading(0);
        Some(cell_numbers(shot, |seen| reading.cell(shot, cells, seen)))
    }
}

impl HashCache {
    /// The cells of a scene, without samples.
    fn built(&self, shot: &Shot) -> Result<HashCells, String> {
        let scene = shot.scene;
        HashCells::new(&scene.positions, &scene.triangles, self.options())
    }

    fn options(&self) -> Options {
        Options {
            levels: self.parameters.levels,
            map: self.parameters.map,
            precision: self.parameters.precision,
        }
    }

    fn sub_paths(&self) -> SubPaths {
        SubPaths {
            stored: self.parameters.stored_vertices,
            length: self.parameters.sub_path_length,
            coatings: self.parameters.coatings,
        }
    }

    /// Fills the cells along paths of one shot.
    fn fill(&self, cells: &mut HashCells, shot: &Shot, rendered: &mut Rendered) {
        let counter = RayCounter::default();
        let rule = self.sub_paths();
        let mut all = Update::default();
        for pass in 0..self.terms.budget as u64 {
            let pass = Pass {
                seed: self.terms.seed,
                number: u64::from(shot.frame) * self.terms.budget as u64 + pass,
                resolution_factor: self.parameters.caching_resolution,
            };
            let samples = rendered
                .stages
                .time("filling", || samples(shot, &pass, &rule, &counter));
            let update = rendered.stages.time("update", || cells.update(samples));
            all.stored += update.stored;
            all.dropped += update.dropped;
            all.non_finite += update.non_finite;
            all.cells += update.cells;
        }
        rendered.rays += counter.read();
        rendered.non_finite += all.non_finite;
        rendered.found.push(("stored_samples", all.stored as f64));
        rendered.found.push(("cells_updated", all.cells as f64));
        rendered.found.push(("dropped_samples", all.dropped as f64));
        if all.dropped > 0 {
            // The same words of every frame are one note of the job.
            let note = "samples outside of the cells of the first frame were dropped: dropped_samples has how many";
            rendered.notes.push(note.into());
        }
    }

    /// How the camera sample of this number is read.
    fn reading(&self, number: u64) -> Reading {
        let parameters = &self.parameters;
        Reading {
            sub_paths: self.sub_paths(),
            jitter: parameters.jitter,
            cell_pixels: parameters.cell_pixels,
            least_samples: parameters.least_samples,
            holes: parameters.holes,
            seed: self.terms.seed,
            number,
        }
    }

    /// Makes an image of the cells.
    fn show(&self, cells: &HashCells, shot: &Shot, rendered: &mut Rendered) {
        let parameters = &self.parameters;
        let passes = parameters
            .reconstruction
            .unwrap_or(self.terms.budget as u32);
        let setting = Setting {
            smoothing: parameters.filter,
            filter: Filter::new(parameters.kernel),
            exposure: shot.scene.exposure,
        };
        let counter = RayCounter::default();
        let mut layers = Layers::new(shot.width, shot.height, self.sub_paths().most());
        let mut mean = ImageMean::new(shot.width, shot.height);
        let (mut read, mut filled) = (Read::default(), Filled::default());
        for pass in 0..passes {
            let number = u64::from(shot.frame) * u64::from(passes) + u64::from(pass);
            let reading = self.reading(number);
            let rows = rendered.stages.time("reconstruction", || {
                layers.fill(|layers, y| {
                    let caster = shot.tracer.caster(&counter);
                    let read = row(shot, cells, &reading, &caster, layers, y);
                    (read.depth, read)
                })
            });
            rows.iter().for_each(|row| read.add(row));
            let (image, holes) = rendered.stages.time("filter", || layers.image(&setting));
            filled.holes += holes.holes;
            filled.unfilled += holes.unfilled;
            mean.add(&image);
        }
        rendered.image = mean.image();
        rendered.rays += counter.read();
        rendered.lookups += read.lookups;
        rendered.non_finite += read.non_finite;
        let share = |count: u64| count as f64 / (shot.pixels() as u64 * u64::from(passes)) as f64;
        rendered.found.extend([
            ("misses", read.misses as f64),
            ("absent_cells", read.absent as f64),
            ("holes", share(filled.holes)),
            ("unfilled_holes", share(filled.unfilled)),
            ("cut_paths", share(read.cut)),
        ]);
    }
}

/// The cells of the finest level and of all, with their bytes.
fn sizes(cells: &HashCells) -> Vec<(&'static str, f64)> {
    let levels: Vec<LevelSize> = cells.levels().collect();
    let sum = |bytes: fn(&LevelSize) -> f64| levels.iter().map(bytes).sum::<f64>();
    let mut sizes = vec![
        ("cells", sum(|l| l.cells as f64)),
        ("data_bytes", sum(|l| l.bytes_data as f64)),
        ("map_bytes", sum(|l| l.bytes_map as f64)),
        ("keyless_map_bytes", sum(|l| l.bytes_map_paper)),
    ];
    if let Some(finest) = levels.last() {
        sizes.extend([
            ("finest_density", finest.density),
            ("finest_data_bytes", finest.bytes_data as f64),
            ("finest_map_bytes", finest.bytes_map as f64),
            ("finest_keyless_map_bytes", finest.bytes_map_paper),
            ("map_rebuilds", sum(|l| f64::from(l.rebuilds))),
        ]);
    }
    sizes
}
