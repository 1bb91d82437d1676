//! The classic irradiance cache: records made where none may be used (Ward et al. 1988), with
//! gradients (Ward & Heckbert 1992), limited by gradients and neighbours (Křivánek et al. 2006), in an
//! overture from coarse to fine pixels.
//!
//! The allowed error is searched so that the number of records is the budget's; a record depends on its
//! pixel alone, so that the search evaluates none twice.

mod record;
mod store;
#[cfg(test)]
mod tests;

use std::collections::HashMap;

use glam::Vec3;
use rayon::prelude::*;

use self::record::{Evaluator, Record, Strata};
use self::store::{Metric, Placed, Store};
use super::{IrradianceCaching, reflected};
use crate::cache::{
    DistanceMetric, NO_POINT, Neighbour, RecordSearch, SearchRule, ShadingPoints,
    inverse_distance_weights,
};
use crate::entry::{About, Bias, ParameterError, parameters};
use crate::image::Image;
use crate::memory::released;
use crate::technique::paths::indirect;
use crate::technique::{
    Clock, Contender, ContenderEntry, PlacedRecord, Rendered, Search, Shot, Site, Stages, Terms,
    shading_points,
};
use crate::trace::{RayCounter, RayCounts};

/// The registry's entry.
pub(super) const ENTRY: ContenderEntry<IrradianceCaching> = ContenderEntry {
    about: About {
        id: "on-demand",
        module: crate::entry::head_comment!("mod.rs"),
        aliases: &["ward", "irradiance-cache"],
        summary: "the classic irradiance cache: records with gradients, made where none may be used",
        source: "Ward et al. 1988; Ward & Heckbert 1992; Tabellion & Lamorlette 2004; Křivánek et \
                 al. 2006 (neighbour clamping). The allowed error is searched for the budget",
        bias: Bias::Biased,
        version: 3,
        failures: &[
            "a narrow gap that few rays find leaves records that are valid too far",
            "gradients of a noisy hemisphere overshoot: HDR outliers print blotches",
            "normals and positions do not tell the two sides of a thin wall at its edge apart",
        ],
        parameters: OnDemand::PARAMETERS,
    },
    start: |technique, table, terms| {
        Ok(Box::new(Job {
            technique,
            method: OnDemand::read(table)?,
            terms,
        }))
    },
};

parameters! {
    /// Parameters of the method.
    #[derive(Clone, Copy, Debug)]
    pub struct OnDemand {
        /// How far a record may be used.
        metric: Metric = Metric::Ward;
        /// Whether records are extrapolated by their gradients.
        gradients: bool = true;
        /// Least and largest validity distance, in projected pixels at the record.
        pixels: [f32; 2] = [3.0, 60.0], AtLeast(0.0), "pixels";
    }
    check OnDemand::check;
}

impl OnDemand {
    fn check(&self) -> Result<(), ParameterError> {
        let [least, largest] = self.pixels;
        match least > largest {
            false => Ok(()),
            true => Err(ParameterError::new(
                "pixels",
                format!("pixels = [{least}, {largest}]: expected the least distance first"),
            )),
        }
    }
}

/// Steps of the search for the allowed error.
const SEARCH_STEPS: usize = 12;
/// Range of the allowed error that is searched.
const ERRORS: [f32; 2] = [0.02, 4.0];
/// Distances in pixels at which the overture looks for missing records, one pass each.
const STRIDES: [usize; 4] = [8, 4, 2, 1];

/// The contender.
struct Job<'a> {
    technique: &'a IrradianceCaching,
    method: OnDemand,
    terms: Terms,
}

impl Contender for Job<'_> {
    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        Ok(shots.iter().map(|shot| self.render(shot)).collect())
    }
}

