//! How much the records of shading points disagree about them, kept up to date as records are added.
//!
//! The points are those of every second pixel, as the white fields of a chessboard: neighbouring pixels
//! tell much the same.

use glam::Vec3;
use rayon::prelude::*;

use super::Refinable;
use crate::cache::{NO_POINT, Neighbour, Ranking, ShadingPoints};

/// Half the width of the window that a gain is summed over, pixels.
const RADIUS: usize = 2;
/// Probes, or pixels, that one thread works on in a row.
const PART: usize = 1 << 13;
/// Most records that predict a point.
const MOST_USED: usize = 6;
const NONE: Neighbour = Neighbour {
    record: u32::MAX,
    distance: f32::INFINITY,
};

/// What is known of one point.
#[derive(Clone, Copy, Default)]
struct Prediction {
    /// Weighted variance of what its records say, mean over the channels.
    variance: f32,
    /// Weighted mean distance to its records.
    distance: f32,
}

/// The records of each probe and what follows from them.
pub(super) struct Disagreement<'a> {
    points: &'a ShadingPoints,
    /// The shading points that are looked at.
    probes: Vec<u32>,
    /// Of each pixel, or [`NO_POINT`].
    probe_of_pixel: Vec<u32>,
    metric: Ranking,
    /// Between the normals of a point and of a record that is added.
    least_cosine: f32,
    /// Records of each probe, as many as the interpolation uses.
    used: usize,
    /// By probe, ascending in (distance, record); [`NONE`] beyond their number.
    nearest: Vec<[Neighbour; MOST_USED]>,
    predictions: Vec<Prediction>,
    /// Records so far.
    count: u32,
    stale: Vec<bool>,
    floods: Vec<Flood>,
}

impl<'a> Disagreement<'a> {
    /// Predicts all probes from the records of the first stage.
    pub fn new(input: &Refinable<'a>) -> Self {
        let points = input.points;
        let rule = input.search.rule();
        let is_white = |pixel: u32| {
            let (x, y) = (pixel as usize % points.width, pixel as usize / points.width);
            (x + y).is_multiple_of(2)
        };
        let probes: Vec<u32> = (0..points.len() as u32)
            .into_par_iter()
            .filter(|&point| is_white(points.pixel[point as usize]))
            .collect();
        // Probes lie row after row, as points do.
        let pixel_of = |probe: usize| probes.get(probe).map(|&p| points.pixel[p as usize]);
        let mut probe_of_pixel = vec![0; points.point_of_pixel.len()];
        let parts = probe_of_pixel.par_chunks_mut(PART).enumerate();
        parts.for_each(|(part, own)| {
            let first = (part * PART) as u32;
            let mut probe = probes.partition_point(|&p| points.pixel[p as usize] < first);
            for (pixel, own) in (first..).zip(own) {
                *own = NO_POINT;
                if pixel_of(probe) == Some(pixel) {
                    *own = probe as u32;
                    probe += 1;
                }
            }
        });
        let of_probes = |values: &[Vec3]| -> Vec<Vec3> {
            probes
                .par_iter()
                .map(|&point| values[point as usize])
                .collect()
        };
        let (positions, normals) = (of_probes(&points.position), of_probes(&points.normal));
        let nearest = input.search.map(&positions, &normals, |_, found| {
            let mut own = [NONE; MOST_USED];
            own.iter_mut().zip(found).for_each(|(a, b)| *a = *b);
            own
        });
        let mut this = Self {
            points,
            metric: rule.metric,
            used: rule.used.clamp(1, MOST_USED),
            least_cosine: rule.max_angle_deg.to_radians().cos(),
            nearest,
            predictions: vec![Prediction::default(); probes.len()],
            count: input.sites.len() as u32,
            stale: vec![true; probes.len()],
            probes,
            probe_of_pixel,
            floods: Vec::new(),
        };
        this.update(input);
        this
    }

