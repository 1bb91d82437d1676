//! The run-time rule (Wu & Shen, section 3.3): N nearest records, normal filter, M by distance.

use glam::Vec3;
use rayon::prelude::*;

use super::metric::{DistanceMetric, Ranking};
use super::tile::{Query, Tile};
use super::tree::{Box3, RecordTree};

/// Consecutive queries that one task sorts into tiles.
const CHUNK: usize = 1 << 14;
/// Most queries of a tile.
const TILE: usize = 64;

/// Parameters of the rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchRule {
    /// Spatially nearest records that are candidates (N).
    pub candidates: usize,
    /// Records that are used (M).
    pub used: usize,
    /// Largest angle between normals, degrees (θ_max); from 180 on there is no filter.
    pub max_angle_deg: f32,
    /// What the candidates are ranked by.
    pub metric: Ranking,
}

impl SearchRule {
    /// The paper's N = 20, M = 6 and θ_max = 30° with the given metric.
    pub fn paper(metric: DistanceMetric) -> Self {
        Self {
            candidates: 20,
            used: 6,
            max_angle_deg: 30.0,
            metric: Ranking::Combined(metric),
        }
    }

    /// The `count` spatially nearest records, whatever their normals.
    pub fn spatial(count: usize) -> Self {
        Self {
            candidates: count,
            used: count,
            max_angle_deg: 180.0,
            metric: Ranking::Combined(DistanceMetric { lambda: 0.0 }),
        }
    }
}

/// A record chosen for a query.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Neighbour {
    /// Index among the records searched.
    pub record: u32,
    /// Combined distance, scene units.
    pub distance: f32,
}

/// Answers the rule for many queries.
///
/// Of the N nearest records (all if there are fewer; ties by record index) those within θ_max of
/// the query's normal stay; if none does, all N stay. The M with the least combined distance
/// (ties by record index) are the answer. Results equal a brute-force search bit for bit.
/// Records with a position or normal that is not finite are never found; queries with one have no
/// neighbours.
pub struct RecordSearch {
    pub(super) tree: RecordTree,
    pub(super) least_cosine: f32,
    rule: SearchRule,
}

impl RecordSearch {
    /// Builds the search over records at `positions` with unit `normals`.
    pub fn new(positions: &[Vec3], normals: &[Vec3], rule: SearchRule) -> Self {
        let radians = f64::from(rule.max_angle_deg.max(0.0)).to_radians();
        Self {
            tree: RecordTree::new(positions, normals),
            least_cosine: if rule.max_angle_deg < 180.0 {
                radians.cos() as f32
            } else {
                f32::NEG_INFINITY
            },
            rule,
        }
    }

    /// The rule that queries are answered by.
    pub fn rule(&self) -> &SearchRule {
        &self.rule
    }

    /// `value(query, neighbours)` of each query, in the order of the queries. There are at most M
    /// neighbours, in ascending distance (ties by record index); none if there are no records or
    /// the query is not finite.
    ///
    /// Runs of 16,384 queries are sorted in space and answered tile by tile, so it is fast if runs
    /// of the input lie close together, as pixels of an image do. `value` is called from several
    /// threads, in no fixed order.
    pub fn map<T: Send + Clone + Default>(
        &self,
        positions: &[Vec3],
        normals: &[Vec3],
        value: impl Fn(usize, &[Neighbour]) -> T + Sync,
    ) -> Vec<T> {
        let value = |(): &mut (), query: usize, found: &[Neighbour]| value(query, found);
        self.map_with(positions, normals, || (), value)
    }

    /// As [`RecordSearch::map`], with something made once for each task and handed to `value`.
    pub fn map_with<T: Send + Clone + Default, S>(
        &self,
        positions: &[Vec3],
        normals: &[Vec3],
        make: impl Fn() -> S + Sync + Send,
        value: impl Fn(&mut S, usize, &[Neighbour]) -> T + Sync,
    ) -> Vec<T> {
        let mut values = vec![T::default(); positions.len().min(normals.len())];
        values.par_chunks_mut(CHUNK).enumerate().for_each_init(
            || (SearchSpace::default(), make()),
            |(space, own), (chunk, out)| {
                let first = chunk * CHUNK;
                let range = first..first + out.len();
                let (p, n) = (&positions[range.clone()], &normals[range]);
                self.answer_run(space, p, n, |i, found| {
                    out[i] = value(own, first + i, found);
                });
            },
        );
        values
    }

