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
        let lines: Vec<(f64, f32)> = texels
            .luminance
            .chunks_exact(width)
            .map(sum_and_largest)
            .collect();
        for (y, (line, _)) in lines.iter().enumerate() {
            sum += line * weight(y);
            weights += width as f64 * weight(y);
        }
        let maximum = lines.iter().map(|l| l.1).fold(0.0, f32::max);
        let brightest = lines.iter().position(|l| l.1 == maximum).unwrap_or(0);
        let row = &texels.luminance[brightest * width..(brightest + 1) * width];
        let origin = row.iter().position(|&l| l == maximum).unwrap_or(0);
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
            let from_origin =
                emissive[before..].partition_point(|&texel| (texel as usize) < y * width + origin);
            emissive[before..].rotate_left(from_origin);
            let (count, angle) = (emissive.len() - before, texels.rows[y].solid_angle);
            direct.energy += bright * angle;
            direct.solid_angle_sr += count as f64 * angle;
            indirect.energy += (total - bright).max(0.0) * angle;
            indirect.solid_angle_sr += (width - count) as f64 * angle;
        }
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

/// Sum and maximum of a row of luminances, in eight lanes.
fn sum_and_largest(row: &[f32]) -> (f64, f32) {
    const LANES: usize = 8;
    let (mut sums, mut largest) = ([0.0f64; LANES], [0.0f32; LANES]);
    let chunks = row.chunks_exact(LANES);
    let rest = chunks.remainder();
    for chunk in chunks {
        for lane in 0..LANES {
            sums[lane] += f64::from(chunk[lane]);
            largest[lane] = largest[lane].max(chunk[lane]);
        }
    }
    let sum = sums.iter().sum::<f64>() + rest.iter().map(|&l| f64::from(l)).sum::<f64>();
    let all = largest.iter().chain(rest);
    (sum, all.copied().fold(0.0, f32::max))
}

/// The smallest luminance that at least `share` of the weight does not exceed. Exact: a sample of the
/// texels says between which luminances it lies, and of all texels only those in between are sorted.
fn weighted_quantile(texels: &Texels, share: f64, weight: &dyn Fn(usize) -> f64) -> f32 {
    let rows: Vec<f64> = (0..texels.height()).map(weight).collect();
    let target = share * rows.iter().sum::<f64>() * texels.width() as f64;
    let [low, high] = likely_range(texels, share, &rows);
    // Where the sample misleads, all texels are sorted.
    [[low, high], [0.0, f32::INFINITY]]
        .into_iter()
        .find_map(|range| quantile_within(texels, &rows, target, range))
        .unwrap_or(0.0)
}

/// Two luminances between which the quantile should lie: those of a sample of about four thousand texels a
/// little below and above it.
fn likely_range(texels: &Texels, share: f64, rows: &[f64]) -> [f32; 2] {
    /// A prime, so that samples wander over the columns.
    const STRIDE: usize = 509;
    const MARGIN: f64 = 0.02;
    let width = texels.width();
    let step = STRIDE.min(texels.luminance.len().div_ceil(4096));
    let mut sample: Vec<(f32, f64)> = (0..texels.luminance.len())
        .step_by(step)
        .map(|i| (texels.luminance[i], rows[i / width]))
        .collect();
    sample.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = sample.iter().map(|s| s.1).sum();
    let at = |share: f64| {
        let mut sum = 0.0;
        let reached = sample.iter().find(|(_, weight)| {
            sum += weight;
            sum >= share * total
        });
        reached.map(|s| s.0)
    };
    let margin = MARGIN.min(0.9 * (1.0 - share)).max(0.002);
    let high = match share + margin < 1.0 {
        true => at(share + margin),
        false => None,
    };
    [
        at((share - margin).max(0.0)).unwrap_or(0.0),
        high.unwrap_or(f32::INFINITY),
    ]
}

/// The smallest luminance in `range` at which the running weight reaches `target`; `None` if that is
/// outside.
fn quantile_within(
    texels: &Texels,
    rows: &[f64],
    target: f64,
    [low, high]: [f32; 2],
) -> Option<f32> {
    let mut below = 0.0;
    let mut between = Vec::new();
    for (row, &weight) in texels.luminance.chunks_exact(texels.width()).zip(rows) {
        let count: u32 = row.iter().map(|&l| u32::from(l < low)).sum();
        let inside: u32 = row.iter().map(|&l| u32::from(l >= low && l <= high)).sum();
        below += f64::from(count) * weight;
        if inside > 0 {
            let members = row.iter().filter(|&&l| l >= low && l <= high);
            between.extend(members.map(|&l| (l, weight)));
        }
    }
    if below > 0.0 && below >= target {
        return None;
    }
    between.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut sum = below;
    let reached = between.iter().find(|(_, weight)| {
        sum += weight;
        sum >= target
    });
    let last = between.last().filter(|_| high == f32::INFINITY);
    reached.or(last).map(|&(luminance, _)| luminance)
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
