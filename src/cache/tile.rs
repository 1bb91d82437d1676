//! Answers a tile of neighbouring queries from one shared list of candidates.

use glam::Vec3A;
use macro_rules_attribute::apply;

use super::metric::Ranking;
use super::search::{Neighbour, RecordSearch};
use super::tree::{Box3, squared_distance};
use crate::instructions::compiled_for_avx2;

/// Candidates are examined in groups of this many.
const LANES: usize = 8;
/// Covers the rounding of a few f32 operations in bounds made by the triangle inequality.
const SLACK: f32 = 1.0 + 1e-5;

/// A tile is split if its radius is more than this share of the distance to the N-th record.
const WIDEST: f32 = 0.6;

/// A query with its index in the caller's order.
#[derive(Clone, Copy)]
pub(super) struct Query {
    pub position: Vec3A,
    pub normal: Vec3A,
    pub index: u32,
}

/// Eight records in structure of arrays; the last group is filled up with records that fail any filter.
#[derive(Clone, Copy)]
struct Group {
    x: [f32; LANES],
    y: [f32; LANES],
    z: [f32; LANES],
    nx: [f32; LANES],
    ny: [f32; LANES],
    nz: [f32; LANES],
    record: [u32; LANES],
    /// Least distance of the group's records from the tile's centre, rounded down.
    from_centre: f32,
}

const EMPTY_GROUP: Group = Group {
    x: [f32::INFINITY; LANES],
    y: [f32::INFINITY; LANES],
    z: [f32::INFINITY; LANES],
    nx: [f32::NAN; LANES],
    ny: [f32::NAN; LANES],
    nz: [f32::NAN; LANES],
    record: [u32::MAX; LANES],
    from_centre: 0.0,
};

/// Scratch space of one worker.
#[derive(Default)]
pub(super) struct Tile {
    /// The candidates of the tile, by distance from its centre.
    groups: Vec<Group>,
    order: Vec<u64>,
    /// Squared distances of the query at hand, for the groups that were examined.
    squared: Vec<[f32; LANES]>,
    chosen: Chosen,
    nearest: Vec<f32>,
    ranked: Vec<(u32, u32, u32)>,
    centre: Vec3A,
    /// The centre of the previous tile and its distance to the N-th record.
    previous: Option<(Vec3A, f32)>,
}

impl Tile {
    /// Answers all `queries`, which are split until they are close together compared with the
    /// spacing of the records. `answer` gets the query's index and its neighbours.
    pub fn answer(
        &mut self,
        search: &RecordSearch,
        queries: &[Query],
        answer: &mut impl FnMut(u32, &[Neighbour]),
    ) {
        let region = Box3::around(queries.iter().map(|q| q.position));
        self.centre = 0.5 * region.min + 0.5 * region.max;
        let radius = queries
            .iter()
            .map(|q| squared_distance(q.position, self.centre))
            .fold(0.0, f32::max)
            .sqrt();
        let bound = self.bound_reach(search, radius);
        let wide = |reach: f32| queries.len() > 1 && radius > WIDEST * reach;
        if wide(bound) || wide(self.gather(search, bound, radius)) {
            let (first, second) = queries.split_at(queries.len() / 2);
            self.answer(search, first, answer);
            self.answer(search, second, answer);
            return;
        }
        for query in queries {
            self.choose(search, query);
            answer(query.index, &self.chosen.neighbours);
        }
    }

    /// An upper bound of the distance from the centre to its N-th nearest record: from the tile
    /// before if that is near, by a search of its own otherwise.
    fn bound_reach(&mut self, search: &RecordSearch, radius: f32) -> f32 {
        let mut bound = f32::INFINITY;
        if let Some((centre, reach)) = self.previous {
            let step = squared_distance(centre, self.centre).sqrt();
            bound = (reach + step) * SLACK;
            if step < reach || radius > WIDEST * bound {
                return bound;
            }
        }
        let squared = (bound * bound).max(f32::MIN_POSITIVE);
        let count = search.rule().candidates;
        let tree = &search.tree;
        let squared = tree.nth_squared(self.centre, count, squared, &mut self.nearest);
        let reach = squared.sqrt() * SLACK;
        self.previous = Some((self.centre, reach));
        reach
    }