    /// Takes in the next records, at these points, all of them probes.
    pub fn add(&mut self, input: &Refinable, sites: &[u32]) {
        self.count += sites.len() as u32;
        let first = self.count - sites.len() as u32;
        let mut floods = std::mem::take(&mut self.floods);
        floods.resize_with(sites.len(), Flood::default);
        floods
            .par_iter_mut()
            .zip(sites)
            .with_min_len(16)
            .for_each_init(Vec::new, |seen, (flood, &site)| {
                self.flood(site, flood, seen)
            });
        // Each thread takes in what reached a part of the probes, from all records in their order.
        let used = self.used;
        self.nearest
            .par_chunks_mut(PART)
            .zip(self.stale.par_chunks_mut(PART))
            .enumerate()
            .for_each(|(part, (nearest, stale))| {
                let own = part * PART..(part + 1) * PART;
                for (record, flood) in (first..).zip(&floods) {
                    if flood.least as usize >= own.end || (flood.most as usize) < own.start {
                        continue;
                    }
                    let reached = flood.reached.iter().map(|&(probe, d)| (probe as usize, d));
                    for (probe, distance) in reached.filter(|(probe, _)| own.contains(probe)) {
                        let new = Neighbour { record, distance };
                        insert(&mut nearest[probe - own.start][..used], new);
                        stale[probe - own.start] = true;
                    }
                }
            });
        self.floods = floods;
        self.update(input);
    }

    /// Predicted standard deviation per pixel; between probes that of the neighbour in the row.
    pub fn picture(&self) -> Vec<f32> {
        self.points.picture(|point| {
            let pixel = self.points.pixel[point] as usize;
            let beside = [pixel, pixel.saturating_sub(1), pixel + 1];
            let probes = beside.iter().filter_map(|&q| self.probe_of_pixel.get(q));
            let probe = probes.copied().find(|&probe| probe != NO_POINT);
            self.variance(probe.unwrap_or(NO_POINT)).sqrt()
        })
    }

    /// Collects the probes that a new record is among the nearest of, spreading from its pixel to
    /// neighbouring ones. Parts of the surface that hang together in no other way are missed; the
    /// next lookup finds them.
    fn flood(&self, site: u32, flood: &mut Flood, seen: &mut Vec<u64>) {
        let points = self.points;
        let origin = site as usize;
        let pixel = points.pixel[origin] as usize;
        let window = Window::new(points, pixel);
        seen.clear();
        seen.resize((window.side * window.side).div_ceil(64), 0);
        flood.clear();
        flood.front.push(pixel as u32);
        window.enter(pixel, seen);
        while let Some(pixel) = flood.front.pop() {
            let probe = self.probe_of_pixel[pixel as usize];
            if probe == NO_POINT {
                continue;
            }
            let i = self.probes[probe as usize] as usize;
            let distance = self.distance(i, origin);
            let farthest = self.nearest[probe as usize][self.used - 1];
            if distance >= farthest.distance {
                continue;
            }
            flood.reach(probe, distance);
            each_white_neighbour(points, pixel as usize, |q| {
                if window.enter(q, seen) {
                    flood.front.push(q as u32);
                }
            });
        }
    }

    /// The distance of the interpolation between two shading points; infinite where normals differ too much.
    fn distance(&self, from: usize, to: usize) -> f32 {
        let points = self.points;
        let (p, n) = (points.position[from], points.normal[from]);
        let (q, m) = (points.position[to], points.normal[to]);
        let cosine = n.dot(m);
        let alike = cosine > self.least_cosine;
        if !alike {
            return f32::INFINITY;
        }
        let step = q - p;
        let plane = n.dot(step).abs().max(m.dot(step).abs());
        self.metric.distance(step.length_squared(), plane, cosine)
    }

