//! AS: adaptive sampling between records that differ, after Yoshida et al.
//!
//! Each record is compared with its nearest records; pairs whose gathering samples differ most get a record
//! at the shading point nearest to their middle, until the budget is spent.

use glam::Vec3;
use rayon::prelude::*;

use super::members::usable;
use super::pick::{STREAM_FILL, keep_random};
use super::{Placement, Refinable, Refinement};
use crate::cache::interpolation::inverse_distance;
use crate::cache::{RecordSearch, SearchRule};
use crate::entry::{About, Bias, parameters};
use crate::placement::RefinementEntry;
use crate::sample::Rng;

/// Pairs whose normals differ more have no useful midpoint.
const PAIR_ANGLE_DEG: f32 = 60.0;
/// New records keep this share of the scene's diagonal away from the two they are put between.
const LEAST_DISTANCE: f32 = 1e-4;

parameters! {
    /// Puts new records between neighbouring records that differ most.
    #[derive(Clone, Copy, Debug)]
    pub struct Adaptive {
        /// R: share of the records kept back for this stage.
        pub ratio: f64 = 0.15, Within(0.0, 0.9);
        /// K: neighbours each record is compared with.
        pub records: usize = 6, Within(1.0, 32.0);
        /// Only records whose differences to their K neighbours sum to more propose new ones; without it
        /// all do, and the budget decides.
        pub threshold: Option<f64> = None, AtLeast(0.0), "summed difference";
    }
}

/// Registry entry.
pub const ENTRY: RefinementEntry = RefinementEntry {
    about: About {
        id: "AS",
        module: crate::entry::head_comment!("adaptive.rs"),
        aliases: &["ac", "as-r", "adaptive"],
        summary: "records between neighbouring records that differ most",
        source: "reconstruction of Yoshida et al. 2015 from its abstract and Wu & Shen 2023, \
                 section 3.2",
        bias: Bias::Consistent,
        version: 1,
        failures: &[
            "Refines per record, not per pixel: discontinuities that no record sees stay unseen.",
            "Threshold mode depends on the application and the scene, and may leave budget unspent.",
            "A reconstruction: the original's error estimate is not known.",
        ],
        parameters: Adaptive::PARAMETERS,
    },
    build: |table| Ok(Box::new(Adaptive::read(table)?)),
    interpolation: &inverse_distance::ENTRY,
};

/// Two records that differ, lower index first.
#[derive(Clone, Copy, Debug)]
struct Pair {
    records: (u32, u32),
    difference: f32,
}

impl Refinement for Adaptive {
    fn ratio(&self) -> f64 {
        self.ratio
    }

    /// In budget mode proposals are taken by descending difference and missing records are drawn
    /// uniformly; in threshold mode the budget is a limit.
    ///
    /// *differs:* the point for a proposal is the best of the 20 spatially nearest to its target,
    /// not of all.
    fn refine(&self, input: &mut Refinable, count: usize, seed: u64) -> Placement {
        let pairs = self.pairs(input);
        let mut taken = vec![false; input.points.len()];
        for &site in input.sites {
            taken[site as usize] = true;
        }
        let (mut sites, last) = propose(input, &pairs, &mut taken, count);
        let proposed = sites.len();
        let mut notes = Vec::new();
        if proposed < count && self.threshold.is_some() {
            notes.push(format!(
                "the threshold leaves {} of {count} records unspent",
                count - proposed
            ));
        } else if proposed < count {
            let usable = usable(input.points).into_par_iter();
            let mut free: Vec<u32> = usable.filter(|&i| !taken[i as usize]).collect();
            let mut rng = Rng::new(seed, STREAM_FILL, 2, 0);
            keep_random(&mut free, count - proposed, &mut rng);
            sites.extend(free);
            notes.push(format!(
                "only {proposed} distinct proposals; the other {} records are uniformly random",
                sites.len() - proposed
            ));
        }
        Placement {
            sites,
            found: vec![
                ("proposals", pairs.len() as f64),
                ("least_difference", f64::from(last)),
            ],
            notes,
            map: None,
        }
    }
}