impl Job<'_> {
    /// Searches the allowed error, then makes the records of that error anew: only these are charged.
    fn render(&self, shot: &Shot) -> Rendered {
        let counter = RayCounter::default();
        let mut rendered = Rendered::default();
        let mut stages = Stages::default();
        let points = stages.time("shading_points", || shading_points(shot, &counter));
        let overture = || Overture {
            shot,
            points: &points,
            method: &self.method,
            evaluator: Evaluator {
                shot,
                strata: Strata::of(self.technique.directions.len()),
                depths: indirect(shot),
                seed: self.terms.seed,
            },
            known: HashMap::new(),
        };
        let clock = Clock::start();
        let mut searching = overture();
        let error = searching.search(self.terms.budget);
        let mut spent = RayCounts::default();
        searching
            .known
            .values()
            .for_each(|known| spent += known.rays);
        rendered.search = Search {
            seconds: clock.seconds(),
            rays: spent,
        };
        let tried = searching.known.len();
        drop(searching);
        let mut overture = overture();
        let store = stages.time("records", || overture.first(error, self.terms.budget));
        let image = stages.time("rendering", || overture.image(&store, &counter));
        let placed = || store.placed.iter();
        rendered.records = placed().map(|p| overture.placed(p)).collect();
        rendered.rays = counter.read();
        overture
            .known
            .values()
            .for_each(|known| rendered.rays += known.rays);
        rendered.non_finite = image.non_finite + placed().map(|p| p.record.non_finite).sum::<u64>();
        rendered.lookups = image.lookups;
        rendered.found = vec![
            ("allowed_error", f64::from(error)),
            ("misses", image.misses as f64),
            ("evaluated", tried as f64),
        ];
        rendered.notes.push(format!(
            "allowed error searched in {SEARCH_STEPS} steps; the search is not charged"
        ));
        if store.placed.len() < self.terms.budget {
            rendered.notes.push(format!(
                "{} records instead of {}: no allowed error gives just as many",
                store.placed.len(),
                self.terms.budget
            ));
        }
        rendered.bytes_cache = image.bytes_search + released(store);
        rendered.image = image.image;
        rendered.stages = stages;
        rendered
    }
}

/// A record with what it cost.
struct Known {
    record: Record,
    rays: RayCounts,
}

struct Overture<'a> {
    shot: &'a Shot<'a>,
    points: &'a ShadingPoints,
    method: &'a OnDemand,
    evaluator: Evaluator<'a>,
    /// Records evaluated so far, by shading point.
    known: HashMap<u32, Known>,
}

/// An image made from records.
struct Interpolated {
    image: Image,
    lookups: u64,
    misses: u64,
    non_finite: u64,
    /// Held to find the nearest records by.
    bytes_search: usize,
}