    /// Predicts stale probes anew.
    fn update(&mut self, input: &Refinable) {
        let power = input.power;
        let least = self.points.diagonal * 1e-6;
        let (nearest, probes) = (&self.nearest, &self.probes);
        let predict = |i: usize| {
            let (mut total, mut mean, mut square) = (0.0f32, Vec3::ZERO, 0.0f32);
            let mut distance = 0.0;
            for near in nearest[i].iter().filter(|n| n.record != u32::MAX) {
                let (value, trust) = input.records.predict(near.record, probes[i]);
                if !value.is_finite() {
                    continue;
                }
                let d = near.distance.max(least) / nearest[i][0].distance.max(least);
                let weight = trust * d.powi(-power);
                // Welford's update: nothing cancels.
                total += weight;
                distance += weight * near.distance;
                let step = value - mean;
                mean += step * (weight / total);
                square += weight * step.dot(value - mean);
            }
            if total > 0.0 {
                Prediction {
                    variance: square / (3.0 * total),
                    distance: distance / total,
                }
            } else {
                Prediction::default()
            }
        };
        self.predictions
            .par_iter_mut()
            .zip(&mut self.stale)
            .enumerate()
            .with_min_len(1024)
            .filter(|(_, (_, stale))| **stale)
            .for_each(|(i, (prediction, stale))| {
                *prediction = predict(i);
                *stale = false;
            });
    }

    /// Probes, as points, where `free` holds, by the gain expected of a record there: positive, in descending order,
    /// ties by index. Gains are worked out for about the `most` points with the largest variance in the
    /// window, which bounds them.
    pub fn by_gain(&self, free: &[bool], most: usize) -> Vec<u32> {
        let bounds = self.window_sums();
        let bound = |point: u32| bounds[self.points.pixel[point as usize] as usize];
        let least = threshold(&bounds, most);
        let mut gains: Vec<(f32, u32)> = self
            .probes
            .par_iter()
            .enumerate()
            .with_min_len(1024)
            .filter(|&(_, &point)| free[point as usize] && bound(point) >= least)
            .map(|(probe, &point)| (self.gain(probe), point))
            .filter(|(gain, _)| *gain > 0.0)
            .collect();
        gains.par_sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        gains.into_par_iter().map(|(_, point)| point).collect()
    }

    /// Summed variance of the window around each pixel.
    fn window_sums(&self) -> Vec<f32> {
        let (width, height) = (self.points.width, self.points.height);
        let near = |at: usize, most: usize| at.saturating_sub(RADIUS)..(at + RADIUS + 1).min(most);
        let mut in_rows = vec![0.0; width * height];
        in_rows
            .par_chunks_mut(width)
            .enumerate()
            .for_each(|(y, sums)| {
                let row = &self.probe_of_pixel[y * width..][..width];
                let variance: Vec<f32> = row.iter().map(|&probe| self.variance(probe)).collect();
                for (x, sum) in sums.iter_mut().enumerate() {
                    *sum = variance[near(x, width)].iter().sum();
                }
            });
        let mut sums = vec![0.0; width * height];
        sums.par_chunks_mut(width)
            .enumerate()
            .for_each(|(y, sums)| {
                for row in near(y, height) {
                    let row = &in_rows[row * width..][..width];
                    sums.iter_mut().zip(row).for_each(|(sum, add)| *sum += add);
                }
            });
        sums
    }

    /// Of a probe or of [`NO_POINT`].
    fn variance(&self, probe: u32) -> f32 {
        self.predictions
            .get(probe as usize)
            .map_or(0.0, |prediction| prediction.variance)
    }

    fn gain(&self, probe: usize) -> f32 {
        let points = self.points;
        let point = self.probes[probe] as usize;
        let pixel = points.pixel[point] as usize;
        let (p, n) = (points.position[point], points.normal[point]);
        let reach = self.predictions[probe].distance.max(points.diagonal * 1e-6);
        let mut gain = 0.0;
        each_pixel_around(points, pixel, RADIUS, |q| {
            let variance = self.variance(self.probe_of_pixel[q]);
            if variance > 0.0 {
                let other = points.point_of_pixel[q] as usize;
                let step = points.position[other] - p;
                let plane = 0.5 * n.dot(step).abs();
                let cosine = n.dot(points.normal[other]);
                let distance = self.metric.distance(step.length_squared(), plane, cosine);
                let far = distance / reach;
                gain += variance / (1.0 + far * far);
            }
        });
        if gain.is_finite() { gain } else { 0.0 }
    }
}

