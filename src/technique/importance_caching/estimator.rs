//! Bilateral multiple importance sampling (Georgiev et al. 2012): over the records near a point, and
//! over the kinds of distribution.
//!
//! For each kind the densities of the records that have one are averaged, and one light is drawn from
//! the average: the balance heuristic over records. The four lights are combined over the kinds by
//! the balance heuristic or by α-max. A kind that is empty in all records draws nothing and has
//! density 0; the conservative kind is uniform over all lights, so that every light can be drawn.

use super::distributions::{Distributions, Record, STORED};
use crate::entry::words;
use crate::sample::Rng;

/// Kinds of distribution: full, unoccluded, bounded, conservative.
pub const KINDS: usize = STORED + 1;
/// Most records that are combined.
const MOST_RECORDS: usize = 32;

words! {
    /// How the samples of the kinds are weighted.
    pub enum Heuristic {
        /// In proportion to the densities.
        Balance = "balance",
        /// All weight to the kind with the largest α × density; of equal ones, to the first.
        AlphaMax = "alpha-max",
    }
}

/// A drawn light and what its contribution is multiplied by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Choice {
    pub light: u32,
    /// Weight over density; 0 if nothing was drawn.
    pub factor: f32,
}

/// The rule that combines the kinds.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    pub heuristic: Heuristic,
    /// Confidence in each kind, in (0, 1]; used by α-max.
    pub alpha: [f32; KINDS],
}

/// The records near one point.
struct Near<'a> {
    records: [Option<Record<'a>>; MOST_RECORDS],
    /// Records of each stored kind that are not empty, as indices into `records`.
    live: [([u8; MOST_RECORDS], usize); STORED],
    lights: usize,
}

impl<'a> Near<'a> {
    fn new(table: &'a Distributions, records: &[u32]) -> Self {
        let mut near = Self {
            records: [None; MOST_RECORDS],
            live: [([0; MOST_RECORDS], 0); STORED],
            lights: table.lights(),
        };
        for (slot, &index) in records.iter().take(MOST_RECORDS).enumerate() {
            let record = table.record(index);
            for (kind, (slots, count)) in near.live.iter_mut().enumerate() {
                if !record.is_empty(kind) {
                    slots[*count] = slot as u8;
                    *count += 1;
                }
            }
            near.records[slot] = Some(record);
        }
        near
    }

    fn of(&self, kind: usize) -> impl ExactSizeIterator<Item = u8> {
        let (slots, count) = &self.live[kind];
        slots[..*count].iter().copied()
    }

    fn draw(&self, kind: usize, rng: &mut Rng) -> Option<usize> {
        // Both numbers are drawn in any case, so that a kind does not shift those of the next.
        let (which, u) = (rng.next_f64(), rng.next_f64());
        if kind == STORED {
            return Some(((u * self.lights as f64) as usize).min(self.lights - 1));
        }
        let (slots, count) = &self.live[kind];
        let slot = *slots[..*count].get((which * *count as f64) as usize)?;
        Some(self.records[usize::from(slot)]?.sample(kind, u))
    }

    /// Probability of a light under each kind.
    fn densities(&self, light: usize) -> [f32; KINDS] {
        std::array::from_fn(|kind| {
            if kind == STORED {
                return 1.0 / self.lights as f32;
            }
            let count = self.of(kind).len();
            let sum: f32 = self
                .of(kind)
                .filter_map(|slot| self.records[usize::from(slot)])
                .map(|record| record.probability(kind, light))
                .sum();
            sum / count.max(1) as f32
        })
    }
}

impl Rule {
    /// Draws one light of each kind for a point near `records` (none: the conservative kind only).
    /// The sum of factor × contribution of the drawn lights is an unbiased estimate of the sum over
    /// all lights.
    pub fn choose(&self, table: &Distributions, records: &[u32], rng: &mut Rng) -> [Choice; KINDS] {
        let mut choices = [Choice::default(); KINDS];
        if table.lights() == 0 {
            return choices;
        }
        let near = Near::new(table, records);
        for (kind, choice) in choices.iter_mut().enumerate() {
            let Some(light) = near.draw(kind, rng) else {
                continue;
            };
            let densities = near.densities(light);
            choice.light = light as u32;
            choice.factor = self.factor(kind, &densities);
        }
        choices
    }

    /// Mean and variance of the estimate for given contributions, by going through all lights.
    #[cfg(test)]
    pub fn moments(&self, table: &Distributions, records: &[u32], values: &[f32]) -> [f64; 2] {
        let near = Near::new(table, records);
        let mut sums = [[0.0f64; 2]; KINDS];
        for (light, &value) in values.iter().enumerate() {
            let densities = near.densities(light);
            for (kind, sums) in sums.iter_mut().enumerate() {
                if densities[kind] > 0.0 {
                    let term = f64::from(self.factor(kind, &densities)) * f64::from(value);
                    sums[0] += f64::from(densities[kind]) * term;
                    sums[1] += f64::from(densities[kind]) * term * term;
                }
            }
        }
        let mean: f64 = sums.iter().map(|s| s[0]).sum();
        let variance = sums.iter().map(|s| s[1] - s[0] * s[0]);
        [mean, variance.sum::<f64>().max(0.0)]
    }