    /// Collects all records that may be among the N nearest of a query, those near the centre
    /// first, and returns the distance from the centre to its N-th nearest record.
    ///
    /// With that distance R and all queries within r of the centre, N records are within R + r of
    /// any query, so those that count are within R + 2 r of the centre.
    fn gather(&mut self, search: &RecordSearch, bound: f32, radius: f32) -> f32 {
        let (tree, centre) = (&search.tree, self.centre);
        let within = |reach: f32| (reach + 2.0 * radius) * SLACK;
        let farthest = within(bound) * within(bound);
        self.order.clear();
        tree.for_each_block(centre, farthest, |block| {
            for slot in block {
                let squared = squared_distance(tree.position[slot], centre);
                if squared <= farthest {
                    let key = u64::from(squared.to_bits()) << 32 | slot as u64;
                    self.order.push(key);
                }
            }
        });
        self.order.sort_unstable();
        let squared = |key: &u64| f32::from_bits((key >> 32) as u32);
        let nth = self.order.get(search.rule().candidates - 1);
        let reach = nth.map_or(f32::INFINITY, |key| squared(key).sqrt());
        if reach.is_finite() {
            self.previous = Some((centre, reach));
        }
        let farthest = within(reach) * within(reach);
        let kept = self.order.partition_point(|key| squared(key) <= farthest);
        self.order.truncate(kept);
        self.pack(search);
        reach
    }

    /// Copies the candidates in `order` to groups.
    fn pack(&mut self, search: &RecordSearch) {
        let tree = &search.tree;
        self.groups.clear();
        for keys in self.order.chunks(LANES) {
            let mut group = EMPTY_GROUP;
            for (lane, key) in keys.iter().enumerate() {
                let slot = (key & u64::from(u32::MAX)) as usize;
                let (p, n) = (tree.position[slot], tree.normal[slot]);
                (group.x[lane], group.y[lane], group.z[lane]) = (p.x, p.y, p.z);
                (group.nx[lane], group.ny[lane], group.nz[lane]) = (n.x, n.y, n.z);
                group.record[lane] = tree.record[slot];
            }
            let least = f32::from_bits((keys[0] >> 32) as u32).sqrt();
            group.from_centre = least / SLACK;
            self.groups.push(group);
        }
    }

    /// Fills `chosen` for one query.
    ///
    /// First picks the M best of *all* candidates that pass the normal filter. If they turn out to
    /// be among the N nearest, they are the answer, and nothing has to be ranked.
    fn choose(&mut self, search: &RecordSearch, query: &Query) {
        let rule = search.rule();
        let away = squared_distance(query.position, self.centre).sqrt() * SLACK;
        self.chosen.reset(rule.used);
        self.squared.clear();
        let (chosen, squared) = (&mut self.chosen, &mut self.squared);
        let rank = examine(&self.groups, query, search, away, chosen, squared);
        if self.chosen.neighbours.is_empty() || rank as usize > rule.candidates {
            self.rank_and_choose(search, query);
        }
    }

    /// The rule to the letter: the N nearest, the filter, the M best.
    fn rank_and_choose(&mut self, search: &RecordSearch, query: &Query) {
        let rule = search.rule();
        self.ranked.clear();
        for (g, group) in self.groups.iter().enumerate() {
            let (squared, _) = measure(group, query, search);
            for (lane, squared) in squared.iter().enumerate() {
                let (record, place) = (group.record[lane], g * LANES + lane);
                if record != u32::MAX {
                    self.ranked.push((squared.to_bits(), record, place as u32));
                }
            }
        }
        if self.ranked.len() > rule.candidates {
            self.ranked.select_nth_unstable(rule.candidates - 1);
            self.ranked.truncate(rule.candidates);
        }
        self.take_ranked(search, query, search.least_cosine);
        if self.chosen.neighbours.is_empty() {
            self.take_ranked(search, query, f32::NEG_INFINITY);
        }
    }

    fn take_ranked(&mut self, search: &RecordSearch, query: &Query, least_cosine: f32) {
        self.chosen.reset(search.rule().used);
        for &(bits, record, place) in &self.ranked {
            let (group, lane) = (place as usize / LANES, place as usize % LANES);
            let group = &self.groups[group];
            let cosine = cosine(group, lane, query);
            if cosine >= least_cosine {
                let squared = f32::from_bits(bits);
                let plane = plane_distance(group, lane, query);
                let distance = search.rule().metric.distance(squared, plane, cosine);
                self.chosen.insert(squared, record, distance);
            }
        }
    }
}

/// The best records so far, in ascending order (distance, record).
#[derive(Default)]
struct Chosen {
    neighbours: Vec<Neighbour>,
    /// Squared Euclidean distance of each.
    squared: Vec<f32>,
    most: usize,
    /// Distance of the last one once there are `most`, infinite before.
    worst: f32,
}

