//! A map as a few thousand cells of equal solid angle with exact sums.

use std::ops::Range;

use glam::{DMat3, DVec3};

use super::rings::Rings;
use super::texels::{Cluster, Texels};

/// A cell with at least one texel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Leaf {
    pub sums: Cluster,
    /// Number of the cell, as in [`cells_of_texels`].
    pub cell: u32,
    /// Σ solid angle of its texels.
    pub solid_angle_sr: f64,
    /// Unit: the centroid of its texels' solid angle.
    pub direction: DVec3,
    /// The same in a space that turns with the map.
    pub turned: DVec3,
}

impl Leaf {
    /// Mean luminance.
    pub fn luminance(&self) -> f64 {
        self.sums.energy / self.solid_angle_sr
    }
}

/// Gathers the texels that are not `masked` (these are as if they were not there) into about `count`
/// cells, which begin at the column `origin`; cells without texels are dropped.
pub(super) fn leaves(texels: &Texels, count: usize, masked: &[bool], origin: usize) -> Vec<Leaf> {
    let rings = Rings::new(count);
    let mut leaves = vec![Leaf::default(); rings.len()];
    let width = texels.width();
    let columns = Columns::new(texels);
    for_each_run(texels, &rings, origin, &mut |y, cell, run| {
        leaves[cell].cell = cell as u32;
        let masks = &masked[y * width..(y + 1) * width];
        let mut start = run.start;
        for x in run.clone() {
            if masks[x] {
                add_run(texels, &columns, y, start..x, &mut leaves[cell]);
                start = x + 1;
            }
        }
        add_run(texels, &columns, y, start..run.end, &mut leaves[cell]);
    });
    let phi = std::f64::consts::TAU * origin as f64 / width as f64;
    // φ runs from −z over +x: clockwise about +y.
    let turn_back = DMat3::from_rotation_y(phi);
    leaves.retain(|leaf| leaf.solid_angle_sr > 0.0);
    for leaf in &mut leaves {
        leaf.direction = leaf.direction.normalize_or(DVec3::Y);
        leaf.turned = turn_back * leaf.direction;
    }
    leaves
}

/// The cell of every texel, and the number of cells, when there are about `count` of them.
pub(super) fn cells_of_texels(texels: &Texels, count: usize, origin: usize) -> (Vec<u32>, usize) {
    let rings = Rings::new(count);
    let width = texels.width();
    let mut cells = vec![0; texels.luminance.len()];
    for_each_run(texels, &rings, origin, &mut |y, cell, run| {
        cells[y * width + run.start..y * width + run.end].fill(cell as u32);
    });
    (cells, rings.len())
}

/// Calls `visit` with the row, the cell and the columns of every run of texels whose centres lie in
/// one cell.
fn for_each_run(
    texels: &Texels,
    rings: &Rings,
    origin: usize,
    visit: &mut dyn FnMut(usize, usize, Range<usize>),
) {
    let width = texels.width();
    for y in 0..texels.height() {
        let ring = rings.ring(texels.rows[y].cos);
        let cells = ring.len();
        let mut start = 0;
        for (piece, cell) in ring.enumerate() {
            let end = (((piece + 1) * width) as f64 / cells as f64 - 0.5).ceil() as usize;
            let run = start + origin..end.min(width) + origin;
            start = end.min(width);
            // Columns beyond the seam continue at the first one.
            let seam = width.clamp(run.start, run.end);
            let beyond = run.start.max(width)..run.end.max(width);
            for run in [
                run.start.min(width)..seam.min(width),
                beyond.start - width..beyond.end - width,
            ] {
                visit(y, cell, run);
            }
        }
    }
}

/// Running sums of (sin φ, cos φ) over the columns before each.
struct Columns(Vec<[f64; 2]>);

impl Columns {
    fn new(texels: &Texels) -> Self {
        let mut sums = vec![[0.0; 2]];
        let mut sum = [0.0; 2];
        for [sin, cos] in &texels.columns {
            sum = [sum[0] + sin, sum[1] + cos];
            sums.push(sum);
        }
        Self(sums)
    }

