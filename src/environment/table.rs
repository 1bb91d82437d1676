//! A piecewise-constant density over rectangles of the sphere.

use std::ops::Range;

use rayon::prelude::*;

/// Cells in rows of equal width in φ; within a cell the density per solid angle is constant and
/// proportional to the cell's value.
#[derive(Clone, Debug)]
pub(super) struct SphereTable {
    columns: usize,
    /// cos θ of the rows' edges, from 1 down to -1; one more than there are rows.
    edges: Vec<f64>,
    /// Running sums of the values in each row.
    running: Vec<f64>,
    /// Running sums over rows of Σ value · solid angle.
    rows: Vec<f64>,
    /// For each row, where [`GUIDES`] equal parts of its sum begin.
    guides: Vec<u32>,
}

/// Parts of a row's sum; a power of two, so that products with it are exact.
const GUIDES: usize = 256;

impl SphereTable {
    /// Values are taken from `value(column, row)`, which must be finite and not negative.
    pub fn new(
        columns: usize,
        edges: Vec<f64>,
        value: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Self {
        let row_count = edges.len() - 1;
        let mut running = vec![0.0; columns * row_count];
        running
            .par_chunks_mut(columns)
            .enumerate()
            .for_each(|(row, sums)| {
                let mut sum = 0.0;
                for (column, entry) in sums.iter_mut().enumerate() {
                    sum += value(column, row);
                    *entry = sum;
                }
            });
        let guides = running
            .par_chunks(columns)
            .flat_map_iter(|sums| {
                let last = sums[columns - 1];
                let part = move |i: usize| i as f64 / GUIDES as f64 * last;
                (0..GUIDES).map(move |i| sums.partition_point(|&s| s <= part(i)) as u32)
            })
            .collect();
        let mut total = 0.0;
        let rows = (0..row_count)
            .map(|row| {
                let cell = (edges[row] - edges[row + 1]) * std::f64::consts::TAU / columns as f64;
                total += running[(row + 1) * columns - 1] * cell;
                total
            })
            .collect();
        Self {
            columns,
            edges,
            running,
            rows,
            guides,
        }
    }

    /// Σ value · solid angle.
    pub fn total(&self) -> f64 {
        self.rows.last().copied().unwrap_or(0.0)
    }

    pub fn bytes(&self) -> usize {
        size_of_val(self.edges.as_slice())
            + size_of_val(self.running.as_slice())
            + size_of_val(self.rows.as_slice())
            + size_of_val(self.guides.as_slice())
    }

    fn row_of(&self, row: usize) -> &[f64] {
        &self.running[row * self.columns..(row + 1) * self.columns]
    }

    /// A point (φ as a share of the circle, cos θ) and its density per solid angle for `u` in
    /// [0, 1)²; `None` when all values are zero.
    pub fn sample(&self, u: [f64; 2]) -> Option<([f64; 2], f64)> {
        if self.total() <= 0.0 {
            return None;
        }
        let (row, v) = pick(&self.rows, 0..self.rows.len(), u[1]);
        let sums = self.row_of(row);
        let (column, x) = pick(sums, self.guided(row, u[0]), u[0]);
        let cos = self.edges[row] + v * (self.edges[row + 1] - self.edges[row]);
        let density = self.value(column, row) / self.total();
        (density > 0.0).then_some(([(column as f64 + x) / self.columns as f64, cos], density))
    }

    /// What [`SphereTable::sample`] finds a point with, in [0, 1]²; `None` where the density is zero.
    pub fn place(&self, [phi, cos]: [f64; 2]) -> Option<[f64; 2]> {
        let row_count = self.rows.len();
        let row = self.edges[1..].partition_point(|edge| *edge > cos);
        let row = row.min(row_count - 1);
        let [top, bottom] = [self.edges[row], self.edges[row + 1]];
        let sums = self.row_of(row);
        let column = ((phi * self.columns as f64) as usize).min(self.columns - 1);
        let within = [
            along(sums, column, phi * self.columns as f64 - column as f64),
            along(&self.rows, row, (top - cos) / (top - bottom)),
        ];
        (self.value(column, row) > 0.0).then_some(within)
    }

    /// A range of columns that holds the one which `u` falls into.
    fn guided(&self, row: usize, u: f64) -> Range<usize> {
        let guides = &self.guides[row * GUIDES..(row + 1) * GUIDES];
        let part = ((u * GUIDES as f64) as usize).min(GUIDES - 1);
        let end = guides
            .get(part + 1)
            .map_or(self.columns, |&g| g as usize + 1);
        guides[part] as usize..end.min(self.columns)
    }

    /// Density per solid angle at φ (share of the circle in [0, 1]) in `row`; 0 when all values are.
    pub fn density(&self, phi: f64, row: usize) -> f64 {
        if self.total() <= 0.0 {
            return 0.0;
        }
        let column = ((phi * self.columns as f64) as usize).min(self.columns - 1);
        self.value(column, row.min(self.rows.len() - 1)) / self.total()
    }

    fn value(&self, column: usize, row: usize) -> f64 {
        let sums = self.row_of(row);
        let before = if column == 0 { 0.0 } else { sums[column - 1] };
        sums[column] - before
    }
}

/// What [`pick`] finds a part of an entry with.
fn along(sums: &[f64], index: usize, share: f64) -> f64 {
    let before = if index == 0 { 0.0 } else { sums[index - 1] };
    let here = before + share.clamp(0.0, 1.0) * (sums[index] - before);
    here / sums[sums.len() - 1]
}

/// The entry of a running sum that `u` in [0, 1) falls into, never one of zero width, and where in
/// it; it is one of `among`. The last sum must be positive.
fn pick(sums: &[f64], among: Range<usize>, u: f64) -> (usize, f64) {
    let last = sums[sums.len() - 1];
    let target = u * last;
    let index = among.start + sums[among].partition_point(|&s| s <= target);
    let index = index.min(sums.len() - 1);
    let before = if index == 0 { 0.0 } else { sums[index - 1] };
    let share = (target - before) / (sums[index] - before);
    (index, share.clamp(0.0, 1.0 - f64::EPSILON))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    #[test]
    fn places_lead_to_points_and_back() {
        let edges = vec![1.0, 0.3, -0.2, -1.0];
        let value = |column: usize, row: usize| ((column * 7 + row) % 5) as f64;
        let table = SphereTable::new(11, edges, value);
        let mut rng = Rng::new(2, 0, 0, 0);
        for _ in 0..1000 {
            let u = [rng.next_f64(), rng.next_f64()];
            let (point, _) = table.sample(u).expect("a point");
            let found = table.place(point).expect("a place");
            let near = found.iter().zip(u).all(|(a, b)| (a - b).abs() < 1e-9);
            assert!(near, "{found:?} {u:?}");
        }
        // Column 0 of row 0 is dark.
        assert_eq!(table.place([0.01, 0.9]), None);
        assert!(table.place([1.0, -1.0]).is_some());
    }

    #[test]
    fn guides_change_nothing() {
        let edges = vec![1.0, 0.3, -1.0];
        for columns in [1, 3, 700] {
            let table = SphereTable::new(columns, edges.clone(), |column, row| {
                let random = Rng::new(1, row as u64, column as u64, 0).next_f64();
                if random < 0.6 {
                    0.0
                } else {
                    random.powi(20) + 1e-9
                }
            });
            let mut rng = Rng::new(2, 0, 0, 0);
            for row in 0..2 {
                let sums = table.row_of(row);
                if sums[columns - 1] == 0.0 {
                    continue;
                }
                for i in 0..4000 {
                    let u = match i {
                        0..256 => f64::from(i) / 256.0,
                        256 => 1.0 - f64::EPSILON / 2.0,
                        _ => rng.next_f64(),
                    };
                    let plain = pick(sums, 0..columns, u);
                    assert_eq!(pick(sums, table.guided(row, u), u), plain, "{u}");
                }
            }
        }
    }
}