    /// Weight over density of a light that was drawn by a kind.
    fn factor(&self, kind: usize, densities: &[f32; KINDS]) -> f32 {
        match self.heuristic {
            Heuristic::Balance => 1.0 / densities.iter().sum::<f32>(),
            Heuristic::AlphaMax if self.winner(densities) == kind => 1.0 / densities[kind],
            Heuristic::AlphaMax => 0.0,
        }
    }

    fn winner(&self, densities: &[f32; KINDS]) -> usize {
        let mut best = 0;
        for kind in 1..KINDS {
            if self.alpha[kind] * densities[kind] > self.alpha[best] * densities[best] {
                best = kind;
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIGHTS: usize = 150;

    /// Records whose F is empty, whose everything is empty, that miss most lights, and ordinary ones.
    fn table(contribution: &[f32]) -> Distributions {
        let zero = [0.0f32; LIGHTS];
        let one_light: Vec<f32> = (0..LIGHTS).map(|i| f32::from(u8::from(i == 7))).collect();
        let shifted: Vec<f32> = (0..LIGHTS)
            .map(|i| contribution[(i + 5) % LIGHTS])
            .collect();
        let rows: [[&[f32]; STORED]; 5] = [
            [&zero, contribution, contribution],
            [&zero, &zero, &zero],
            [&one_light, &one_light, &shifted],
            [contribution, contribution, &shifted],
            [&shifted, contribution, contribution],
        ];
        let mut table = Distributions::new(LIGHTS);
        for (mut record, row) in table.append(rows.len()).into_iter().zip(rows) {
            (0..STORED).for_each(|kind| record.set(kind, row[kind]));
        }
        table
    }

    /// Contributions over eight orders of magnitude, a third of them zero.
    fn contributions() -> Vec<f32> {
        let mut rng = Rng::new(5, 0, 0, 0);
        (0..LIGHTS)
            .map(|i| {
                if i % 3 == 0 {
                    0.0
                } else {
                    10f32.powf(rng.next_f32() * 8.0 - 4.0)
                }
            })
            .collect()
    }

    #[test]
    fn the_mean_is_the_sum_over_all_lights() {
        let values = contributions();
        let table = table(&values);
        let exact: f64 = values.iter().map(|&v| f64::from(v)).sum();
        let alphas = [[1.0; KINDS], [1.0, 0.8, 0.5, 0.2]];
        let rules = [
            (Heuristic::Balance, alphas[0]),
            (Heuristic::AlphaMax, alphas[0]),
            (Heuristic::AlphaMax, alphas[1]),
        ];
        let sets: [&[u32]; 7] = [&[], &[0], &[1], &[2], &[0, 1, 2], &[3, 4], &[0, 1, 2, 3, 4]];
        for (heuristic, alpha) in rules {
            let rule = Rule { heuristic, alpha };
            for records in sets {
                let (mut sum, mut squares) = (0.0, 0.0);
                const DRAWS: u64 = 100_000;
                for draw in 0..DRAWS {
                    let mut rng = Rng::new(11, 1, draw, records.len() as u64);
                    let estimate: f64 = rule
                        .choose(&table, records, &mut rng)
                        .iter()
                        .map(|c| f64::from(c.factor) * f64::from(values[c.light as usize]))
                        .sum();
                    assert!(estimate.is_finite());
                    sum += estimate;
                    squares += estimate * estimate;
                }
                let mean = sum / DRAWS as f64;
                let variance = squares / DRAWS as f64 - mean * mean;
                let sigma = (variance.max(0.0) / DRAWS as f64).sqrt();
                let slack = 4.0 * sigma + 1e-4 * exact;
                assert!(
                    (mean - exact).abs() < slack,
                    "{heuristic:?} {records:?}: {mean} ± {sigma} instead of {exact}"
                );
            }
        }
    }

    #[test]
    fn a_record_at_the_point_itself_leaves_little_noise() {
        let values = contributions();
        let table = table(&values);
        let rule = Rule {
            heuristic: Heuristic::AlphaMax,
            alpha: [1.0, 1e-6, 1e-6, 1e-6],
        };
        let exact: f32 = values.iter().sum();
        for draw in 0..100 {
            let mut rng = Rng::new(1, 1, draw, 0);
            let full = rule.choose(&table, &[3], &mut rng)[0];
            let estimate = full.factor * values[full.light as usize];
            assert!((estimate / exact - 1.0).abs() < 2e-3, "{estimate} {exact}");
        }
    }

    #[test]
    fn without_lights_nothing_is_drawn() {
        let mut table = Distributions::new(0);
        assert!(table.append(3).is_empty());
        let rule = Rule {
            heuristic: Heuristic::Balance,
            alpha: [1.0; KINDS],
        };
        let mut rng = Rng::new(1, 1, 1, 1);
        assert_eq!(
            rule.choose(&table, &[0, 1], &mut rng),
            [Choice::default(); KINDS]
        );
    }
}