/// The pixels of the square of `reach` pixels around one, clipped by the film.
fn each_pixel_around(
    points: &ShadingPoints,
    pixel: usize,
    reach: usize,
    mut visit: impl FnMut(usize),
) {
    let (x, y) = (pixel % points.width, pixel / points.width);
    for row in y.saturating_sub(reach)..(y + reach + 1).min(points.height) {
        for column in x.saturating_sub(reach)..(x + reach + 1).min(points.width) {
            visit(row * points.width + column);
        }
    }
}

/// A positive number that at least `most` of the values reach, and as few more as its 16 leading bits can
/// tell; least of all if fewer are positive.
fn threshold(values: &[f32], most: usize) -> f32 {
    let count = |values: &[f32]| {
        let mut counts = vec![0u32; 1 << 16];
        for value in values {
            counts[(value.to_bits() >> 16) as usize] += 1;
        }
        counts
    };
    let add = |mut sum: Vec<u32>, other: Vec<u32>| {
        sum.iter_mut().zip(other).for_each(|(a, b)| *a += b);
        sum
    };
    let parts = values.par_chunks(1 << 18).map(count);
    let counts = parts.reduce(|| vec![0; 1 << 16], add);
    let mut above = 0;
    for bin in (1..0x7f80).rev() {
        above += counts[bin] as usize;
        if above >= most {
            return f32::from_bits((bin as u32) << 16);
        }
    }
    f32::MIN_POSITIVE
}

/// The white fields around one, within the film.
fn each_white_neighbour(points: &ShadingPoints, pixel: usize, mut visit: impl FnMut(usize)) {
    const STEPS: [(isize, isize); 8] = [
        (-1, -1),
        (1, -1),
        (-1, 1),
        (1, 1),
        (-2, 0),
        (2, 0),
        (0, -2),
        (0, 2),
    ];
    let (x, y) = (pixel % points.width, pixel / points.width);
    for (dx, dy) in STEPS {
        let place = x.checked_add_signed(dx).zip(y.checked_add_signed(dy));
        if let Some((x, y)) = place.filter(|&(x, y)| x < points.width && y < points.height) {
            visit(y * points.width + x);
        }
    }
}

fn insert(nearest: &mut [Neighbour], new: Neighbour) {
    let mut at = nearest.len();
    while at > 0 && new.distance < nearest[at - 1].distance {
        at -= 1;
    }
    if at < nearest.len() {
        nearest.copy_within(at..nearest.len() - 1, at + 1);
        nearest[at] = new;
    }
}

/// Working memory of the spread of one record.
#[derive(Default)]
struct Flood {
    /// Probes, and their distances from the record.
    reached: Vec<(u32, f32)>,
    /// The first and the last probe that was reached.
    least: u32,
    most: u32,
    front: Vec<u32>,
}

impl Flood {
    fn clear(&mut self) {
        self.reached.clear();
        self.front.clear();
        (self.least, self.most) = (u32::MAX, 0);
    }

    fn reach(&mut self, probe: u32, distance: f32) {
        self.reached.push((probe, distance));
        self.least = self.least.min(probe);
        self.most = self.most.max(probe);
    }
}

/// The pixels that a flood may reach: a square around the record's.
struct Window {
    left: usize,
    top: usize,
    side: usize,
    width: usize,
}

/// Half the side of a window, pixels.
const REACH: usize = 64;

impl Window {
    fn new(points: &ShadingPoints, pixel: usize) -> Self {
        let (x, y) = (pixel % points.width, pixel / points.width);
        Self {
            left: x.saturating_sub(REACH),
            top: y.saturating_sub(REACH),
            side: 2 * REACH + 1,
            width: points.width,
        }
    }

    /// Marks a pixel; whether it lies in the window and was not marked yet.
    fn enter(&self, pixel: usize, seen: &mut [u64]) -> bool {
        let (x, y) = (pixel % self.width, pixel / self.width);
        if x < self.left || y < self.top || x >= self.left + self.side || y >= self.top + self.side
        {
            return false;
        }
        let at = (y - self.top) * self.side + x - self.left;
        let new = seen[at / 64] >> (at % 64) & 1 == 0;
        seen[at / 64] |= 1 << (at % 64);
        new
    }
}

#[cfg(test)]
#[path = "disagreement_tests.rs"]
mod tests;
