//! A filter against boiling: a rare light that is found once is worth much, spreads over the surfaces around it and flashes.
//! Reservoirs that weigh far more than those around them are given up, with the light that they stand for.
//!
//! As the RTXDI library has it (`Rtxdi/Utils/BoilingFilter.hlsli`), in groups as large as its full sample has: a reservoir is
//! emptied, its samples no longer counted, where its weight W exceeds 10/strength − 9 times the mean of those of its group that
//! are not zero.

use std::ops::Range;

use rayon::prelude::*;

use super::reservoir::Reservoir;

/// Side of a group in pixels; groups begin at the image's first corner, and those at the other sides may be smaller.
const GROUP: usize = 16;

/// The filter for reservoirs that lie pixel by pixel, row by row.
#[derive(Clone, Copy, Debug)]
pub struct BoilingFilter {
    /// In (0, 1].
    pub strength: f32,
    /// Pixels of a row.
    pub width: usize,
    /// Reservoirs of a pixel; the first of all are compared with each other, the second likewise.
    pub layers: usize,
}

impl BoilingFilter {
    /// Empties what weighs too much, or is not finite; how many these were.
    pub fn run(&self, all: &mut [Reservoir]) -> u64 {
        let rows = GROUP * self.width * self.layers;
        all.par_chunks_mut(rows.max(1))
            .map(|rows| self.filter_rows(rows))
            .sum()
    }

    fn filter_rows(&self, rows: &mut [Reservoir]) -> u64 {
        let mut emptied = 0;
        for left in (0..self.width).step_by(GROUP) {
            let columns = left..(left + GROUP).min(self.width);
            for layer in 0..self.layers {
                emptied += self.filter_group(rows, columns.clone(), layer);
            }
        }
        emptied
    }

    fn filter_group(&self, rows: &mut [Reservoir], columns: Range<usize>, layer: usize) -> u64 {
        let places = (0..rows.len() / (self.width * self.layers)).flat_map(|row| {
            let columns = columns.clone();
            columns.map(move |column| (row * self.width + column) * self.layers + layer)
        });
        let weights = places.clone().map(|place| f64::from(rows[place].weight));
        let most = self.times_mean() * mean_of_positive(weights);
        let mut emptied = 0;
        for place in places {
            let weight = f64::from(rows[place].weight);
            if weight.is_nan() || weight > most {
                rows[place] = Reservoir::default();
                emptied += 1;
            }
        }
        emptied
    }

    fn times_mean(&self) -> f64 {
        10.0 / f64::from(self.strength.clamp(1e-6, 1.0)) - 9.0
    }
}

/// The mean of the positive finite numbers; 0 where there is none.
fn mean_of_positive(numbers: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0u32);
    for number in numbers.filter(|number| number.is_finite() && *number > 0.0) {
        sum += number;
        count += 1;
    }
    sum / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shade::LightPlace;

    const NONE: [usize; 0] = [];

    fn of(weight: f32) -> Reservoir {
        Reservoir {
            place: (weight != 0.0).then_some(LightPlace::Point(0)),
            weight,
            count: 10,
        }
    }

    /// Which reservoirs of an image are emptied.
    fn emptied(width: usize, layers: usize, strength: f32, weights: &[f32]) -> Vec<usize> {
        let mut all: Vec<Reservoir> = weights.iter().map(|weight| of(*weight)).collect();
        let filter = BoilingFilter {
            strength,
            width,
            layers,
        };
        let count = filter.run(&mut all);
        let empty: Vec<usize> = (0..all.len()).filter(|i| all[*i].count == 0).collect();
        assert_eq!(count as usize, empty.len());
        for (i, reservoir) in all.iter().enumerate() {
            let expected = match empty.contains(&i) {
                true => Reservoir::default(),
                false => of(weights[i]),
            };
            assert_eq!(*reservoir, expected);
        }
        empty
    }

    #[test]
    fn outliers_are_emptied_and_the_rest_stays() {
        let mut weights = vec![1.0; 256];
        weights[..100].fill(0.0);
        // With strength 0.2 the limit is 41 times the mean of those that are not zero.
        weights[200] = 55.0;
        assert_eq!(emptied(16, 1, 0.2, &weights), NONE);
        weights[200] = 56.0;
        assert_eq!(emptied(16, 1, 0.2, &weights), [200]);
        // With strength 1 no weight may exceed the mean.
        weights[200] = 1.5;
        assert_eq!(emptied(16, 1, 1.0, &weights), [200]);
    }

    #[test]
    fn groups_end_at_the_image_and_know_nothing_of_each_other() {
        // Groups of 16 × 16, 3 × 16, 16 × 2 and 3 × 2 pixels.
        let (width, height) = (19, 18);
        let mut weights = vec![1.0; width * height];
        // A group that is bright altogether is not compared with others.
        let of_last_group = |i: &usize| i % width >= 16 && i / width >= 16;
        (0..weights.len())
            .filter(of_last_group)
            .for_each(|i| weights[i] = 1e6);
        let limit_of = |count: f32| 41.0 * (count - 1.0) / (count - 41.0);
        let [inside, right] = [5 * width + 7, 9 * width + 18];
        weights[inside] = 1.01 * limit_of(256.0);
        weights[right] = 1.01 * limit_of(48.0);
        assert_eq!(emptied(width, 1, 0.2, &weights), [inside, right]);
        weights[inside] = 0.99 * limit_of(256.0);
        weights[right] = 0.99 * limit_of(48.0);
        assert_eq!(emptied(width, 1, 0.2, &weights), NONE);
    }

    #[test]
    fn layers_are_filtered_apart() {
        // The second reservoir of each pixel weighs 100 times as much as the first.
        let mut weights: Vec<f32> = [1.0, 100.0].repeat(256);
        weights[50] = 80.0;
        assert_eq!(emptied(16, 2, 0.2, &weights), [50]);
    }

    #[test]
    fn nothing_is_left_of_what_is_no_number_and_nothing_happens_to_nothing() {
        assert_eq!(emptied(5, 1, 0.2, &[0.0; 35]), NONE);
        assert_eq!(emptied(5, 1, 0.2, &[]), NONE);
        let mut weights = vec![1.0; 35];
        weights[3] = f32::INFINITY;
        assert_eq!(emptied(5, 1, 0.2, &weights), [3]);
        let mut all: Vec<Reservoir> = weights.iter().map(|weight| of(*weight)).collect();
        all[3].weight = f32::NAN;
        let filter = BoilingFilter {
            strength: 0.2,
            width: 5,
            layers: 1,
        };
        assert_eq!(filter.run(&mut all), 1);
        assert_eq!(all[3], Reservoir::default());
    }
}