    /// Over the columns of a run.
    fn sum(&self, run: &Range<usize>) -> [f64; 2] {
        let (before, after) = (self.0[run.start], self.0[run.end]);
        [after[0] - before[0], after[1] - before[1]]
    }
}

/// Adds texels of one row, a run of its columns.
fn add_run(texels: &Texels, columns: &Columns, y: usize, run: Range<usize>, leaf: &mut Leaf) {
    if run.is_empty() {
        return;
    }
    let row = &texels.rows[y];
    let first = y * texels.width();
    let pixels = &texels.pixels[first + run.start..first + run.end];
    let luminances = &texels.luminance[first + run.start..first + run.end];
    let directions = &texels.columns[run.clone()];
    let mut sums = [[0.0f64; 6]; 2];
    let value = |rgb: &[f32; 3], luminance: f32, [sin, cos]: [f64; 2]| {
        let [r, g, b] = rgb.map(f64::from);
        let y = f64::from(luminance);
        [r, g, b, y, y * sin, y * cos]
    };
    let mut add = |lane: usize, terms: [f64; 6]| (0..6).for_each(|i| sums[lane][i] += terms[i]);
    // Two lanes: a sum waits for the one before it.
    let pairs = pixels.chunks_exact(2).zip(luminances.chunks_exact(2));
    for ((rgb, y), d) in pairs.zip(directions.chunks_exact(2)) {
        add(0, value(&rgb[0], y[0], d[0]));
        add(1, value(&rgb[1], y[1], d[1]));
    }
    if run.len() % 2 == 1 {
        let last = run.len() - 1;
        add(0, value(&pixels[last], luminances[last], directions[last]));
    }
    let [r, g, b, energy, by_sin, by_cos] = std::array::from_fn(|i| sums[0][i] + sums[1][i]);
    for (offset, &luminance) in luminances.iter().enumerate() {
        if luminance > leaf.sums.brightest.0 {
            leaf.sums.brightest = (luminance, (first + run.start + offset) as u32);
        }
    }
    let angle = row.solid_angle;
    let count = run.len() as f64;
    let [plain_sin, plain_cos] = columns.sum(&run);
    leaf.sums.power += DVec3::new(r, g, b) * angle;
    leaf.sums.energy += energy * angle;
    leaf.sums.moment += DVec3::new(by_sin * row.sin, energy * row.cos, -by_cos * row.sin) * angle;
    leaf.direction +=
        DVec3::new(plain_sin * row.sin, count * row.cos, -plain_cos * row.sin) * angle;
    leaf.solid_angle_sr += count * angle;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::{Environment, EnvironmentOptions};
    use crate::image::Image;

    #[test]
    fn every_texel_is_in_one_leaf_unless_masked() {
        for (width, height) in [(128, 64), (1, 1), (3, 2), (1, 9), (40, 1), (7, 300)] {
            let mut image = Image::new(width, height);
            for (i, pixel) in image.pixels.iter_mut().enumerate() {
                *pixel = [i as f32, 1.0, (i % 7) as f32];
            }
            let map = Environment::from_image(&image, &EnvironmentOptions::default()).expect("map");
            let texels = Texels::new(&map);
            for masked in [0, 3] {
                let mask = |i: usize| masked > 0 && i % masked == 1;
                let masks: Vec<bool> = (0..width * height).map(mask).collect();
                let found = leaves(&texels, 500, &masks, width / 3);
                let mut expected = Cluster::default();
                (0..width * height)
                    .filter(|i| !mask(*i))
                    .for_each(|i| expected.add(&texels, i));
                let mut sum = Cluster::default();
                found.iter().for_each(|leaf| sum.merge(&leaf.sums));
                let scale = expected.power.length();
                assert!((sum.power - expected.power).length() < 1e-9 * scale);
                assert!((sum.moment - expected.moment).length() < 1e-9 * scale);
                assert_eq!(sum.brightest, expected.brightest);
            }
        }
    }
}
