//! How much the records of each shading point disagree about it, kept up to date as records are added.

use glam::Vec3;
use rayon::prelude::*;

use super::Refinable;
use super::egr::each_pixel_around;
use crate::cache::{NO_POINT, Neighbour, Ranking, ShadingPoints};

/// Half the width of the window that a gain is summed over, pixels.
const RADIUS: usize = 2;
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

/// The records of each point and what follows from them.
pub(super) struct Disagreement<'a> {
    points: &'a ShadingPoints,
    metric: Ranking,
    /// Between the normals of a point and of a record that is added.
    least_cosine: f32,
    /// Records of each point, as many as the interpolation uses.
    used: usize,
    /// By point, ascending in (distance, record); [`NONE`] beyond their number.
    nearest: Vec<[Neighbour; MOST_USED]>,
    predictions: Vec<Prediction>,
    /// Records so far.
    count: u32,
    stale: Vec<bool>,
    floods: Vec<Flood>,
}

impl<'a> Disagreement<'a> {
    /// Predicts all points from the records of the first stage.
    pub fn new(input: &Refinable<'a>) -> Self {
        let points = input.points;
        let rule = input.search.rule();
        let nearest = input
            .search
            .map(&points.position, &points.normal, |_, found| {
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
            predictions: vec![Prediction::default(); points.len()],
            count: input.sites.len() as u32,
            stale: vec![true; points.len()],
            floods: Vec::new(),
        };
        this.update(input);
        this
    }

    /// Takes in the next records, at these points.
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
                self.flood(site, (flood, seen))
            });
        for (i, flood) in floods.iter().enumerate() {
            for &(point, distance) in &flood.reached {
                let record = first + i as u32;
                insert(
                    &mut self.nearest[point as usize][..self.used],
                    Neighbour { record, distance },
                );
                self.stale[point as usize] = true;
            }
        }
        self.floods = floods;
        self.update(input);
    }

    /// Predicted standard deviation per pixel.
    pub fn picture(&self) -> Vec<f32> {
        let error = |i: usize| self.predictions[i].variance.sqrt();
        self.points.picture(error)
    }

    /// Collects the points that a new record is among the nearest of, spreading from its pixel to
    /// neighbouring ones. Parts of the surface that hang together in no other way are missed; the
    /// next lookup finds them.
    fn flood(&self, site: u32, (flood, seen): (&mut Flood, &mut Vec<u64>)) {
        let points = self.points;
        let origin = site as usize;
        let pixel = points.pixel[origin] as usize;
        let window = Window::new(points, pixel);
        seen.clear();
        seen.resize((window.side * window.side).div_ceil(64), 0);
        flood.reached.clear();
        flood.front.clear();
        flood.front.push(pixel as u32);
        window.enter(pixel, seen);
        let (p, n) = (points.position[origin], points.normal[origin]);
        while let Some(pixel) = flood.front.pop() {
            let point = points.point_of_pixel[pixel as usize];
            if point == NO_POINT {
                continue;
            }
            let i = point as usize;
            let distance = self.distance((points.position[i], points.normal[i]), (p, n), 1.0);
            let among_nearest = distance < self.nearest[i][self.used - 1].distance;
            if !among_nearest {
                continue;
            }
            flood.reached.push((point, distance));
            each_pixel_around(points, (pixel as usize, 1), |q| {
                if window.enter(q, seen) {
                    flood.front.push(q as u32);
                }
            });
        }
    }

    /// The distance of the interpolation between two surface points, with their offset from the
    /// tangent planes scaled by `steepness`; infinite where normals differ too much.
    fn distance(&self, (p, n): (Vec3, Vec3), (q, m): (Vec3, Vec3), steepness: f32) -> f32 {
        let cosine = n.dot(m);
        let alike = cosine > self.least_cosine;
        if !alike {
            return f32::INFINITY;
        }
        let step = q - p;
        let plane = n.dot(step).abs().max(m.dot(step).abs());
        self.metric
            .distance(step.length_squared(), steepness * plane, cosine)
    }

    /// Predicts stale points anew.
    fn update(&mut self, input: &Refinable) {
        let power = input.power;
        let least = self.points.diagonal * 1e-6;
        let nearest = &self.nearest;
        let predict = |i: usize| {
            let (mut total, mut mean, mut square) = (0.0f32, Vec3::ZERO, 0.0f32);
            let mut distance = 0.0;
            for near in nearest[i].iter().filter(|n| n.record != u32::MAX) {
                let (value, trust) = input.records.predict(near.record, i as u32);
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

    /// Points where `free` holds by the gain expected of a record there: positive, in descending order,
    /// ties by index. Gains are worked out for about the `most` points with the largest variance in the
    /// window, which bounds them.
    pub fn by_gain(&self, free: &[bool], most: usize) -> Vec<u32> {
        let bounds = self.window_sums();
        let bound = |point: usize| bounds[self.points.pixel[point] as usize];
        let least = threshold(&bounds, most);
        let mut gains: Vec<(f32, u32)> = (0..self.points.len())
            .into_par_iter()
            .with_min_len(1024)
            .filter(|&point| free[point] && bound(point) >= least)
            .map(|point| (self.gain(point), point as u32))
            .filter(|(gain, _)| *gain > 0.0)
            .collect();
        gains.par_sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        gains.into_iter().map(|(_, point)| point).collect()
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
                let row = &self.points.point_of_pixel[y * width..][..width];
                let variance: Vec<f32> = row.iter().map(|&point| self.variance(point)).collect();
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

    /// Of a point or of [`NO_POINT`].
    fn variance(&self, point: u32) -> f32 {
        self.predictions
            .get(point as usize)
            .map_or(0.0, |prediction| prediction.variance)
    }

    fn gain(&self, point: usize) -> f32 {
        let points = self.points;
        let pixel = points.pixel[point] as usize;
        let (p, n) = (points.position[point], points.normal[point]);
        let reach = self.predictions[point].distance.max(points.diagonal * 1e-6);
        let mut gain = 0.0;
        each_pixel_around(points, (pixel, RADIUS), |q| {
            let other = points.point_of_pixel[q];
            if other == NO_POINT {
                return;
            }
            let other = other as usize;
            let variance = self.predictions[other].variance;
            if variance > 0.0 {
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

/// A positive number that at least `most` of the values reach, and as few more as its 16 leading bits can
/// tell; least of all if fewer are positive.
fn threshold(values: &[f32], most: usize) -> f32 {
    let mut counts = vec![0u32; 1 << 16];
    for value in values {
        counts[(value.to_bits() >> 16) as usize] += 1;
    }
    let mut above = 0;
    for bin in (1..0x7f80).rev() {
        above += counts[bin] as usize;
        if above >= most {
            return f32::from_bits((bin as u32) << 16);
        }
    }
    f32::MIN_POSITIVE
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
    /// Points, and their distances from the record.
    reached: Vec<(u32, f32)>,
    front: Vec<u32>,
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
