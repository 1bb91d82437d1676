//! EGR: error-guided rounds.
//!
//! The records predict every shading point by the rule of interpolation that will render it. Where the records
//! of a point disagree about it, the interpolation is likely to be wrong: their weighted variance is the
//! predicted squared error E². A new record at point s is expected to mend
//!
//! ```text
//! gain(s) = Σ_q E²(q) / (1 + D²(s, q) / h²)        q: the 5 × 5 pixels around s
//! ```
//!
//! with D the distance of the interpolation, half as steep off the tangent plane of s, and h the weighted mean
//! distance of s to its records. The points of largest gain become records, none within
//! `1.4 √(points / records)` pixels of another of the same round; their values are taken in, and the next round
//! begins. Points are looked at, and may become records, in every second pixel (the white fields of a
//! chessboard); only those that a new record reaches are predicted anew. It sees what the interpolation will get
//! wrong, so it needs no threshold and no term of geometry. Everything but the first stage is deterministic.
//!
//! Importance caching interpolates no values: there the records' totals take the place of predictions. Its noise is
//! then within the intervals of discontinuity-guided sampling, its FLIP mostly a little above
//! (`configs/ours/importance.toml`): no reason to use it there.

use rayon::prelude::*;

use super::disagreement::Disagreement;
use super::members::{is_usable, usable};
use super::pick::{STREAM_FILL, keep_random};
use super::{Placement, Refinable, Refinement};
use crate::cache::interpolation::gradient;
use crate::cache::{NO_POINT, ShadingPoints};
use crate::entry::{About, Bias, parameters};
use crate::placement::RefinementEntry;
use crate::sample::Rng;

parameters! {
    /// Puts records where the ones that are there disagree.
    #[derive(Clone, Copy, Debug)]
    pub struct ErrorGuided {
        /// Share of the records kept back for the rounds.
        pub ratio: f64 = 0.5, Within(0.0, 0.9);
        /// Rounds that the share is spread over.
        pub rounds: usize = 5, Within(1.0, 64.0);
        /// Least distance between records of a round.
        pub spacing: f64 = 1.4, Within(0.0, 4.0), "√(points/records) pixels";
    }
}

/// Registry entry.
pub const ENTRY: RefinementEntry = RefinementEntry {
    about: About {
        id: "EGR",
        module: crate::entry::head_comment!("egr.rs"),
        aliases: &["error-guided", "error-guided-rounds"],
        summary: "ours: rounds of records where those around a point disagree about it",
        source: "ours",
        bias: Bias::Consistent,
        version: 1,
        failures: &[
            "What all records around a point miss alike is not seen: a contact that none of them feels.",
            "Noisy records disagree by their noise, which more records do not mend.",
            "Needs values while it places: evaluation cannot be put off until all sites are known.",
        ],
        parameters: ErrorGuided::PARAMETERS,
    },
    build: |table| Ok(Box::new(ErrorGuided::read(table)?)),
    interpolation: &gradient::ENTRY,
};

impl Refinement for ErrorGuided {
    fn ratio(&self) -> f64 {
        self.ratio
    }

    fn predicts(&self) -> bool {
        true
    }

    fn refine(&self, input: &mut Refinable, count: usize, seed: u64) -> Placement {
        let points = input.points;
        let records = (input.sites.len() + count).max(1);
        let spacing = self.spacing * (points.len() as f64 / records as f64).sqrt();
        let all = (0..points.len()).into_par_iter();
        let mut free: Vec<bool> = all.map(|i| is_usable(points, i)).collect();
        input.sites.iter().for_each(|&i| free[i as usize] = false);
        let mut disagreement = Disagreement::new(input);
        let mut sites: Vec<u32> = Vec::with_capacity(count);
        for round in 0..self.rounds {
            let wanted = count * (round + 1) / self.rounds - sites.len();
            let order = disagreement.by_gain(&free, wanted * CONSIDERED);
            let mut chosen = spaced(points, &order, &mut free, wanted, spacing);
            points.sort_by_block(&mut chosen);
            sites.extend(&chosen);
            if round + 1 < self.rounds {
                input.records.add(&chosen);
                disagreement.add(input, &chosen);
            }
        }
        let by_gain = sites.len();
        let mut notes = Vec::new();
        if by_gain < count {
            let mut rest = usable(points);
            rest.retain(|&i| free[i as usize]);
            let mut rng = Rng::new(seed, STREAM_FILL, 3, 0);
            keep_random(&mut rest, count - by_gain, &mut rng);
            sites.extend(rest);
            notes.push(format!(
                "records disagree at {by_gain} points only; the other {} are uniformly random",
                sites.len() - by_gain
            ));
        }
        Placement {
            sites,
            found: vec![("by_gain", by_gain as f64)],
            notes,
            map: Some(disagreement.picture()),
        }
    }
}

