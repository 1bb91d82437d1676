//! The records: ambient occlusion, visibility as bits, and how the value changes around them.

use glam::Vec3;
use rayon::prelude::*;

use super::gather::{Change, Gatherer, Scratch};
use crate::cache::{Extrapolation, Gradient, Weighted};
use crate::sample::HemisphereEdges;
use crate::technique::{CachedFunction, Seen, Shot, Site};
use crate::trace::{Caster, RayCounter};

/// Records that one task evaluates.
const GRAIN: usize = 16;

/// The records of one job.
pub struct VisibilityRecords<'a> {
    shot: &'a Shot<'a>,
    gatherer: Gatherer<'a>,
    /// 64-bit words per record.
    words: usize,
    values: Vec<f32>,
    occluded: Vec<u64>,
    /// For gradient interpolation only.
    gradient: Option<Extrapolation<Change>>,
}

/// Largest change of the value by the position.
const LARGEST_CHANGE: f32 = 0.1;

impl<'a> VisibilityRecords<'a> {
    /// No records yet; with a `gradient` they will know how the value changes.
    pub fn new(shot: &'a Shot<'a>, gatherer: Gatherer<'a>, gradient: Option<Gradient>) -> Self {
        let side = gatherer.directions.len().isqrt();
        Self {
            shot,
            words: gatherer.directions.len().div_ceil(64),
            gatherer,
            values: Vec::new(),
            occluded: Vec::new(),
            gradient: gradient.map(|rule| Extrapolation::new(rule, HemisphereEdges::new(side))),
        }
    }

    /// What a record says of a site, 0 to 1, and how far it is to be believed beside others.
    fn value(&self, record: u32, of: &Site) -> (f32, f32) {
        let extrapolated = self.gradient.as_ref().and_then(|gradient| {
            let (step, change) = gradient.around(record, of.position, of.normal)?;
            let most = gradient.rule.clamp.unwrap_or(LARGEST_CHANGE);
            let moved = change.gradient.dot(step).clamp(-most, most);
            let value = (change.bent.dot(of.normal) + moved).clamp(0.0, 1.0);
            Some((value, change.trust))
        });
        extrapolated.unwrap_or((self.values[record as usize], 1.0))
    }
}

impl CachedFunction for VisibilityRecords<'_> {
    fn evaluate(&mut self, sites: &[Seen], counter: &RayCounter) {
        let first = self.values.len();
        let bits = (first + sites.len()) * self.words;
        // Room for these and no more: rounds are few, and what is kept is charged.
        self.occluded.reserve_exact(bits - self.occluded.len());
        self.occluded.resize(bits, 0);
        let (shot, gatherer) = (self.shot, &self.gatherer);
        let edges = self.gradient.as_ref().map(|gradient| &gradient.edges);
        let start = || {
            let scratch = Scratch::new(gatherer.directions.len());
            (shot.tracer.caster(counter), scratch)
        };
        let made: Vec<(f32, Change)> = self.occluded[first * self.words..]
            .par_chunks_mut(self.words)
            .zip(sites)
            .with_min_len(GRAIN)
            .map_init(start, |(caster, scratch), (occluded, record)| {
                let made = match edges {
                    None => (
                        gatherer.gather(caster, &record.site, scratch),
                        Change::default(),
                    ),
                    Some(edges) => gatherer.gather_change(caster, &record.site, edges, scratch),
                };
                occluded.copy_from_slice(&scratch.occluded);
                made
            })
            .collect();
        self.values.extend(made.iter().map(|(value, _)| value));
        if let Some(gradient) = &mut self.gradient {
            gradient.make_room(sites.len());
            for (Seen { site, .. }, (_, change)) in sites.iter().zip(made) {
                gradient.add(site.position, site.normal, change);
            }
        }
    }

    fn difference(&self, a: u32, b: u32) -> f32 {
        let bits = |i: u32| &self.occluded[i as usize * self.words..][..self.words];
        let differing: u32 = bits(a)
            .iter()
            .zip(bits(b))
            .map(|(x, y)| (x ^ y).count_ones())
            .sum();
        differing as f32
    }

    fn predict(&self, record: u32, of: &Site) -> (Vec3, f32) {
        let (value, trust) = self.value(record, of);
        (Vec3::splat(value), trust)
    }

    fn length(&self) -> f32 {
        self.gatherer.distance
    }

    fn shade(&self, _: &Caster, seen: &Seen, near: Weighted) -> Option<[f32; 3]> {
        if near.neighbours.is_empty() {
            return None;
        }
        let (mut sum, mut total) = (0.0, 0.0);
        for (record, weight) in near.iter() {
            let (value, trust) = self.value(record, &seen.site);
            sum += value * weight * trust;
            total += weight * trust;
        }
        Some([sum / total; 3])
    }

    fn background(&self) -> [f32; 3] {
        [1.0; 3]
    }
}
