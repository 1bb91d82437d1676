//! The discontinuity map of DGS and how pixels are drawn from it.

use glam::DVec4;
use rayon::prelude::*;

use super::Refinable;
use super::members::is_usable;
use super::pairs::{Spreads, spreads};
use super::pick::{STREAM_FILL, STREAM_MAP, keep_random};
use crate::cache::{NO_POINT, RecordSearch, SearchRule, ShadingPoints};
use crate::sample::Rng;

/// Half the width of the window of the geometry term.
const RADIUS: usize = 2;
/// Draws of taken pixels in a row after which the tables are built anew.
const PATIENCE: usize = 20;
/// Most draws that are looked up together.
const BATCH: usize = 1 << 13;

/// Which terms make the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Recipe {
    pub difference: bool,
    pub geometry: bool,
    /// K.
    pub records: usize,
    /// Differences above this share of the pixels are cut off; 1 leaves them.
    pub clamp_quantile: f64,
}

/// One value for each shading point, and how many pairs of records were compared.
pub(super) fn measure(input: &Refinable, recipe: Recipe) -> (Vec<f32>, usize) {
    let points = input.points;
    let mut map = vec![0.0f32; points.len()];
    let mut pairs = 0;
    if recipe.difference {
        let spreads = differences(input, recipe.records);
        pairs = spreads.pairs;
        for values in [spreads.mean, spreads.largest] {
            add_normalised(&mut map, values, recipe.clamp_quantile);
        }
    }
    if recipe.geometry {
        add_normalised(&mut map, geometry(points), 1.0);
    }
    for &site in input.sites {
        map[site as usize] = 0.0;
    }
    (map, pairs)
}

/// Spread of the differences between each point's K nearest records, ranked as in rendering.
fn differences(input: &Refinable, records: usize) -> Spreads {
    let points = input.points;
    let own;
    let search = if input.search.rule().used == records {
        input.search
    } else {
        let rule = SearchRule {
            candidates: input.search.rule().candidates.max(records),
            used: records,
            ..*input.search.rule()
        };
        let (positions, normals) = input.placed();
        own = RecordSearch::new(&positions, &normals, rule);
        &own
    };
    // A fixed number of records for each pixel, flat and without a vector for each.
    let stride = records;
    let mut nearest = vec![0; points.len() * stride];
    search.fill_records(&points.position, &points.normal, &mut nearest, stride);
    spreads(input, &nearest, stride)
}

/// G (eq. 3) of each point: how much normals differ in the 5 × 5 pixels around it, `Σ (1 − n·n′)`;
/// background counts 0. Rewritten as the number of points less `n` times the sum of their normals,
/// it takes sums over columns, shared by neighbours, and over five of those. In f64, so that it is as
/// small on flat ground as term by term.
fn geometry(points: &ShadingPoints) -> Vec<f32> {
    let window = |at: usize, end: usize| at.saturating_sub(RADIUS)..(at + RADIUS + 1).min(end);
    let fill = |(y, own): (usize, &mut [f32])| {
        let mut columns = vec![DVec4::ZERO; points.width];
        for row in window(y, points.height) {
            let row = &points.point_of_pixel[row * points.width..][..points.width];
            for (sum, &point) in columns.iter_mut().zip(row) {
                if point != NO_POINT {
                    *sum += points.normal[point as usize].as_dvec3().extend(1.0);
                }
            }
        }
        let row = points.point_of_pixel[y * points.width..][..points.width].iter();
        let seen = row.enumerate().filter(|(_, point)| **point != NO_POINT);
        for (value, (x, &point)) in own.iter_mut().zip(seen) {
            let sum: DVec4 = columns[window(x, columns.len())].iter().sum();
            let normal = points.normal[point as usize].as_dvec3();
            *value = (sum.w - normal.dot(sum.truncate())).max(0.0) as f32;
        }
    };
    let mut values = vec![0.0; points.pixel.len()];
    let rows = by_row(&mut values, &row_starts(points));
    rows.into_par_iter().enumerate().for_each(fill);
    values
}

/// The first point of each row of pixels, and the number of points: points lie row after row.
fn row_starts(points: &ShadingPoints) -> Vec<usize> {
    let before_row = |row: usize| {
        let first_pixel = row * points.width;
        points
            .pixel
            .partition_point(|&pixel| (pixel as usize) < first_pixel)
    };
    (0..=points.height).map(before_row).collect()
}

