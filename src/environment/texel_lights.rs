//! A map as several hundred lights that keep their texels: strata for sampling it.
//!
//! The texels are those of the decomposition, emissive ones first and none excluded; in each group
//! neighbouring lights follow each other (k-d order of their directions), so that equal steps along
//! the list are strata on the sphere.

use std::borrow::Cow;
use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::directs::{Steps, directs};
use super::emissive::{Classification, Rule};
use super::indirects::{Weights, cut};
use super::leaves::{cells_of_texels, leaves};
use super::texels::{Cluster, Texels};
use super::{Environment, Light, LightKind, LightSet};

/// Lights are padded with black ones to a multiple of this in both groups.
pub const LANES: usize = 8;

/// Lights in arrays, world space; emissive ones (group 0) before the others (group 1).
#[derive(Clone, Debug, Default)]
pub struct TexelLights {
    /// Unit vectors towards the lights, by axis.
    pub direction: [Vec<f32>; 3],
    /// |Σ energy · direction| / Σ energy, in [0, 1]: the mean cosine towards the light's direction.
    pub moment: Vec<f32>,
    /// Sine of the half-angle of the cone that holds all texels, in [0, 1].
    pub reach: Vec<f32>,
    /// Σ radiance · solid angle, by channel.
    pub power: [Vec<f32>; 3],
    /// The lights of each group, without padding between `start` and `start + count`.
    pub groups: [Range<usize>; 2],
    /// What was found on the way.
    pub set: LightSet,
    /// Where each light's texels begin in `texels`; one more than there are lights.
    first: Vec<u32>,
    texels: Vec<u32>,
    /// Running sums over each light's texels of luminance · solid angle, the last of a light 1.
    running: Vec<f32>,
}

/// A direction drawn from a light.
#[derive(Clone, Copy, Debug)]
pub struct TexelSample {
    /// Unit, world space.
    pub direction: Vec3,
    /// Density per steradian among the directions of the light.
    pub pdf_sr: f32,
}

/// What the lights are made from; the decomposition's defaults.
const RULE: Rule = Rule {
    average_factor: 3.0,
    maximum_factor: 0.001,
    quantile: 0.98,
    count_texels: false,
};
const WEIGHTS: Weights = Weights {
    variance: 1.0,
    extent: 5.0,
    energy: 1.0,
};
const LEAVES: usize = 8192;
const MASKING: f64 = 0.15;
/// No light: black texels.
const NONE: u32 = u32::MAX;

impl TexelLights {
    /// At most `count` lights; none for a black map. Texels count with the mean of the bilinear
    /// lookup over them, so that every direction from which light comes belongs to a light.
    pub fn new(map: &Environment, count: usize, seed: u64) -> Self {
        let texels = Texels::with_pixels(map, Cow::Owned(lookup_means(map)));
        let (labels, direct, total) = labels(&texels, count, seed);
        let mut clusters = vec![Cluster::default(); total];
        let mut sizes = vec![0u32; total];
        for (texel, &label) in labels.iter().enumerate().filter(|(_, l)| **l != NONE) {
            clusters[label as usize].add(&texels, texel);
            sizes[label as usize] += 1;
        }
        let axes: Vec<DVec3> = clusters
            .iter()
            .map(|c| c.direction(&texels).unwrap_or(DVec3::Y))
            .collect();
        let of_group = |range: Range<usize>| {
            let mut order: Vec<u32> = range
                .filter(|&i| clusters[i].energy > 0.0)
                .map(|i| i as u32)
                .collect();
            k_d_order(&mut order, &axes);
            order
        };
        let orders = [of_group(0..direct), of_group(direct..total)];
        let mut lights = Self::default();
        let mut position = vec![NONE; total];
        lights.first.push(0);
        for (group, order) in orders.iter().enumerate() {
            lights.groups[group].start = lights.moment.len();
            for &label in order {
                position[label as usize] = lights.moment.len() as u32;
                let cluster = &clusters[label as usize];
                let mean = cluster.moment.length() / cluster.energy;
                let axis = map.to_world() * axes[label as usize].as_vec3();
                lights.push(axis.normalize(), mean.min(1.0), cluster.power);
                let end = lights.first[lights.first.len() - 1] + sizes[label as usize];
                lights.first.push(end);
            }
            while !lights.moment.len().is_multiple_of(LANES) {
                lights.push(Vec3::Y, 0.0, DVec3::ZERO);
                lights.first.push(lights.first[lights.first.len() - 1]);
            }
            lights.groups[group].end = lights.moment.len();
        }
        lights.fill(&texels, (&labels, &position), &axes);
        lights.describe(&orders);
        lights
    }

