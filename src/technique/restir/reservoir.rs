//! Reservoirs: one of many light samples, selected in proportion to its weight as they come.

use serde::{Deserialize, Serialize};

use crate::shade::LightPlace;

/// A selected light sample, and how many it stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reservoir {
    /// `None` where no sample had any weight.
    pub place: Option<LightPlace>,
    /// W: what the contribution of the sample is to be multiplied by, the reciprocal of its density on average.
    pub weight: f32,
    /// M: samples that were looked at.
    pub count: u32,
}

impl Reservoir {
    /// As it is, but its sample given up.
    pub fn emptied(self) -> Self {
        Self {
            place: None,
            weight: 0.0,
            ..self
        }
    }
}

/// A sample that was selected so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Selected {
    pub place: LightPlace,
    /// The target at the surface that selects.
    pub target: f32,
    /// Number of the reservoir that it comes from.
    pub source: usize,
}

/// A selection under way (Bitterli et al. 2020, algorithm 2).
#[derive(Clone, Copy, Debug, Default)]
pub struct Selecting {
    pub selected: Option<Selected>,
    /// Sum of the weights.
    pub sum: f64,
    /// Weights that were not finite, and count as zero.
    pub non_finite: u64,
}

impl Selecting {
    /// Looks at a sample; `u` is uniform in [0, 1).
    pub fn offer(&mut self, sample: Selected, weight: f64, u: f64) {
        if !weight.is_finite() || weight < 0.0 {
            self.non_finite += 1;
            return;
        }
        self.sum += weight;
        // A weight of zero is never below.
        if u * self.sum < weight {
            self.selected = Some(sample);
        }
    }

    /// Looks at a candidate: its target, and the density that it was drawn with.
    pub fn offer_place(&mut self, place: LightPlace, target: f32, density: f32, u: f64) {
        let sample = Selected {
            place,
            target,
            source: 0,
        };
        let weight = match target > 0.0 {
            true => f64::from(target) / f64::from(density),
            false => 0.0,
        };
        self.offer(sample, weight, u);
    }

    /// The reservoir of `count` samples whose weights have been multiplied by `share`: 1/M, or what replaces it.
    pub fn reservoir(&self, count: u32, share: f64) -> Reservoir {
        let empty = Reservoir {
            count,
            ..Reservoir::default()
        };
        let Some(selected) = self.selected else {
            return empty;
        };
        let weight = (self.sum * share / f64::from(selected.target)) as f32;
        match weight.is_finite() && weight > 0.0 {
            true => Reservoir {
                place: Some(selected.place),
                weight,
                count,
            },
            false => empty,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    fn sample(number: u32, target: f32) -> Selected {
        Selected {
            place: LightPlace::Point(number),
            target,
            source: 0,
        }
    }

    /// On average a reservoir's sample over its density is the sum of all, whatever the weights.
    #[test]
    fn samples_are_selected_by_weight_and_bring_the_whole_on_average() {
        // Of each light its target, its value and the probability it is drawn with; the last is dark.
        let lights: [(f32, f64, f64); 3] = [(1.0, 3.0, 0.5), (4.0, 5.0, 0.25), (0.0, 0.0, 0.25)];
        let (mut sum, mut first) = (0.0, 0u32);
        let repeats = 60_000;
        for repeat in 0..repeats {
            let mut rng = Rng::new(1, 2, repeat, 0);
            let mut selecting = Selecting::default();
            for _ in 0..4 {
                let u = rng.next_f64();
                let number = [0.5, 0.75, 1.0]
                    .iter()
                    .position(|end| u < *end)
                    .expect("one");
                let (target, _, chance) = lights[number];
                let weight = f64::from(target) / chance;
                selecting.offer(sample(number as u32, target), weight, rng.next_f64());
            }
            let reservoir = selecting.reservoir(4, 0.25);
            assert_eq!(reservoir.count, 4);
            if let Some(LightPlace::Point(number)) = reservoir.place {
                sum += lights[number as usize].1 * f64::from(reservoir.weight);
                first += u32::from(number == 0);
            }
        }
        let mean = sum / repeats as f64;
        assert!((mean - 8.0).abs() < 0.06, "{mean}");
        assert!(first > 10_000 && first < 30_000, "{first}");
    }

    #[test]
    fn what_has_no_weight_is_never_selected_and_counts() {
        let mut selecting = Selecting::default();
        for weight in [0.0, f64::NAN, f64::INFINITY, -1.0] {
            selecting.offer(sample(0, 0.0), weight, 0.0);
        }
        assert_eq!((selecting.selected, selecting.non_finite), (None, 3));
        let reservoir = selecting.reservoir(4, 0.25);
        assert_eq!(
            (reservoir.place, reservoir.weight, reservoir.count),
            (None, 0.0, 4)
        );
        selecting.offer(sample(7, 2.0), 1.0, 0.999);
        let reservoir = selecting.reservoir(5, 0.2);
        assert_eq!(reservoir.place, Some(LightPlace::Point(7)));
        assert!((reservoir.weight - 0.1).abs() < 1e-6);
        assert_eq!(reservoir.emptied().count, 5);
        // A target that rounding made vanish gives no infinite weight.
        let mut selecting = Selecting::default();
        selecting.offer(sample(0, 0.0), 1.0, 0.0);
        assert_eq!(selecting.reservoir(1, 1.0).place, None);
    }
}