/// The values of the points of each row.
fn by_row<'a, T>(mut values: &'a mut [T], starts: &[usize]) -> Vec<&'a mut [T]> {
    let mut rows = Vec::with_capacity(starts.len());
    for row in starts.windows(2) {
        let (own, rest) = values.split_at_mut(row[1] - row[0]);
        rows.push(own);
        values = rest;
    }
    rows
}

/// Divides by the largest finite value, cut off at a quantile, and adds. What is not finite adds
/// nothing.
fn add_normalised(map: &mut [f32], mut values: Vec<f32>, clamp_quantile: f64) {
    values
        .par_iter_mut()
        .filter(|v| !v.is_finite())
        .for_each(|v| *v = 0.0);
    let mut largest = values.par_iter().copied().reduce(|| 0.0, f32::max);
    if clamp_quantile < 1.0 && !values.is_empty() {
        let mut sorted = values.clone();
        let at = (clamp_quantile * (sorted.len() - 1) as f64) as usize;
        largest = *sorted.select_nth_unstable_by(at, f32::total_cmp).1;
    }
    if largest > 0.0 {
        map.par_iter_mut().zip(values).for_each(|(sum, value)| {
            *sum += (value / largest).min(1.0);
        });
    }
}

/// Draws up to `count` distinct points that are no sites, by importance, then uniformly if points
/// with a positive value are too few. Returns how many were drawn by importance.
pub(super) fn draw(
    input: &Refinable,
    mut map: Vec<f32>,
    count: usize,
    seed: u64,
) -> (Vec<u32>, usize) {
    let points = input.points;
    let all = (0..points.len()).into_par_iter();
    let mut free: Vec<bool> = all.map(|i| is_usable(points, i)).collect();
    input.sites.iter().for_each(|&i| free[i as usize] = false);
    let values = map.par_iter_mut().zip(&free);
    values.for_each(|(value, &free)| *value = if free { *value } else { 0.0 });
    let positive = map.par_iter().filter(|&&v| v > 0.0).count();
    let mut drawn = Vec::with_capacity(count);
    if positive <= count {
        drawn.extend((0..points.len() as u32).filter(|&i| map[i as usize] > 0.0));
    } else {
        let mut rng = Rng::new(seed, STREAM_MAP, 0, 0);
        while drawn.len() < count {
            let tables = Tables::new(points, &map);
            draw_until_tired(&tables, &mut map, &mut rng, &mut drawn, count);
        }
    }
    let by_importance = drawn.len();
    drawn.iter().for_each(|&i| free[i as usize] = false);
    if by_importance < count {
        let mut rest: Vec<u32> = (0..points.len() as u32)
            .filter(|&i| free[i as usize])
            .collect();
        let mut rng = Rng::new(seed, STREAM_FILL, 1, 0);
        keep_random(&mut rest, count - by_importance, &mut rng);
        drawn.extend(rest);
    }
    (drawn, by_importance)
}

/// Draws distinct pixels and zeroes their values, until there are enough or too many draws in a
/// row fall on taken ones.
fn draw_until_tired(
    tables: &Tables,
    map: &mut [f32],
    rng: &mut Rng,
    drawn: &mut Vec<u32>,
    count: usize,
) {
    let mut rejected = 0;
    while drawn.len() < count {
        // All threads look up where the next draws fall; they are taken one after another.
        let mut ahead = rng.clone();
        let draws: Vec<[f64; 2]> = (drawn.len()..count.min(drawn.len() + BATCH))
            .map(|_| [ahead.next_f64(), ahead.next_f64()])
            .collect();
        let points: Vec<u32> = draws
            .par_iter()
            .map(|&[u, v]| tables.sample(u, v))
            .collect();
        for point in points {
            rng.next_f64();
            rng.next_f64();
            if map[point as usize] > 0.0 {
                map[point as usize] = 0.0;
                drawn.push(point);
                rejected = 0;
            } else {
                rejected += 1;
                if rejected == PATIENCE {
                    return;
                }
            }
        }
    }
}

/// Cumulative sums over the points of each row, and over the rows.
struct Tables {
    /// Sum over the row's points up to and including each point.
    within_row: Vec<f64>,
    /// Sum up to and including each row.
    rows: Vec<f64>,
    /// First point of each row, and the number of points.
    starts: Vec<usize>,
}