impl Adaptive {
    /// All distinct pairs of neighbouring records that may propose, by descending difference.
    fn pairs(&self, input: &Refinable) -> Vec<Pair> {
        let near = self.neighbours(input);
        let difference = |&(a, b): &(u32, u32)| Pair {
            records: (a, b),
            difference: input.records.difference(a, b),
        };
        let ordered = |i: u32, k: u32| (i.min(k), i.max(k));
        let mut all: Vec<(u32, u32)> = near
            .par_iter()
            .enumerate()
            .flat_map_iter(|(i, near)| near.iter().map(move |&k| ordered(i as u32, k)))
            .collect();
        all.par_sort_unstable();
        all.dedup();
        let mut pairs: Vec<Pair> = all.par_iter().map(difference).collect();
        if let Some(threshold) = self.threshold {
            let of = |i: u32, k: u32| {
                let found = all.binary_search(&ordered(i, k));
                found.map_or(0.0, |at| f64::from(pairs[at].difference))
            };
            let sum = |(i, near): (usize, &Vec<u32>)| near.iter().map(|&k| of(i as u32, k)).sum();
            let sums: Vec<f64> = near.par_iter().enumerate().map(sum).collect();
            let above = |i: u32| sums[i as usize] > threshold;
            pairs.retain(|p| above(p.records.0) || above(p.records.1));
        }
        pairs.retain(|p| p.difference > 0.0);
        pairs.par_sort_unstable_by(|a, b| {
            let order = b.difference.total_cmp(&a.difference);
            order.then(a.records.cmp(&b.records))
        });
        pairs
    }

    /// The K nearest other records of each record within the pair angle.
    fn neighbours(&self, input: &Refinable) -> Vec<Vec<u32>> {
        let rule = SearchRule {
            candidates: (input.search.rule().candidates + 1).max(self.records + 1),
            used: self.records + 1,
            max_angle_deg: PAIR_ANGLE_DEG,
            metric: input.search.rule().metric,
        };
        let (p, n) = input.placed();
        let search = RecordSearch::new(&p, &n, rule);
        search.map(&p, &n, |i, found| {
            let others = found.iter().map(|f| f.record).filter(|&k| k as usize != i);
            others.take(self.records).collect()
        })
    }
}

/// Takes up to `count` shading points nearest to the midpoints of `pairs`, in their order. Returns
/// the difference of the last pair that was used, too.
fn propose(input: &Refinable, pairs: &[Pair], taken: &mut [bool], count: usize) -> (Vec<u32>, f32) {
    let points = input.points;
    let (mut sites, mut last) = (Vec::new(), 0.0);
    if pairs.is_empty() || count == 0 {
        return (sites, last);
    }
    let rule = SearchRule {
        candidates: 20,
        used: 1,
        max_angle_deg: 180.0,
        metric: input.search.rule().metric,
    };
    let search = RecordSearch::new(&points.position, &points.normal, rule);
    let apart = points.diagonal * LEAST_DISTANCE;
    // Most proposals are accepted: targets are answered in batches as long as records are missing.
    for batch in pairs.chunks((2 * count).max(1024)) {
        let ends = |pair: &Pair| {
            let (a, b) = pair.records;
            [a, b].map(|r| input.sites[r as usize] as usize)
        };
        let (p, n): (Vec<Vec3>, Vec<Vec3>) = batch
            .par_iter()
            .map(|pair| {
                let [a, b] = ends(pair);
                let middle = 0.5 * (points.position[a] + points.position[b]);
                (
                    middle,
                    (points.normal[a] + points.normal[b]).normalize_or_zero(),
                )
            })
            .unzip();
        let nearest = search.map(&p, &n, |_, found| found.first().map(|f| f.record));
        // All threads sort out what cannot be a record; the rest is chosen one after another.
        let fits = |(pair, site): (&Pair, &Option<u32>)| {
            let site = (*site)? as usize;
            let crowds = |end: usize| points.position[end].distance(points.position[site]) < apart;
            let fits = !taken[site] && !ends(pair).into_iter().any(crowds);
            fits.then_some((site, pair.difference))
        };
        let proposed = batch.par_iter().zip(&nearest).filter_map(fits);
        for (site, difference) in proposed.collect::<Vec<_>>() {
            if sites.len() == count {
                return (sites, last);
            }
            if !taken[site] {
                taken[site] = true;
                sites.push(site as u32);
                last = difference;
            }
        }
    }
    (sites, last)
}
