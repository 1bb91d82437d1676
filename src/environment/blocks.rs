//! Square blocks of texels with exact sums, for samplers whose cost grows with the number of texels.

use glam::DVec3;
use rayon::prelude::*;

use super::relaxation::Item;
use super::texels::{Cluster, Texels, angle_rad};
use super::{Light, LightKind, LightSet};

/// Most blocks of a sampler that assigns each once: every texel of a 512×256 map.
pub(super) const LARGEST: usize = 512 * 256;

/// Blocks in row-major order; those at the right and bottom may be smaller.
pub(super) struct Blocks {
    /// Texels along the side of a block.
    pub side: usize,
    /// Blocks in a row.
    pub width: usize,
    pub height: usize,
    pub sums: Vec<Cluster>,
    /// Σ solid angle.
    pub solid_angles_sr: Vec<f64>,
}

impl Blocks {
    /// The smallest blocks of which there are at most `most`.
    pub fn new(texels: &Texels, most: usize) -> Self {
        let count = |side: usize| texels.width().div_ceil(side) * texels.height().div_ceil(side);
        let side = (1..).find(|&side| count(side) <= most.max(1)).unwrap_or(1);
        let width = texels.width().div_ceil(side);
        let height = texels.height().div_ceil(side);
        let mut sums = vec![Cluster::default(); width * height];
        let mut solid_angles_sr = vec![0.0; width * height];
        let rows = sums
            .par_chunks_mut(width)
            .zip(solid_angles_sr.par_chunks_mut(width));
        rows.enumerate().for_each(|(row, (sums, solid_angles_sr))| {
            for y in row * side..((row + 1) * side).min(texels.height()) {
                for x in 0..texels.width() {
                    sums[x / side].add(texels, y * texels.width() + x);
                    solid_angles_sr[x / side] += texels.rows[y].solid_angle;
                }
            }
        });
        Self {
            side,
            width,
            height,
            sums,
            solid_angles_sr,
        }
    }

    /// Sums over the map.
    pub fn total(&self) -> Cluster {
        let mut total = Cluster::default();
        self.sums.iter().for_each(|sums| total.merge(sums));
        total
    }

    /// The blocks that are not black, and their energies.
    pub fn items(&self, texels: &Texels) -> (Vec<Item>, Vec<f64>) {
        self.sums
            .iter()
            .filter_map(|sums| {
                let item = Item {
                    direction: sums.direction(texels)?,
                    moment: sums.moment,
                };
                Some((item, sums.energy))
            })
            .unzip()
    }

    /// One light for each cell that is not black; `labels` are the cells of [`Blocks::items`]. In
    /// the map's space.
    pub fn light_set(&self, texels: &Texels, cells: usize, labels: &[u32]) -> LightSet {
        let clusters = self.clusters(cells, labels);
        let axes: Vec<_> = clusters.iter().map(|c| c.direction(texels)).collect();
        self.lights(texels, labels, &clusters, &axes)
    }

    /// As [`Blocks::light_set`], with the lights where the cells' centres are.
    pub fn light_set_at(&self, texels: &Texels, centres: &[DVec3], labels: &[u32]) -> LightSet {
        let clusters = self.clusters(centres.len(), labels);
        let pairs = clusters.iter().zip(centres);
        let axes: Vec<_> = pairs
            .map(|(c, centre)| (c.energy > 0.0).then_some(*centre))
            .collect();
        self.lights(texels, labels, &clusters, &axes)
    }

    /// The blocks that are not black, and their cells.
    fn lit<'l>(&'l self, labels: &'l [u32]) -> impl Iterator<Item = (&'l Cluster, usize)> {
        let lit = self.sums.iter().filter(|sums| sums.energy > 0.0);
        lit.zip(labels.iter().map(|&label| label as usize))
    }

    fn clusters(&self, cells: usize, labels: &[u32]) -> Vec<Cluster> {
        let mut clusters = vec![Cluster::default(); cells];
        for (sums, label) in self.lit(labels) {
            clusters[label].merge(sums);
        }
        clusters
    }

    fn lights(
        &self,
        texels: &Texels,
        labels: &[u32],
        clusters: &[Cluster],
        axes: &[Option<DVec3>],
    ) -> LightSet {
        let cells = clusters.len();
        let mut extents = vec![0.0f64; cells];
        for (sums, label) in self.lit(labels) {
            if let Some((axis, own)) = axes[label].zip(sums.direction(texels)) {
                let extent = &mut extents[label];
                *extent = extent.max(angle_rad(axis, own));
            }
        }
        let lights = (0..cells).filter_map(|cell| {
            Some(Light {
                direction: axes[cell]?.as_vec3(),
                power: clusters[cell].power.to_array(),
                kind: LightKind::Global,
                extent_rad: extents[cell] as f32,
            })
        });
        LightSet {
            lights: lights.collect(),
            ..LightSet::default()
        }
    }
}