    /// The records of each query in ascending order of record, `stride` numbers for each, filled up
    /// with `u32::MAX`. `records` must hold `stride` numbers for each query; surplus neighbours,
    /// those farthest away, are left out.
    pub fn fill_records(
        &self,
        positions: &[Vec3],
        normals: &[Vec3],
        records: &mut [u32],
        stride: usize,
    ) {
        records
            .par_chunks_mut((CHUNK * stride).max(1))
            .enumerate()
            .for_each_init(SearchSpace::default, |space, (chunk, out)| {
                let first = chunk * CHUNK;
                let range = first..first + out.len() / stride.max(1);
                let (p, n) = (&positions[range.clone()], &normals[range]);
                self.answer_run(space, p, n, |i, found| {
                    let own = &mut out[i * stride..(i + 1) * stride];
                    own.fill(u32::MAX);
                    for (record, neighbour) in own.iter_mut().zip(found) {
                        *record = neighbour.record;
                    }
                    own.sort_unstable();
                });
            });
    }

    /// Answers up to 65,536 queries on this thread: `answer` is given each query's index and its neighbours, in no
    /// fixed order. Fast if the queries lie close together.
    pub fn answer_run(
        &self,
        space: &mut SearchSpace,
        positions: &[Vec3],
        normals: &[Vec3],
        mut answer: impl FnMut(usize, &[Neighbour]),
    ) {
        space.sort(positions, normals);
        if self.tree.len() == 0 || self.rule.candidates == 0 || self.rule.used == 0 {
            (0..positions.len()).for_each(|i| answer(i, &[]));
            return;
        }
        for &i in &space.unusable {
            answer(i as usize, &[]);
        }
        for queries in space.queries.chunks(TILE) {
            space
                .tile
                .answer(self, queries, &mut |i, found| answer(i as usize, found));
        }
    }
}

/// Scratch space of one thread that asks for neighbours.
#[derive(Default)]
pub struct SearchSpace {
    keys: Vec<u64>,
    queries: Vec<Query>,
    unusable: Vec<u32>,
    tile: Tile,
}

impl SearchSpace {
    /// Sorts the finite queries along a space-filling curve and sets the others apart.
    fn sort(&mut self, positions: &[Vec3], normals: &[Vec3]) {
        let usable = |i: &usize| positions[*i].is_finite() && normals[*i].is_finite();
        let all = 0..positions.len();
        self.unusable.clear();
        self.unusable
            .extend(all.clone().filter(|i| !usable(i)).map(|i| i as u32));
        let bounds = Box3::around(all.clone().filter(usable).map(|i| positions[i].into()));
        let extent = (bounds.max - bounds.min).max_element();
        let scale = if extent > 0.0 { 65535.0 / extent } else { 0.0 };
        self.keys.clear();
        self.keys.extend(all.filter(usable).map(|i| {
            let cell = (Vec3::from(bounds.min) - positions[i]) * -scale;
            let code = spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2;
            code << 16 | i as u64
        }));
        self.keys.sort_unstable();
        self.queries.clear();
        self.queries.extend(self.keys.iter().map(|key| {
            let index = (key & 0xffff) as u32;
            Query {
                position: positions[index as usize].into(),
                normal: normals[index as usize].into(),
                index,
            }
        }));
    }
}

/// The 16 bits of a coordinate with two zeros between neighbours.
fn spread(coordinate: f32) -> u64 {
    let mut x = u64::from(coordinate as u16);
    x = (x | x << 16) & 0xff00_00ff;
    x = (x | x << 8) & 0x00f0_0f00_f00f;
    x = (x | x << 4) & 0x0c30_c30c_30c3;
    (x | x << 2) & 0x2492_4924_9249
}

#[cfg(test)]
#[path = "search_tests.rs"]
mod tests;
