//! Fast hierarchical importance sampling (Ostromoukhov, Donohue & Jodoin 2004) on the map's plane: a
//! reconstruction, without the authors' table of corrections.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::blocks::{Blocks, LARGEST};
use super::penrose::{Candidate, Importance, points};
use super::relaxation::Cells;
use super::texels::Texels;
use super::{Environment, EnvironmentSampler, LightSampler, LightSet};
use crate::entry::{About, Bias, check_keys};
use crate::environment::SamplerEntry;

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "fhis",
        module: crate::entry::head_comment!("fhis.rs"),
        aliases: &["fhis-r"],
        summary: "points of a Penrose tiling thresholded against the importance of the map",
        source: "Ostromoukhov et al. 2004 (reconstruction: no table of corrections, sphere and powers ours)",
        bias: Bias::Consistent,
        version: 2,
        failures: &[
            "points ignore the seam and spread unevenly towards the poles",
            "a source smaller than the spacing of points attracts one beside it",
        ],
        parameters: &[],
    },
    build: |table| {
        check_keys(table, &[])?;
        Ok(EnvironmentSampler::Lights(Box::new(Fhis)))
    },
};

struct Fhis;

/// *differs:* points keep their places in the tiling; the importance is the luminance times the
/// cosine of the latitude on the plane of the map, cut open at the darkest column; the factor of the
/// importance is found by bisection, and surplus points of least importance are left out; a point's
/// power is that of its Voronoi cell.
impl LightSampler for Fhis {
    fn lights(&self, map: &Environment, count: usize, _seed: u64) -> LightSet {
        let texels = Texels::new(map);
        let blocks = Blocks::new(&texels, LARGEST);
        if count == 0 || blocks.total().energy <= 0.0 {
            return LightSet::default();
        }
        let mut plane = Plane::new(&texels);
        let samples = plane.samples(count);
        let centres: Vec<DVec3> = samples.iter().map(|&p| plane.direction(p)).collect();
        if centres.is_empty() {
            return LightSet {
                notes: vec!["no point of the tiling lies on a texel that shines".into()],
                ..LightSet::default()
            };
        }
        let (items, _) = blocks.items(&texels);
        let cells = Cells::new(&items, centres);
        blocks
            .light_set_at(&texels, &cells.centres, &cells.labels)
            .turned(map.to_world())
    }
}

/// Importance over a plane on which texels are squares of side 1.
struct Plane {
    width: usize,
    height: usize,
    /// Column at which the map is cut open.
    seam: usize,
    factor: f64,
    /// Luminance · sin θ in full and in maxima over ever larger squares: (columns, values).
    levels: Vec<(usize, Vec<f64>)>,
    /// Width of a texel over its height: 1 for maps twice as wide as high.
    stretch: f64,
}

impl Plane {
    fn new(texels: &Texels) -> Self {
        let (width, height) = (texels.width(), texels.height());
        let mut columns = vec![0.0; width];
        for index in 0..width * height {
            columns[index % width] += texels.energy(index);
        }
        let darkest = columns.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        let seam = darkest.map_or(0, |(column, _)| column);
        let total: f64 = columns.iter().sum();
        let values = (0..width * height)
            .map(|index| {
                let x = (index % width + seam) % width;
                let source = index / width * width + x;
                texels.energy(source) / total * (width * height) as f64
            })
            .collect();
        let mut plane = Self {
            width,
            height,
            seam,
            factor: 1.0,
            levels: vec![(width, values)],
            stretch: 2.0 * height as f64 / width as f64,
        };
        plane.build_maxima();
        plane
    }

    fn build_maxima(&mut self) {
        loop {
            let (columns, values) = &self.levels[self.levels.len() - 1];
            let rows = values.len() / columns;
            if *columns == 1 && rows == 1 {
                return;
            }
            let (next_columns, next_rows) = (columns.div_ceil(2), rows.div_ceil(2));
            let mut next = vec![0.0f64; next_columns * next_rows];
            for (index, &value) in values.iter().enumerate() {
                let (x, y) = (index % columns, index / columns);
                let largest = &mut next[y / 2 * next_columns + x / 2];
                *largest = largest.max(value);
            }
            self.levels.push((next_columns, next));
        }
    }

    /// Size of the plane: texel rows are the unit.
    fn size(&self) -> DVec2 {
        DVec2::new(self.width as f64 * self.stretch, self.height as f64)
    }

    /// At most `count` points, the fewest that are left out being those whose importance exceeds
    /// their threshold least.
    fn samples(&mut self, count: usize) -> Vec<DVec2> {
        let (mut low, mut high) = (0.0, 1.0);
        let mut chosen = self.at_factor(high);
        // 2^90 times the mean importance: nothing more is to be had.
        for _ in 0..90 {
            if chosen.len() >= count {
                break;
            }
            low = high;
            high *= 2.0;
            chosen = self.at_factor(high);
        }
        for _ in 0..40 {
            if chosen.len() <= count {
                break;
            }
            let middle = 0.5 * (low + high);
            let found = self.at_factor(middle);
            if found.len() >= count {
                high = middle;
                chosen = found;
            } else {
                low = middle;
            }
        }
        self.factor = high;
        let mut ranked: Vec<(f64, DVec2)> = chosen
            .iter()
            .map(|c| (self.at(c.position) / (c.threshold + 1.0), c.position))
            .collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        ranked.truncate(count);
        ranked.into_iter().map(|(_, position)| position).collect()
    }

    fn at_factor(&mut self, factor: f64) -> Vec<Candidate> {
        self.factor = factor;
        points(self.size(), self)
    }

    fn texel(&self, position: DVec2) -> [usize; 2] {
        let x = (position.x / self.stretch).max(0.0) as usize;
        let y = position.y.max(0.0) as usize;
        [x.min(self.width - 1), y.min(self.height - 1)]
    }

    /// Unit direction in the map's space.
    fn direction(&self, position: DVec2) -> DVec3 {
        let column = position.x / self.stretch + self.seam as f64;
        let (sin_phi, cos_phi) = (TAU * column / self.width as f64).sin_cos();
        let (sin, cos) = (PI * position.y / self.height as f64).sin_cos();
        DVec3::new(sin_phi * sin, cos, -cos_phi * sin)
    }
}

impl Importance for Plane {
    fn at(&self, position: DVec2) -> f64 {
        if position.cmplt(DVec2::ZERO).any() || position.cmpge(self.size()).any() {
            return 0.0;
        }
        let [x, y] = self.texel(position);
        self.factor * self.levels[0].1[y * self.width + x]
    }

    fn most_within(&self, low: DVec2, high: DVec2) -> f64 {
        let ([left, top], [right, bottom]) = (self.texel(low), self.texel(high));
        // Squares of which at most three along each side cover the rectangle.
        let extent = (right - left).max(bottom - top) + 1;
        let level = (extent.ilog2() as usize).min(self.levels.len() - 1);
        let (columns, values) = &self.levels[level];
        let mut most = 0.0f64;
        for y in top >> level..=bottom >> level {
            for x in left >> level..=right >> level {
                most = most.max(values[y * columns + x]);
            }
        }
        self.factor * most
    }
}
