//! Variance minimisation (Viriyothai & Debevec 2009): median cut with cuts that make the larger of
//! both parts' variances as small as possible.

use super::regions::{Cutting, Region, cut_regions};
use super::texels::Texels;
use super::{Environment, EnvironmentSampler, LightSampler, LightSet};
use crate::entry::{About, Bias, check_keys};
use crate::environment::SamplerEntry;

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "variance-minimization",
        module: crate::entry::head_comment!("variance_minimization.rs"),
        aliases: &["vm"],
        summary: "rectangles cut where the larger variance of both parts is least",
        source: "Viriyothai & Debevec 2009",
        bias: Bias::Consistent,
        version: 2,
        failures: &[
            "distances are texels, so that variance near the poles counts too much",
            "rectangles end at the seam of the map",
        ],
        parameters: &[],
    },
    build: |table| {
        check_keys(table, &[])?;
        Ok(EnvironmentSampler::Lights(Box::new(VarianceMinimization)))
    },
};

struct VarianceMinimization;

/// *differs:* counts between powers of two cut the regions of most energy in the last pass; the
/// light's direction is the centroid on the sphere.
impl LightSampler for VarianceMinimization {
    fn lights(&self, map: &Environment, count: usize, _seed: u64) -> LightSet {
        let texels = Texels::new(map);
        cut_regions(&texels, count, self).turned(map.to_world())
    }
}

/// Weight, mean position and sum of squared distances from it, of a set of points on a line or (the
/// last two as sums over both axes) in the plane.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    weight: f64,
    first: [f64; 2],
    second: f64,
}

impl Moments {
    fn add(&mut self, other: &Self) {
        self.weight += other.weight;
        self.first[0] += other.first[0];
        self.first[1] += other.first[1];
        self.second += other.second;
    }

    fn without(&self, other: &Self) -> Self {
        Self {
            weight: self.weight - other.weight,
            first: [
                self.first[0] - other.first[0],
                self.first[1] - other.first[1],
            ],
            second: self.second - other.second,
        }
    }

    /// Σ E d² about the centroid; 0 without weight.
    fn variance(&self) -> f64 {
        if self.weight <= 0.0 {
            return 0.0;
        }
        let [x, y] = self.first;
        (self.second - (x * x + y * y) / self.weight).max(0.0)
    }
}

/// Moments of the columns and of the rows of a region, about its middle.
fn line_moments(texels: &Texels, region: &Region) -> [Vec<Moments>; 2] {
    let mut columns = vec![Moments::default(); region.x.len()];
    let mut rows = vec![Moments::default(); region.y.len()];
    let middle = [region.x.len() as f64 * 0.5, region.y.len() as f64 * 0.5];
    for ((y, row), line) in region.y.clone().zip(&mut rows).zip(0..) {
        let angle = texels.rows[y].solid_angle;
        let dy = f64::from(line) + 0.5 - middle[1];
        let values = &texels.luminance[y * texels.width()..][region.x.clone()];
        for ((column, &value), line) in columns.iter_mut().zip(values).zip(0..) {
            let dx = f64::from(line) + 0.5 - middle[0];
            let weight = f64::from(value) * angle;
            let moments = Moments {
                weight,
                first: [weight * dx, weight * dy],
                second: weight * (dx * dx + dy * dy),
            };
            column.add(&moments);
            row.add(&moments);
        }
    }
    [columns, rows]
}

impl Cutting for VarianceMinimization {
    fn cut(&self, texels: &Texels, region: &Region) -> Option<[Region; 2]> {
        let lines = line_moments(texels, region);
        let mut total = Moments::default();
        lines[1].iter().for_each(|m| total.add(m));
        let longer = usize::from(region.y.len() > region.x.len());
        if total.weight <= 0.0 {
            let length = region.x.len().max(region.y.len());
            return (length > 1).then(|| region.halves(longer == 0, length / 2));
        }
        // Cuts that are equally good to rounding: the most central one, of the longer side first.
        let tolerance = 1e-12 * total.second;
        let mut best: Option<(f64, [usize; 2], (usize, usize))> = None;
        for (axis, line) in lines.iter().enumerate() {
            let mut below = Moments::default();
            let length = line.len();
            for cut in 1..length {
                below.add(&line[cut - 1]);
                let worse = below.variance().max(total.without(&below).variance());
                let rank = [usize::from(axis != longer), (2 * cut).abs_diff(length)];
                let better = best.is_none_or(|(least, other, _)| {
                    worse < least - tolerance || worse <= least + tolerance && rank < other
                });
                if better {
                    best = Some((worse, rank, (axis, cut)));
                }
            }
        }
        best.map(|(_, _, (axis, cut))| region.halves(axis == 0, cut))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::EnvironmentOptions;
    use crate::image::Image;

    fn cut(width: usize, height: usize, lit: &[(usize, usize)]) -> [Region; 2] {
        let mut image = Image::new(width, height);
        for &(x, y) in lit {
            image.pixels[y * width + x] = [1.0; 3];
        }
        let map = Environment::from_image(&image, &EnvironmentOptions::default()).expect("map");
        let whole = Region {
            x: 0..width,
            y: 0..height,
        };
        VarianceMinimization
            .cut(&Texels::new(&map), &whole)
            .expect("more than one texel")
    }

    #[test]
    fn cuts_go_between_two_lights() {
        let [a, b] = cut(32, 16, &[(4, 8), (5, 8), (25, 8), (26, 8)]);
        assert_eq!((a.x.start, b.x.end, a.y.len()), (0, 32, 16));
        assert!((6..=25).contains(&b.x.start), "{b:?}");
        let [a, b] = cut(16, 32, &[(8, 3), (8, 28)]);
        assert_eq!(a.x, 0..16);
        assert!((4..=28).contains(&b.y.start), "{b:?}");
    }

    #[test]
    fn ties_are_cut_in_the_middle() {
        let [a, b] = cut(32, 16, &[(9, 3)]);
        assert_eq!((a.x, b.x), (0..16, 16..32));
        let [a, b] = cut(8, 64, &[]);
        assert_eq!((a.y, b.y), (0..32, 32..64));
    }
}