impl Overture<'_> {
    /// The least allowed error that asks for at most `count` records; the largest that is searched if none does.
    fn search(&mut self, count: usize) -> f32 {
        let [mut low, mut high] = ERRORS;
        for _ in 0..SEARCH_STEPS {
            let middle = (low * high).sqrt();
            if self.fill(middle, count).placed.len() > count {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    /// The records that an allowed error asks for, at most the `count` first of them.
    fn first(&mut self, error: f32, count: usize) -> Store {
        let mut store = self.fill(error, count);
        if store.placed.len() > count {
            let all = std::mem::replace(&mut store, Store::new(self.method.metric, error));
            for placed in &all.placed[count..] {
                self.known.remove(&placed.point);
            }
            all.placed[..count].iter().for_each(|p| store.insert(*p));
        }
        store
    }

    /// All passes of the overture at one allowed error; stops when there are more than `most`
    /// records.
    fn fill(&mut self, error: f32, most: usize) -> Store {
        let mut store = Store::new(self.method.metric, error);
        for (pass, stride) in STRIDES.into_iter().enumerate() {
            let coarser = (pass > 0).then(|| STRIDES[pass - 1]);
            for pixel in 0..self.points.point_of_pixel.len() {
                let (x, y) = (pixel % self.points.width, pixel / self.points.width);
                let on = |stride: usize| x % stride == stride / 2 && y % stride == stride / 2;
                let point = self.points.point_of_pixel[pixel];
                if point == NO_POINT || !on(stride) || coarser.is_some_and(on) {
                    continue;
                }
                let site = Site::of(self.points, point);
                if store.covers(&site) {
                    continue;
                }
                let placed = self.place(point, &site);
                store.insert(placed);
                if store.placed.len() > most {
                    return store;
                }
            }
        }
        store
    }

    /// The record at a shading point with its validity distance.
    fn place(&mut self, point: u32, site: &Site) -> Placed {
        let evaluator = &self.evaluator;
        let pixel = self.points.pixel[point as usize];
        let known = self.known.entry(point).or_insert_with(|| {
            let counter = RayCounter::default();
            let record = evaluator.evaluate(site, pixel, &counter);
            Known {
                record,
                rays: counter.read(),
            }
        });
        let mut record = known.record;
        if !self.method.gradients {
            record.rotation = glam::Mat3::ZERO;
            record.translation = glam::Mat3::ZERO;
        }
        let (width, height) = (self.points.width, self.points.height);
        let [_, half] = self.shot.view.half_tangents(width, height);
        let depth = self.points.depth[point as usize];
        let size = (2.0 * half / height as f64) as f32 * depth;
        let limits = self.method.pixels.map(|pixels| pixels * size);
        let valid = record.validity(self.method.metric);
        if valid < limits[0] {
            // Where the radius is not allowed to follow a steep gradient, the gradient is cut.
            record.translation *= valid / limits[0];
        }
        Placed {
            radius: valid.clamp(limits[0], limits[1]),
            record,
            limits,
            point,
        }
    }

    fn placed(&self, placed: &Placed) -> PlacedRecord {
        PlacedRecord {
            site: placed.record.site,
            pixel: self.points.pixel[placed.point as usize],
            stage: 0,
        }
    }

    /// Every camera sample from the records; where none may be used, the M nearest of the run-time
    /// rule serve without gradients, and are counted as misses.
    fn image(&self, store: &Store, counter: &RayCounter) -> Interpolated {
        let shot = self.shot;
        let sites = || store.placed.iter().map(|p| &p.record.site);
        let positions: Vec<Vec3> = sites().map(|s| s.position).collect();
        let normals: Vec<Vec3> = sites().map(|s| s.normal).collect();
        let metric = DistanceMetric::literal(shot.scene.diagonal, self.points.metres_per_unit);
        let nearest = RecordSearch::new(&positions, &normals, SearchRule::paper(metric));
        let fallback = |site: &Site| -> Vec3 {
            let found = nearest.map(&[site.position], &[site.normal], |_, n| n.to_vec());
            let found = found.into_iter().next().unwrap_or_default();
            let mut weights = vec![0.0; found.len()];
            inverse_distance_weights(&found, shot.scene.diagonal, 1, &mut weights);
            let value =
                |(n, w): (&Neighbour, &f32)| store.placed[n.record as usize].record.irradiance * *w;
            found.iter().zip(&weights).map(value).sum()
        };
        let mut image = Image::new(shot.width, shot.height);
        let shade_row = |(y, row): (usize, &mut [[f32; 3]])| {
            let caster = shot.tracer.caster(counter);
            let (mut lookups, mut misses, mut non_finite) = (0u64, 0u64, 0u64);
            for (x, pixel) in row.iter_mut().enumerate() {
                let mut sum = Vec3::ZERO;
                for sample in 0..shot.spp {
                    let index = (y * shot.width + x) as u32;
                    let Some(seen) = shot.look(&caster, index, sample) else {
                        continue;
                    };
                    lookups += 1;
                    let irradiance = store.interpolate(&seen.site).unwrap_or_else(|| {
                        misses += 1;
                        fallback(&seen.site)
                    });
                    let value = reflected(shot, &seen, irradiance);
                    if value.is_finite() {
                        sum += value;
                    } else {
                        non_finite += 1;
                    }
                }
                *pixel = (sum / shot.spp as f32).into();
            }
            [lookups, misses, non_finite]
        };
        let rows: Vec<[u64; 3]> = image
            .pixels
            .par_chunks_mut(shot.width)
            .enumerate()
            .map(shade_row)
            .collect();
        let total = |i: usize| rows.iter().map(|r| r[i]).sum();
        Interpolated {
            image,
            lookups: total(0),
            misses: total(1),
            non_finite: total(2),
            bytes_search: released(nearest),
        }
    }
}
