//! Finding the entry of a running sum without searching all of it.

use super::pick;

/// Where in a running sum the search for a number begins and ends.
#[derive(Clone, Debug, Default)]
pub(super) struct Guide {
    /// The least entry of each of equal parts of [0, 1), and the last one of all.
    first: Vec<u32>,
}

/// Parts at most.
const MOST_PARTS: usize = 1 << 16;
/// Part of a number that rounding may take from it.
const ROUNDING: f64 = 1e-12;

impl Guide {
    /// Of a running sum.
    pub fn new(sums: &[f64]) -> Self {
        let Some(total) = sums.last() else {
            return Self::default();
        };
        let parts = sums.len().next_power_of_two().min(MOST_PARTS);
        let last = sums.len() - 1;
        let mut entry = 0;
        let mut first: Vec<u32> = (0..parts)
            .map(|part| {
                let least = part as f64 / parts as f64 * total * (1.0 - ROUNDING);
                while entry < last && sums[entry] <= least {
                    entry += 1;
                }
                entry as u32
            })
            .collect();
        first.push(last as u32);
        Self { first }
    }

    /// [`pick`] of the same sums.
    pub fn pick(&self, sums: &[f64], u: f64) -> usize {
        let parts = self.first.len().saturating_sub(1);
        let part = (u * parts as f64) as usize;
        let ends = (self.first.get(part), self.first.get(part + 1));
        let (Some(&low), Some(&high)) = ends else {
            return pick(sums, u);
        };
        let (low, high) = (low as usize, high as usize);
        let target = u * sums[sums.len() - 1];
        // Beyond the part by rounding at most.
        let found = low + sums[low..=high].partition_point(|&sum| sum <= target);
        match found > high {
            true => pick(sums, u),
            false => found,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    #[test]
    fn entries_are_those_of_the_whole_search() {
        let mut rng = Rng::new(5, 0, 0, 0);
        for count in [1, 2, 3, 100, 1000] {
            let mut sum = 0.0;
            let sums: Vec<f64> = (0..count)
                .map(|i| {
                    // Entries of all sizes, some of them empty.
                    let part = [0.0, 1e-9, rng.next_f64(), 100.0][i % 4];
                    sum += if count == 1 { 1.0 } else { part };
                    sum
                })
                .collect();
            let guide = Guide::new(&sums);
            let edges = sums.iter().map(|s| s / sum);
            let random: Vec<f64> = (0..2000).map(|_| rng.next_f64()).collect();
            let near = edges.flat_map(|u| [u.next_down(), u, u.next_up()]);
            for u in near.chain(random).filter(|u| (0.0..1.0).contains(u)) {
                assert_eq!(guide.pick(&sums, u), pick(&sums, u), "{count} {u}");
            }
        }
        assert!(Guide::new(&[]).first.is_empty());
    }
}
