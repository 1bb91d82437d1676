//! Recursive cutting of a map into rectangles: what median cut and variance minimisation share.

use std::ops::Range;

use super::LightSet;
use super::texels::{Texels, lights_of_partition};

/// A rectangle of texels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Region {
    pub x: Range<usize>,
    pub y: Range<usize>,
}

impl Region {
    /// Energy (luminance · solid angle) of its columns, or of its rows.
    pub fn energies(&self, texels: &Texels, of_columns: bool) -> Vec<f64> {
        let mut columns = vec![0.0; self.x.len()];
        let mut rows = vec![0.0; self.y.len()];
        for (y, sum) in self.y.clone().zip(&mut rows) {
            let angle = texels.rows[y].solid_angle;
            let line = &texels.luminance[y * texels.width()..][self.x.clone()];
            if of_columns {
                for (column, &value) in columns.iter_mut().zip(line) {
                    *column += f64::from(value) * angle;
                }
            } else {
                *sum = line.iter().map(|&value| f64::from(value)).sum::<f64>() * angle;
            }
        }
        if of_columns { columns } else { rows }
    }

    pub fn energy(&self, texels: &Texels) -> f64 {
        self.energies(texels, false).iter().sum()
    }

    /// The parts before and from the `position`-th column (or row) on.
    pub fn halves(&self, along_x: bool, position: usize) -> [Self; 2] {
        let (mut a, mut b) = (self.clone(), self.clone());
        if along_x {
            a.x.end = self.x.start + position;
            b.x.start = a.x.end;
        } else {
            a.y.end = self.y.start + position;
            b.y.start = a.y.end;
        }
        [a, b]
    }
}

/// Where to cut a region.
pub(super) trait Cutting {
    /// Two parts that are not empty; `None` for a single texel.
    fn cut(&self, texels: &Texels, region: &Region) -> Option<[Region; 2]>;
}

/// Halves the regions of a map, all of them in each pass and those of most energy in the last one if
/// `count` is not a power of two, and makes one light of each.
pub(super) fn cut_regions(texels: &Texels, count: usize, cutting: &dyn Cutting) -> LightSet {
    if count == 0 {
        return LightSet::default();
    }
    let mut regions = vec![Region {
        x: 0..texels.width(),
        y: 0..texels.height(),
    }];
    while regions.len() < count {
        let room = count - regions.len();
        let mut order: Vec<(usize, f64)> = regions
            .iter()
            .map(|r| r.energy(texels))
            .enumerate()
            .collect();
        order.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut chosen = vec![false; regions.len()];
        let mut left = room;
        for (index, _) in order {
            let single = regions[index].x.len() * regions[index].y.len() < 2;
            chosen[index] = left > 0 && !single;
            left -= usize::from(chosen[index]);
        }
        let before = regions.len();
        regions = regions
            .into_iter()
            .zip(chosen)
            .flat_map(|(region, chosen)| {
                match chosen.then(|| cutting.cut(texels, &region)).flatten() {
                    Some(halves) => halves.to_vec(),
                    None => vec![region],
                }
            })
            .collect();
        if regions.len() == before {
            break;
        }
    }
    let width = texels.width();
    LightSet {
        lights: lights_of_partition(texels, regions.len(), &|visit| {
            for (index, region) in regions.iter().enumerate() {
                for y in region.y.clone() {
                    region.x.clone().for_each(|x| visit(y * width + x, index));
                }
            }
        }),
        ..LightSet::default()
    }
}
