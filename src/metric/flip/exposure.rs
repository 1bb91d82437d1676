//! The automatic exposure range of HDR-FLIP (METHODS 9.4).

use crate::image::{Image, ToneCurve, luminance};

/// The tone-mapped value that the brightest and the median pixel are brought to.
const TARGET: f32 = 0.85;
/// What stands for a black median in the official implementation.
const LEAST_MEDIAN: f32 = f32::EPSILON;
/// Widest range in stops: what half-floats span.
const WIDEST: f32 = 40.0;

/// Largest exposure whose factor is an ordinary f32.
const LARGEST: f32 = 126.0;

/// The exposures, in stops, at which HDR-FLIP looks at a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExposureRange {
    /// The lowest exposure.
    pub start: f32,
    /// The highest exposure.
    pub stop: f32,
    /// How many evenly spaced ones there are, both ends included; at least 2.
    pub count: usize,
}

impl ExposureRange {
    /// From the brightest pixel of the reference to its upper median, one exposure per stop and at
    /// least two, as the official implementation chooses them.
    ///
    /// As there, a median below 1.2 · 10⁻⁷ counts as that. A black reference is looked at with exposure 0. At most 40
    /// stops are covered. The reference must be finite and not negative.
    pub fn of(reference: &Image, curve: ToneCurve) -> Self {
        let mut luminances: Vec<f32> = reference.pixels.iter().map(|&p| luminance(p)).collect();
        let brightest = luminances.iter().copied().fold(0.0, f32::max);
        if brightest <= 0.0 {
            return Self::new(0.0, 0.0);
        }
        let middle = luminances.len() / 2;
        let (_, median, _) = luminances.select_nth_unstable_by(middle, f32::total_cmp);
        let median = median.max(LEAST_MEDIAN);
        let white = curve.inverse(TARGET);
        let stops = |y: f32| (white / y).log2().clamp(-LARGEST, LARGEST);
        let start = stops(brightest);
        Self::new(start, stops(median).clamp(start, start + WIDEST))
    }

    fn new(start: f32, stop: f32) -> Self {
        Self {
            start,
            stop,
            count: ((stop - start).ceil() as usize).max(2),
        }
    }

    /// The exposures in stops; one when start and stop coincide, since all would be equal.
    pub fn exposures(&self) -> Vec<f32> {
        if self.start == self.stop {
            return vec![self.start];
        }
        let step = (self.stop - self.start) / (self.count - 1) as f32;
        (0..self.count)
            .map(|i| self.start + i as f32 * step)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn gray(values: &[f32]) -> Image {
        Image {
            width: values.len(),
            height: 1,
            pixels: values.iter().map(|&v| [v; 3]).collect(),
        }
    }

    #[test]
    fn range_runs_from_the_maximum_to_the_upper_median() {
        let range = ExposureRange::of(&gray(&[8.0, 0.5, 1.0, 2.0]), ToneCurve::Reinhard);
        let white = (17.0_f32 / 3.0).log2();
        assert_abs_diff_eq!(range.start, white - 3.0, epsilon = 1e-5);
        assert_abs_diff_eq!(range.stop, white - 1.0, epsilon = 1e-5);
        assert_eq!(range.count, 2);
        assert_eq!(range.exposures().len(), 2);
    }

    #[test]
    fn degenerate_references_have_finite_ranges() {
        let black = ExposureRange::of(&gray(&[0.0; 3]), ToneCurve::Aces);
        assert_eq!(
            (black.start, black.stop, black.exposures().len()),
            (0.0, 0.0, 1)
        );
        let mostly_black = ExposureRange::of(&gray(&[0.0, 0.0, 0.0, 1e-30, 1.0]), ToneCurve::Aces);
        assert_abs_diff_eq!(mostly_black.stop - mostly_black.start, 23.0, epsilon = 1e-4);
        assert_eq!(mostly_black.count, 23);
        let wide = ExposureRange::of(&gray(&[1e-38, 1e-38, 1e-38, 1e38]), ToneCurve::Hable);
        assert_abs_diff_eq!(wide.stop - wide.start, 40.0, epsilon = 1e-4);
        let constant = ExposureRange::of(&gray(&[3.0; 5]), ToneCurve::Aces);
        assert_eq!((constant.count, constant.exposures().len()), (2, 1));
    }
}