impl Chosen {
    fn reset(&mut self, most: usize) {
        self.neighbours.clear();
        self.squared.clear();
        self.most = most;
        self.worst = f32::INFINITY;
    }

    fn insert(&mut self, squared: f32, record: u32, distance: f32) {
        let before = |a: &Neighbour| (a.distance, a.record) < (distance, record);
        if self.neighbours.len() == self.most {
            if self.neighbours.last().is_none_or(before) {
                return;
            }
            self.neighbours.pop();
            self.squared.pop();
        }
        let mut at = self.neighbours.len();
        while at > 0 && !before(&self.neighbours[at - 1]) {
            at -= 1;
        }
        self.neighbours.insert(at, Neighbour { record, distance });
        self.squared.insert(at, squared);
        if self.neighbours.len() == self.most {
            self.worst = self.neighbours[self.most - 1].distance;
        }
    }
}

/// Offers the records of a query's tile to `chosen` until no later group can hold one; `away` is the
/// query's distance from the tile's centre. Tells how many of them all are no farther than the farthest
/// chosen one. `squared` is scratch space. Compiled for AVX2 too, with the same results: nothing is fused.
#[apply(compiled_for_avx2)]
fn examine(
    groups: &[Group],
    query: &Query,
    search: &RecordSearch,
    away: f32,
    chosen: &mut Chosen,
    squared: &mut Vec<[f32; LANES]>,
) -> u32 {
    for group in groups {
        if group.from_centre - away > chosen.worst {
            break;
        }
        let (own, distance) = measure(group, query, search);
        squared.push(own);
        // False for the NaN of records that the filter drops.
        let worst = chosen.worst;
        if !distance.iter().fold(false, |any, &d| any | (d <= worst)) {
            continue;
        }
        for (lane, &distance) in distance.iter().enumerate() {
            if distance <= chosen.worst {
                chosen.insert(own[lane], group.record[lane], distance);
            }
        }
    }
    let farthest = chosen.squared.iter().copied().fold(0.0, f32::max);
    let not_farther = |squared: &[f32; LANES]| {
        let of_lane = squared.iter().map(|&s| u32::from(s <= farthest));
        of_lane.sum::<u32>()
    };
    squared.iter().map(not_farther).sum()
}

/// Squared distances of a group's records, and distances of the rule (NaN where the normals
/// are too different).
#[inline(always)]
fn measure(group: &Group, query: &Query, search: &RecordSearch) -> ([f32; LANES], [f32; LANES]) {
    match search.rule().metric {
        Ranking::Combined(metric) => {
            let distance = |squared, cosine, _| metric.distance(squared, cosine);
            measure_by(group, query, search.least_cosine, distance)
        }
        Ranking::Tangent(metric) => {
            let distance = |squared, cosine, plane| metric.distance(squared, plane, cosine);
            measure_by(group, query, search.least_cosine, distance)
        }
    }
}

#[inline(always)]
fn measure_by(
    group: &Group,
    query: &Query,
    least_cosine: f32,
    distance: impl Fn(f32, f32, f32) -> f32,
) -> ([f32; LANES], [f32; LANES]) {
    let mut squared = [0.0; LANES];
    let mut ranked = [0.0; LANES];
    let p = query.position;
    for lane in 0..LANES {
        let (dx, dy, dz) = (
            group.x[lane] - p.x,
            group.y[lane] - p.y,
            group.z[lane] - p.z,
        );
        squared[lane] = dx * dx + dy * dy + dz * dz;
        let cosine = cosine(group, lane, query);
        let plane = plane_distance(group, lane, query);
        let distance = distance(squared[lane], cosine, plane);
        ranked[lane] = if cosine >= least_cosine {
            distance
        } else {
            f32::NAN
        };
    }
    (squared, ranked)
}

/// The larger of the distances of record and query from each other's tangent plane.
#[inline(always)]
fn plane_distance(group: &Group, lane: usize, query: &Query) -> f32 {
    let (p, n) = (query.position, query.normal);
    let (dx, dy, dz) = (
        group.x[lane] - p.x,
        group.y[lane] - p.y,
        group.z[lane] - p.z,
    );
    let of_query = (dx * n.x + dy * n.y + dz * n.z).abs();
    let of_record = (dx * group.nx[lane] + dy * group.ny[lane] + dz * group.nz[lane]).abs();
    if of_query > of_record {
        of_query
    } else {
        of_record
    }
}

#[inline(always)]
fn cosine(group: &Group, lane: usize, query: &Query) -> f32 {
    let n = query.normal;
    group.nx[lane] * n.x + group.ny[lane] * n.y + group.nz[lane] * n.z
}