    /// Number of lights, padding included; a multiple of [`LANES`].
    pub fn len(&self) -> usize {
        self.moment.len()
    }

    /// Whether the map is black.
    pub fn is_empty(&self) -> bool {
        self.moment.is_empty()
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        4 * (self.texels.len() + self.running.len() + 10 * self.len())
    }

    fn push(&mut self, axis: Vec3, moment: f64, power: DVec3) {
        for c in 0..3 {
            self.direction[c].push(axis[c]);
            self.power[c].push(power[c] as f32);
        }
        self.moment.push(moment as f32);
        self.reach.push(0.0);
    }

    /// Deals the texels to the lights, with running sums and extents.
    fn fill(&mut self, texels: &Texels, (labels, position): (&[u32], &[u32]), axes: &[DVec3]) {
        let mut next = self.first.clone();
        self.texels = vec![0; self.first[self.first.len() - 1] as usize];
        let mut farthest = vec![0.0f64; axes.len()];
        for (texel, &label) in labels.iter().enumerate().filter(|(_, l)| **l != NONE) {
            let label = label as usize;
            let light = position[label] as usize;
            self.texels[next[light] as usize] = texel as u32;
            next[light] += 1;
            let chord = (texels.direction(texel) - axes[label]).length_squared();
            farthest[label] = farthest[label].max(chord);
        }
        // A texel reaches half its diagonal beyond its centre.
        let half = 0.5 * std::f64::consts::PI / texels.height() as f64;
        let half = half.hypot(std::f64::consts::PI / texels.width() as f64);
        for (label, &light) in position.iter().enumerate().filter(|(_, l)| **l != NONE) {
            let angle = 2.0 * (0.5 * farthest[label].sqrt()).min(1.0).asin() + half;
            let angle = angle.min(std::f64::consts::FRAC_PI_2);
            self.reach[light as usize] = angle.sin() as f32;
        }
        self.running = vec![0.0; self.texels.len()];
        let bounds = &self.first;
        let mut rest = &mut self.running[..];
        let mut runs = Vec::with_capacity(bounds.len());
        for pair in bounds.windows(2) {
            let (own, after) = rest.split_at_mut((pair[1] - pair[0]) as usize);
            runs.push((own, pair[0] as usize..pair[1] as usize));
            rest = after;
        }
        let list = &self.texels;
        runs.into_par_iter().for_each(|(running, range)| {
            let total: f64 = list[range.clone()]
                .iter()
                .map(|&t| texels.energy(t as usize))
                .sum();
            let mut sum = 0.0;
            for (entry, &texel) in running.iter_mut().zip(&list[range]) {
                sum += texels.energy(texel as usize);
                *entry = (sum / total) as f32;
            }
            if let Some(last) = running.last_mut() {
                *last = 1.0;
            }
        });
    }

    /// The set as others see it.
    fn describe(&mut self, orders: &[Vec<u32>; 2]) {
        let kinds = [LightKind::Direct, LightKind::Indirect];
        for (group, kind) in kinds.into_iter().enumerate() {
            let start = self.groups[group].start;
            for i in start..start + orders[group].len() {
                self.set.lights.push(Light {
                    direction: Vec3::from([0, 1, 2].map(|c| self.direction[c][i])),
                    power: [0, 1, 2].map(|c| f64::from(self.power[c][i])),
                    kind,
                    extent_rad: self.reach[i].asin(),
                });
            }
        }
        self.set.found = vec![
            ("direct_lights", orders[0].len() as f64),
            ("indirect_lights", orders[1].len() as f64),
        ];
    }

