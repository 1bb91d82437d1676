//! Which texels of a map are emissive (Wu 2024, section 3.2, eq. 1), and the split of the budget
//! (eq. 2).

use super::texels::Texels;

/// The thresholds of eq. 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rule {
    /// λ: factor on the average luminance.
    pub average_factor: f64,
    /// γ: factor on the largest luminance.
    pub maximum_factor: f64,
    /// Share of the map that L_b exceeds.
    pub quantile: f64,
    /// Counts texels for quantile and average; otherwise they weigh as their solid angle.
    pub count_texels: bool,
}

/// Energy and solid angle of a region.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Region {
    /// Σ luminance · solid angle.
    pub energy: f64,
    pub solid_angle_sr: f64,
}

impl Region {
    /// Γ = L Δω^¼ (eq. 2); the solid angle counts at most `clamp_sr`.
    fn importance(&self, clamp_sr: Option<f64>) -> f64 {
        let solid_angle = self
            .solid_angle_sr
            .min(clamp_sr.unwrap_or(f64::INFINITY))
            .max(0.0);
        self.energy * solid_angle.powf(0.25)
    }
}

/// A map taken apart.
#[derive(Clone, Debug, Default)]
pub(super) struct Classification {
    /// L_T: texels above are emissive.
    pub threshold: f64,
    /// Emissive texels row by row, each row from the column `origin` on and around, so that the order
    /// turns with the map.
    pub emissive: Vec<u32>,
    /// Column of the first of the brightest texels.
    pub origin: usize,
    pub direct: Region,
    pub indirect: Region,
}

impl Classification {
    /// Takes a map apart: one pass over its texels, and one over the luminances.
    pub fn new(texels: &Texels, rule: &Rule) -> Self {
        let weight = |row: usize| match rule.count_texels {
            true => 1.0,
            false => texels.rows[row].solid_angle,
        };
        let width = texels.width();
        let (mut sum, mut weights) = (0.0, 0.0);
        // Sum and maximum of each row.
        let lines: Vec<(f64, f32)> = texels
            .luminance
            .chunks_exact(width)
            .map(|row| {
                let sum = row.iter().map(|&l| f64::from(l)).sum();
                (sum, row.iter().copied().fold(0.0, f32::max))
            })
            .collect();
        for (y, (line, _)) in lines.iter().enumerate() {
            sum += line * weight(y);
            weights += width as f64 * weight(y);
        }
        let maximum = lines.iter().map(|l| l.1).fold(0.0, f32::max);
        let quantile = weighted_quantile(texels, rule.quantile, &weight);
        let threshold = f64::from(quantile)
            .max(rule.average_factor * sum / weights)
            .max(rule.maximum_factor * f64::from(maximum));
        let mut emissive = Vec::new();
        let (mut direct, mut indirect) = (Region::default(), Region::default());
        for (y, &(total, largest)) in lines.iter().enumerate() {
            let before = emissive.len();
            let mut bright = 0.0;
            if f64::from(largest) > threshold {
                let row = &texels.luminance[y * width..(y + 1) * width];
                for (x, &l) in row.iter().enumerate() {
                    if f64::from(l) > threshold {
                        emissive.push((y * width + x) as u32);
                        bright += f64::from(l);
                    }
                }
            }
            let (count, angle) = (emissive.len() - before, texels.rows[y].solid_angle);
            direct.energy += bright * angle;
            direct.solid_angle_sr += count as f64 * angle;
            indirect.energy += (total - bright).max(0.0) * angle;
            indirect.solid_angle_sr += (width - count) as f64 * angle;
        }
        let brightest = lines.iter().position(|l| l.1 == maximum).unwrap_or(0);
        let row = &texels.luminance[brightest * width..(brightest + 1) * width];
        let origin = row.iter().position(|&l| l == maximum).unwrap_or(0);
        emissive.sort_by_key(|&texel| {
            let (x, y) = (texel as usize % width, texel as usize / width);
            (y, (x + width - origin) % width)
        });
        if emissive.len() == width * texels.height() {
            indirect = Region::default();
        }
        Self {
            threshold,
            emissive,
            origin,
            direct,
            indirect,
        }
    }

    /// Γ_em / (Γ_em + Γ_nem), in [0, 1]; 0 for a black map.
    pub fn direct_share(&self, clamp_sr: Option<f64>) -> f64 {
        let direct = self.direct.importance(clamp_sr);
        let total = direct + self.indirect.importance(clamp_sr);
        if total > 0.0 { direct / total } else { 0.0 }
    }

    /// N of `count` lights for the emissive texels: rounded to nearest, and both parts get a light
    /// when they have energy. A single light then stands for the whole map: N = 0.
    pub fn split(&self, count: usize, clamp_sr: Option<f64>) -> usize {
        let share = self.direct_share(clamp_sr);
        let wanted = (count as f64 * share).round() as usize;
        match (self.direct.energy > 0.0, self.indirect.energy > 0.0) {
            (false, _) => 0,
            (true, false) => count,
            (true, true) if count < 2 => 0,
            (true, true) => wanted.clamp(1, count - 1),
        }
    }
}

