//! Segmentation of a tone-mapped map by mean shift over direction and tone (Comaniciu & Meer 2002).

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::blocks::Blocks;

/// Bandwidths: radians of direction and units of tone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bandwidth {
    pub angle_rad: f64,
    pub tone: f64,
}

const MOST_STEPS: usize = 20;
/// Steps shorter than this share of the bandwidth end the search for a mode.
const TOLERANCE: f64 = 1e-3;

/// A point in the joint space.
#[derive(Clone, Copy, Debug)]
struct Feature {
    direction: DVec3,
    tone: f64,
}

/// Blocks as features in a grid.
pub(super) struct Segmentation<'a> {
    blocks: &'a Blocks,
    features: Vec<Feature>,
    /// Polar angles of the rows' centres.
    thetas: Vec<f64>,
    bandwidth: Bandwidth,
}

impl<'a> Segmentation<'a> {
    /// `tones` and `directions` (of the blocks' centres) are parallel to the blocks.
    pub fn new(
        blocks: &'a Blocks,
        directions: &[DVec3],
        tones: &[f64],
        bandwidth: Bandwidth,
    ) -> Self {
        let features = directions
            .iter()
            .zip(tones)
            .map(|(&direction, &tone)| Feature { direction, tone })
            .collect();
        let theta = |row: usize| {
            let first = directions[row * blocks.width];
            first.x.hypot(first.z).atan2(first.y)
        };
        Self {
            blocks,
            features,
            thetas: (0..blocks.height).map(theta).collect(),
            bandwidth,
        }
    }

    /// A label for every block: neighbours whose modes lie within half the bandwidth of each other
    /// share one. Labels count from 0 in the order of the blocks.
    pub fn labels(&self) -> Vec<u32> {
        let modes: Vec<Feature> = (0..self.features.len())
            .into_par_iter()
            .map(|index| self.mode(index))
            .collect();
        let mut parents: Vec<u32> = (0..modes.len() as u32).collect();
        let pairs: Vec<(usize, usize)> =
            neighbours(self.blocks.width, self.blocks.height).collect();
        let pairs = pairs.into_par_iter().with_min_len(1024);
        let alike = pairs.filter(|&(a, b)| self.distance2(&modes[a], &modes[b]) <= 0.25);
        for (a, b) in alike.collect::<Vec<_>>() {
            let (a, b) = (root(&mut parents, a as u32), root(&mut parents, b as u32));
            parents[a.max(b) as usize] = a.min(b);
        }
        let mut labels = vec![u32::MAX; modes.len()];
        let mut count = 0;
        for index in 0..modes.len() {
            let top = root(&mut parents, index as u32) as usize;
            if labels[top] == u32::MAX {
                labels[top] = count;
                count += 1;
            }
            labels[index] = labels[top];
        }
        labels
    }

    fn distance2(&self, a: &Feature, b: &Feature) -> f64 {
        let angle = (a.direction - b.direction).length() / self.bandwidth.angle_rad;
        let tone = (a.tone - b.tone) / self.bandwidth.tone;
        angle * angle + tone * tone
    }

    /// Follows the mean of the unit ball, blocks weighing as their solid angle.
    fn mode(&self, index: usize) -> Feature {
        let mut at = self.features[index];
        for _ in 0..MOST_STEPS {
            let (mut direction, mut tone, mut weight) = (DVec3::ZERO, 0.0, 0.0);
            self.visit(at.direction, |other| {
                if self.distance2(&at, &self.features[other]) <= 1.0 {
                    let w = self.blocks.solid_angles_sr[other];
                    direction += self.features[other].direction * w;
                    tone += self.features[other].tone * w;
                    weight += w;
                }
            });
            let Some(direction) = direction.try_normalize() else {
                break;
            };
            let next = Feature {
                direction,
                tone: tone / weight,
            };
            let step = self.distance2(&at, &next);
            at = next;
            if step < TOLERANCE * TOLERANCE {
                break;
            }
        }
        at
    }

    /// Calls with every block whose centre may lie within the bandwidth of a direction.
    fn visit(&self, direction: DVec3, mut call: impl FnMut(usize)) {
        let (width, reach) = (self.blocks.width, self.bandwidth.angle_rad * 1.01);
        let theta = direction.x.hypot(direction.z).atan2(direction.y);
        let phi = direction.x.atan2(-direction.z).rem_euclid(2.0 * PI);
        for (row, &other) in self.thetas.iter().enumerate() {
            if (other - theta).abs() > reach {
                continue;
            }
            let sines = theta.sin() * other.sin();
            let cos = (reach.cos() - theta.cos() * other.cos()) / sines;
            let half = if sines < 1e-9 || cos <= -1.0 {
                width as f64
            } else {
                cos.min(1.0).acos() / (2.0 * PI) * width as f64 + 1.0
            };
            let centre = phi / (2.0 * PI) * width as f64 - 0.5;
            let first = (centre - half).ceil() as i64;
            let last = ((centre + half).floor() as i64).min(first + width as i64 - 1);
            for column in first..=last {
                call(row * width + column.rem_euclid(width as i64) as usize);
            }
        }
    }
}

fn root(parents: &mut [u32], mut index: u32) -> u32 {
    while parents[index as usize] != index {
        parents[index as usize] = parents[parents[index as usize] as usize];
        index = parents[index as usize];
    }
    index
}

/// Pairs of adjacent blocks: in rows (around the seam), in columns, and across the poles.
pub(super) fn neighbours(width: usize, height: usize) -> impl Iterator<Item = (usize, usize)> {
    let in_rows = (0..width * height)
        .map(move |i| (i, i / width * width + (i % width + 1) % width))
        .filter(|(a, b)| a != b);
    let in_columns = (0..width * height.saturating_sub(1)).map(move |i| (i, i + width));
    let across = [0, height - 1].into_iter().flat_map(move |row| {
        (0..width / 2).map(move |x| (row * width + x, row * width + x + width / 2))
    });
    in_rows.chain(in_columns).chain(across)
}