    /// The texel of a light that `u` in [0, 1) falls into, and its probability.
    pub fn texel(&self, light: usize, u: f32) -> (u32, f32) {
        let range = self.first[light] as usize..self.first[light + 1] as usize;
        let running = &self.running[range.clone()];
        let index = running.partition_point(|&sum| sum <= u);
        let index = index.min(running.len() - 1);
        let before = if index == 0 { 0.0 } else { running[index - 1] };
        (self.texels[range.start + index], running[index] - before)
    }

    /// A direction of a light and its density: a texel by `u`, a point in it by `v`, all in [0, 1).
    pub fn sample(&self, map: &Environment, light: usize, u: f32, v: [f32; 2]) -> TexelSample {
        let (texel, share) = self.texel(light, u);
        let (x, y) = (texel as usize % map.width(), texel as usize / map.width());
        TexelSample {
            direction: map.within_texel(x, y, v.map(f64::from)),
            pdf_sr: share / map.texel_solid_angle(y) as f32,
        }
    }
}

/// The light of every texel, the number of emissive lights, and that of all lights.
fn labels(texels: &Texels, count: usize, seed: u64) -> (Vec<u32>, usize, usize) {
    let classes = Classification::new(texels, &RULE);
    let wanted = classes.split(count, None);
    let steps = Steps {
        masking_rad: MASKING * 4.0 * std::f64::consts::PI / count.max(1) as f64,
        k_means: false,
        exclusion_rad: std::f64::consts::PI,
    };
    let found = directs(texels, &classes.emissive, (wanted, seed), &steps);
    let direct = found.labels.iter().max().map_or(0, |&l| l as usize + 1);
    let mut masked = vec![false; texels.luminance.len()];
    if direct > 0 {
        for &texel in &classes.emissive {
            masked[texel as usize] = true;
        }
    }
    let mut rest = leaves(texels, LEAVES, (&masked, classes.origin));
    let runs = cut(&mut rest, count.saturating_sub(direct), WEIGHTS);
    let (mut labels, cells) = cells_of_texels(texels, LEAVES, classes.origin);
    let mut of_cell = vec![NONE; cells];
    for (index, run) in runs.iter().enumerate() {
        for leaf in &rest[run.clone()] {
            of_cell[leaf.cell as usize] = (direct + index) as u32;
        }
    }
    for (label, &luminance) in labels.iter_mut().zip(&texels.luminance) {
        *label = match luminance > 0.0 {
            true => of_cell[*label as usize],
            false => NONE,
        };
    }
    if direct > 0 {
        for (&texel, &label) in classes.emissive.iter().zip(&found.labels) {
            labels[texel as usize] = label;
        }
    }
    (labels, direct, direct + runs.len())
}

/// Orders items so that neighbours in the list are neighbours on the sphere.
fn k_d_order(items: &mut [u32], directions: &[DVec3]) {
    if items.len() < 2 {
        return;
    }
    let (mut low, mut high) = (DVec3::splat(2.0), DVec3::splat(-2.0));
    for &item in items.iter() {
        low = low.min(directions[item as usize]);
        high = high.max(directions[item as usize]);
    }
    let axis = (high - low).max_position();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |&a, &b| {
        let key = |i: u32| directions[i as usize][axis];
        key(a).total_cmp(&key(b)).then(a.cmp(&b))
    });
    let (lower, upper) = items.split_at_mut(middle);
    k_d_order(lower, directions);
    k_d_order(upper, directions);
}

/// The mean of the bilinear lookup over every texel: ¾ of it and ⅛ of each neighbour, along both axes.
fn lookup_means(map: &Environment) -> Vec<[f32; 3]> {
    let (width, height) = (map.width(), map.height());
    let mut means = vec![[0.0f32; 3]; width * height];
    means
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            let y = y as isize;
            let column = |x: isize| -> Vec3 {
                let at = |y: isize| Vec3::from(map.wrapped(x, y));
                0.75 * at(y) + 0.125 * (at(y - 1) + at(y + 1))
            };
            let mut before = column(-1);
            let mut here = column(0);
            for (x, mean) in row.iter_mut().enumerate() {
                let after = column(x as isize + 1);
                *mean = (0.75 * here + 0.125 * (before + after)).into();
                (before, here) = (here, after);
            }
        });
    means
}

#[cfg(test)]
#[path = "texel_lights_tests.rs"]
mod tests;