/// The smallest luminance that at least `share` of the weight does not exceed. Exact: two passes of
/// counting over the upper and the lower bits, which order non-negative floats.
fn weighted_quantile(texels: &Texels, share: f64, weight: &dyn Fn(usize) -> f64) -> f32 {
    const LOW_BITS: u32 = 17;
    let mut upper = vec![0.0f64; 1 << (31 - LOW_BITS)];
    for (y, row) in texels.luminance.chunks_exact(texels.width()).enumerate() {
        let weight = weight(y);
        for luminance in row {
            upper[(luminance.to_bits() >> LOW_BITS) as usize] += weight;
        }
    }
    let target = share * upper.iter().sum::<f64>();
    let (high, below) = reach(&upper, target, 0.0);
    let mut lower = vec![0.0f64; 1 << LOW_BITS];
    for (y, row) in texels.luminance.chunks_exact(texels.width()).enumerate() {
        let weight = weight(y);
        for luminance in row {
            let bits = luminance.to_bits();
            if bits >> LOW_BITS == high as u32 {
                lower[(bits & ((1 << LOW_BITS) - 1)) as usize] += weight;
            }
        }
    }
    let (low, _) = reach(&lower, target, below);
    f32::from_bits((high as u32) << LOW_BITS | low as u32)
}

/// The first bin at which the running sum from `sum` reaches `target`, and the sum before it; the
/// last bin that holds anything when rounding keeps the sum below.
fn reach(bins: &[f64], target: f64, mut sum: f64) -> (usize, f64) {
    let mut last = (0, sum);
    for (index, &bin) in bins.iter().enumerate().filter(|(_, b)| **b > 0.0) {
        last = (index, sum);
        if sum + bin >= target {
            break;
        }
        sum += bin;
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::{Environment, EnvironmentOptions};
    use crate::image::Image;

    const RULE: Rule = Rule {
        average_factor: 3.0,
        maximum_factor: 0.001,
        quantile: 0.98,
        count_texels: false,
    };

    fn environment(values: impl Fn(usize, usize) -> f32) -> Environment {
        let mut image = Image::new(64, 32);
        for (i, pixel) in image.pixels.iter_mut().enumerate() {
            *pixel = [values(i % 64, i / 64); 3];
        }
        Environment::from_image(&image, &EnvironmentOptions::default()).expect("map")
    }

    #[test]
    fn quantiles_are_those_of_sorting() {
        let map = environment(|x, y| ((x * 37 + y * 101) % 977) as f32 * 0.013);
        let texels = Texels::new(&map);
        for (by_angle, share) in [(true, 0.98), (false, 0.98), (true, 0.5), (false, 0.013)] {
            let weight = |row: usize| {
                if by_angle {
                    texels.rows[row].solid_angle
                } else {
                    1.0
                }
            };
            let mut sorted: Vec<(f32, f64)> = (0..64 * 32)
                .map(|i| (texels.luminance[i], weight(i / 64)))
                .collect();
            sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
            let total: f64 = sorted.iter().map(|s| s.1).sum();
            let mut sum = 0.0;
            let expected = sorted.iter().find(|(_, w)| {
                sum += w;
                sum >= share * total
            });
            let found = weighted_quantile(&texels, share, &weight);
            assert_eq!(Some(found), expected.map(|e| e.0), "{by_angle} {share}");
        }
    }

    #[test]
    fn a_sun_is_emissive_and_a_constant_is_not() {
        let constant = environment(|_, _| 2.0);
        let classes = Classification::new(&Texels::new(&constant), &RULE);
        assert!(classes.emissive.is_empty());
        assert!((classes.threshold - 6.0).abs() < 1e-5);
        assert_eq!(classes.split(16, None), 0);

        let sun = environment(|x, y| if (x, y) == (20, 0) { 1e5 } else { 1.0 });
        let classes = Classification::new(&Texels::new(&sun), &RULE);
        assert_eq!(classes.emissive, [20]);
        // γ · L_max = 100 decides.
        assert!((classes.threshold - 100.0).abs() < 1e-3);
        let total = classes.direct.energy + classes.indirect.energy;
        let texels = Texels::new(&sun);
        let energy: f64 = (0..64 * 32).map(|i| texels.energy(i)).sum();
        assert!((total / energy - 1.0).abs() < 1e-12);
        let n = classes.split(16, None);
        assert!((1..16).contains(&n));
        // Clamping both regions to the same solid angle splits by energy alone.
        let energy_share = classes.direct.energy / total;
        assert!((classes.direct_share(Some(1e-9)) - energy_share).abs() < 1e-12);
    }

    #[test]
    fn a_black_map_has_no_emissive_texels() {
        let black = environment(|_, _| 0.0);
        let classes = Classification::new(&Texels::new(&black), &RULE);
        assert!(classes.emissive.is_empty());
        assert_eq!(classes.direct_share(None), 0.0);
        assert_eq!(classes.split(8, None), 0);
    }

    #[test]
    fn one_bright_texel_on_black_is_all_direct() {
        let spot = environment(|x, y| if (x, y) == (63, 0) { 5.0 } else { 0.0 });
        let classes = Classification::new(&Texels::new(&spot), &RULE);
        assert_eq!(classes.emissive, [63]);
        assert_eq!(classes.split(8, None), 8);
    }
}