/// Points that are considered for each record that is wanted.
const CONSIDERED: usize = 64;
/// Candidates that all threads look at before those that fit are chosen one after another.
const BATCH: usize = 1 << 13;

/// The first `count` free points of an order, none within `spacing` pixels (Chebyshev) of another; the
/// spacing is halved while they are too few. They are free no longer.
fn spaced(
    points: &ShadingPoints,
    order: &[u32],
    free: &mut [bool],
    count: usize,
    spacing: f64,
) -> Vec<u32> {
    let mut chosen = Vec::with_capacity(count);
    let mut reach = spacing as usize;
    while chosen.len() < count {
        let mut grid = SpacedGrid::new(points, reach);
        chosen.iter().for_each(|&point| grid.enter(point));
        for batch in order.chunks(BATCH) {
            // Most candidates are too near to one that was chosen long ago: all threads sort them out.
            let fits = |grid: &SpacedGrid, point: u32| free[point as usize] && grid.has_room(point);
            let batch = batch.par_iter().copied();
            let candidates: Vec<u32> = batch.filter(|&p| fits(&grid, p)).collect();
            for point in candidates {
                if chosen.len() < count && grid.has_room(point) {
                    free[point as usize] = false;
                    chosen.push(point);
                    grid.enter(point);
                }
            }
            if chosen.len() == count {
                break;
            }
        }
        if reach == 0 {
            break;
        }
        reach /= 2;
    }
    chosen
}

/// Chosen points no nearer to each other than a distance, so that each cell of a grid holds at most one.
struct SpacedGrid<'a> {
    points: &'a ShadingPoints,
    /// Points at most so many pixels apart (Chebyshev) are too near; a cell is a pixel wider.
    reach: usize,
    columns: usize,
    /// The pixel of the point in each cell, or [`NO_POINT`].
    cells: Vec<u32>,
}

impl<'a> SpacedGrid<'a> {
    fn new(points: &'a ShadingPoints, reach: usize) -> Self {
        let cells_across = |pixels: usize| pixels.div_ceil(reach + 1);
        let columns = cells_across(points.width);
        Self {
            points,
            reach,
            columns,
            cells: vec![NO_POINT; columns * cells_across(points.height)],
        }
    }

    fn place(&self, pixel: u32) -> (usize, usize) {
        let pixel = pixel as usize;
        (pixel % self.points.width, pixel / self.points.width)
    }

    fn enter(&mut self, point: u32) {
        let pixel = self.points.pixel[point as usize];
        let (x, y) = self.place(pixel);
        let side = self.reach + 1;
        self.cells[y / side * self.columns + x / side] = pixel;
    }

    /// Whether no chosen point is too near.
    fn has_room(&self, point: u32) -> bool {
        let (x, y) = self.place(self.points.pixel[point as usize]);
        let side = self.reach + 1;
        let (column, row) = (x / side, y / side);
        let rows = self.cells.chunks_exact(self.columns);
        let near = rows.skip(row.saturating_sub(1)).take(row.min(1) + 2);
        near.flat_map(|row| &row[column.saturating_sub(1)..(column + 2).min(self.columns)])
            .filter(|&&pixel| pixel != NO_POINT)
            .all(|&pixel| {
                let (u, v) = self.place(pixel);
                u.abs_diff(x) > self.reach || v.abs_diff(y) > self.reach
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_keep_their_distance_and_none_that_has_room_is_passed_over() {
        let (width, height) = (61, 37);
        let pixels = width * height;
        let points = ShadingPoints {
            width,
            height,
            pixel: (0..pixels as u32).collect(),
            point_of_pixel: (0..pixels as u32).collect(),
            ..ShadingPoints::default()
        };
        let mut order: Vec<u32> = (0..pixels as u32).collect();
        keep_random(&mut order, pixels, &mut Rng::new(5, 0, 0, 0));
        let far = |a: u32, b: u32, reach: usize| {
            let [(x, y), (u, v)] = [a, b].map(|p| (p as usize % width, p as usize / width));
            x.abs_diff(u) > reach || y.abs_diff(v) > reach
        };
        for reach in [0, 1, 4, 9] {
            let mut expected: Vec<u32> = Vec::new();
            for &point in &order {
                if expected.iter().all(|&other| far(point, other, reach)) {
                    expected.push(point);
                }
            }
            let mut free = vec![true; pixels];
            let count = expected.len();
            let chosen = spaced(&points, &order, &mut free, count, reach as f64);
            assert_eq!(chosen, expected, "{reach} pixels");
            assert!(chosen.iter().all(|&point| !free[point as usize]));
        }
        // More than fit are had by halving the distance.
        let mut free = vec![true; pixels];
        let all = spaced(&points, &order, &mut free, pixels, 9.0);
        assert_eq!(all.len(), pixels);
    }
}
