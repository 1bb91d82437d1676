//! Mean and interval over repeats.

use std::collections::BTreeMap;

use crate::metric::statistics::Summary;

/// Values of one quantity over seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    pub mean: f64,
    /// Half width of the 95 % confidence interval of the mean; `None` for a single value.
    pub half_width: Option<f64>,
    pub(super) by_seed: BTreeMap<u64, f64>,
    /// How many seeds are expected: more than there are where a run failed or is missing.
    pub expected: usize,
}

impl Estimate {
    /// `None` without finite values.
    pub fn new(by_seed: BTreeMap<u64, f64>) -> Option<Self> {
        let values: Vec<f64> = by_seed.values().copied().collect();
        let summary = Summary::of(&values)?;
        // Equal values have their own mean: no rounding, which would look like a spread.
        let equal = values.iter().all(|v| *v == values[0]);
        Some(Self {
            mean: if equal { values[0] } else { summary.mean },
            half_width: summary.half_width.map(|h| if equal { 0.0 } else { h }),
            expected: by_seed.len(),
            by_seed,
        })
    }

    /// The same where so many seeds are expected.
    pub fn of_expected(self, expected: usize) -> Self {
        Self { expected, ..self }
    }

    /// Whether every seed that is expected has a value.
    pub fn is_whole(&self) -> bool {
        self.repeats() >= self.expected
    }

    /// The mean of several quantities, seed by seed; `None` where one of them lacks a seed.
    pub fn mean_of(estimates: &[Self]) -> Option<Self> {
        if !estimates.iter().all(Self::is_whole) {
            return None;
        }
        let seeds = estimates.first()?.by_seed.keys();
        let mean = |seed: &u64| {
            let values = estimates.iter().map(|e| e.by_seed.get(seed).copied());
            let values: Vec<f64> = values.collect::<Option<_>>()?;
            Some((*seed, values.iter().sum::<f64>() / values.len() as f64))
        };
        Self::new(seeds.filter_map(mean).collect())
    }

    /// A published or derived number.
    pub fn exact(value: f64) -> Option<Self> {
        Self::new(BTreeMap::from([(0, value)]))
    }

    /// How many values went into it.
    pub fn repeats(&self) -> usize {
        self.by_seed.len()
    }

    /// Whether the difference to another estimate lies within its 95 % interval, paired by seed;
    /// exact equality where there are no pairs to tell.
    pub fn ties(&self, other: &Self) -> bool {
        let differences: Vec<f64> = self
            .by_seed
            .iter()
            .filter_map(|(seed, value)| Some(value - other.by_seed.get(seed)?))
            .collect();
        match Summary::of(&differences).and_then(|s| Some((s.mean, s.half_width?))) {
            Some((margin, half)) => margin.abs() <= half,
            None => self.mean == other.mean,
        }
    }
}

/// How an estimate stands among its rivals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    #[default]
    Plain,
    /// The best of all.
    Best,
    /// Not distinguishable from the best.
    Tied,
}

/// Marks the best estimate and those tied with it; one that lacks a seed is no rival. With fewer than two
/// rivals, or when all means are equal, nothing is marked.
pub fn standings(rivals: &[Option<&Estimate>], lower_is_better: bool) -> Vec<Standing> {
    let key = |e: &Estimate| if lower_is_better { e.mean } else { -e.mean };
    let whole = |rival: &Option<&Estimate>| rival.is_some_and(Estimate::is_whole);
    let present = rivals.iter().filter(|rival| whole(rival)).flatten();
    let present: Vec<&Estimate> = present.copied().collect();
    let best = present
        .iter()
        .copied()
        .min_by(|a, b| key(a).total_cmp(&key(b)));
    let Some(best) = best.filter(|b| present.iter().any(|e| e.mean != b.mean)) else {
        return vec![Standing::Plain; rivals.len()];
    };
    rivals
        .iter()
        .map(|rival| match rival {
            Some(e) if !e.is_whole() => Standing::Plain,
            Some(e) if e.mean == best.mean => Standing::Best,
            Some(e) if e.ties(best) => Standing::Tied,
            _ => Standing::Plain,
        })
        .collect()
}

/// Rank of each rival, 1 the best; equal means share the mean of their ranks. All must be present.
pub fn ranks(rivals: &[Option<&Estimate>], lower_is_better: bool) -> Option<Vec<f64>> {
    let keys: Vec<f64> = rivals
        .iter()
        .map(|r| r.map(|e| if lower_is_better { e.mean } else { -e.mean }))
        .collect::<Option<_>>()?;
    let rank = |key: &f64| {
        let better = keys.iter().filter(|k| *k < key).count() as f64;
        let equal = keys.iter().filter(|k| *k == key).count() as f64;
        better + (equal + 1.0) / 2.0
    };
    Some(keys.iter().map(rank).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(values: &[f64]) -> Estimate {
        Estimate::new((0..).zip(values.iter().copied()).collect()).expect("values")
    }

    #[test]
    fn ties_need_repeats_and_overlap() {
        let (a, b) = (estimate(&[1.0, 1.2, 0.9]), estimate(&[1.1, 1.0, 1.05]));
        let far = estimate(&[3.0, 3.1, 3.05]);
        let marks = standings(&[Some(&far), Some(&a), None, Some(&b)], true);
        assert_eq!(
            marks,
            [
                Standing::Plain,
                Standing::Best,
                Standing::Plain,
                Standing::Tied
            ]
        );
        let marks = standings(&[Some(&far), Some(&a)], false);
        assert_eq!(marks, [Standing::Best, Standing::Plain]);
        let single = [estimate(&[1.0]), estimate(&[1.0001])];
        let marks = standings(&[Some(&single[0]), Some(&single[1])], true);
        assert_eq!(marks, [Standing::Best, Standing::Plain]);
    }

    #[test]
    fn nothing_is_best_among_equals_or_alone() {
        let a = estimate(&[2.0]);
        assert_eq!(standings(&[Some(&a), Some(&a)], true), [Standing::Plain; 2]);
        assert_eq!(standings(&[Some(&a), None], true), [Standing::Plain; 2]);
        assert_eq!(standings(&[], true), []);
        assert!(Estimate::new(BTreeMap::new()).is_none());
        assert!(Estimate::exact(f64::NAN).is_none());
    }

    #[test]
    fn without_one_of_its_seeds_nothing_is_best_or_part_of_a_mean() {
        let (a, b) = (estimate(&[1.0, 2.0]), estimate(&[3.0, 4.0]));
        let partial = estimate(&[0.1]).of_expected(2);
        let marks = standings(&[Some(&a), Some(&partial), Some(&b)], true);
        assert_eq!(marks, [Standing::Best, Standing::Plain, Standing::Plain]);
        let mean = Estimate::mean_of(&[a.clone(), b]).map(|e| e.mean);
        assert_eq!(mean, Some(2.5));
        assert_eq!(Estimate::mean_of(&[a, partial]), None);
    }

    #[test]
    fn equal_values_share_their_rank() {
        let (a, b, c) = (estimate(&[1.0]), estimate(&[2.0]), estimate(&[2.0]));
        assert_eq!(
            ranks(&[Some(&b), Some(&a), Some(&c)], true),
            Some(vec![2.5, 1.0, 2.5])
        );
        assert_eq!(ranks(&[Some(&a), None], true), None);
    }
}