impl Tables {
    fn new(points: &ShadingPoints, map: &[f32]) -> Self {
        let starts = row_starts(points);
        let mut within_row: Vec<f64> = map.par_iter().map(|&v| f64::from(v)).collect();
        let sum_up = |values: &mut [f64]| {
            let mut sum = 0.0;
            for value in values {
                sum += *value;
                *value = sum;
            }
            sum
        };
        let sums: Vec<f64> = by_row(&mut within_row, &starts)
            .into_par_iter()
            .map(sum_up)
            .collect();
        let mut total = 0.0;
        let rows = sums.iter().map(|sum| {
            total += sum;
            total
        });
        let rows = rows.collect();
        Self {
            within_row,
            rows,
            starts,
        }
    }

    /// The point for two numbers in [0, 1): the row by its marginal, then the point in the row.
    /// Rows and points without value are never returned unless all are.
    fn sample(&self, u: f64, v: f64) -> u32 {
        let row = invert(&self.rows, u);
        let (start, end) = (self.starts[row], self.starts[row + 1]);
        (start + invert(&self.within_row[start..end], v)) as u32
    }
}

/// The first index whose cumulative sum is above u times the total; the first that reaches the
/// total if rounding leaves none.
fn invert(sums: &[f64], u: f64) -> usize {
    let total = sums.last().copied().unwrap_or(0.0);
    let index = sums.partition_point(|&s| s <= u * total);
    index.min(sums.partition_point(|&s| s < total))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inversion_skips_empty_bins_and_never_leaves_the_table() {
        let sums = [0.0, 1.0, 1.0, 3.0, 3.0];
        assert_eq!(invert(&sums, 0.0), 1);
        assert_eq!(invert(&sums, 0.333), 1);
        assert_eq!(invert(&sums, 0.334), 3);
        assert_eq!(invert(&sums, 1.0 - f64::EPSILON), 3);
        assert_eq!(invert(&sums, 1.0), 3);
        assert_eq!(invert(&[0.0, 0.0], 0.5), 0);
    }

    #[test]
    fn the_geometry_term_is_the_sum_over_the_window() {
        let (width, height) = (13, 9);
        let mut rng = Rng::new(3, 0, 0, 0);
        let mut points = ShadingPoints {
            width,
            height,
            point_of_pixel: vec![NO_POINT; width * height],
            ..ShadingPoints::default()
        };
        for pixel in (0..width * height).filter(|pixel| pixel % 7 != 3) {
            points.point_of_pixel[pixel] = points.pixel.len() as u32;
            points.pixel.push(pixel as u32);
            let turned = [0.0; 3].map(|_: f32| rng.next_f32() - 0.5);
            // The left half is flat.
            let normal = match pixel % width < 6 {
                true => glam::Vec3::Y,
                false => glam::Vec3::from(turned).normalize_or(glam::Vec3::X),
            };
            points.normal.push(normal);
        }
        let sums = geometry(&points);
        assert_eq!(sums.len(), points.pixel.len());
        let place = |point: usize| {
            let pixel = points.pixel[point] as usize;
            (pixel % width, pixel / width)
        };
        for (point, sum) in sums.into_iter().enumerate() {
            let (x, y) = place(point);
            let near = (0..points.pixel.len()).filter(|&other| {
                let (u, v) = place(other);
                u.abs_diff(x) <= RADIUS && v.abs_diff(y) <= RADIUS
            });
            let normal = points.normal[point].as_dvec3();
            let expected: f64 = near
                .map(|other| 1.0 - normal.dot(points.normal[other].as_dvec3()))
                .sum();
            let difference = (f64::from(sum) - expected).abs();
            assert!(difference < 1e-5, "{point}: {sum} {expected}");
            assert!(x > 3 || sum == 0.0, "flat ground: {sum}");
        }
    }

    #[test]
    fn normalising_divides_by_the_largest_finite_value() {
        let mut map = vec![1.0, 0.0, 0.0, 0.0];
        add_normalised(&mut map, vec![2.0, 4.0, f32::NAN, f32::INFINITY], 1.0);
        assert_eq!(map, [1.5, 1.0, 0.0, 0.0]);
        add_normalised(&mut map, vec![0.0; 4], 1.0);
        assert_eq!(map, [1.5, 1.0, 0.0, 0.0]);
        let mut clamped = vec![0.0; 5];
        add_normalised(&mut clamped, vec![1.0, 2.0, 3.0, 4.0, 1e6], 0.75);
        assert_eq!(clamped, [0.25, 0.5, 0.75, 1.0, 1.0]);
    }
}
