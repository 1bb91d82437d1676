//! Exposure to a mean luminance, so that maps of any brightness give comparable images.

use rayon::prelude::*;

use super::illumination::Illumination;
use super::multiple::{MultipleImportance, Samples};
use crate::image::luminance;
use crate::trace::RayCounter;

const SEED: u64 = 0x6578_706f_7365;
/// Pixels looked at along each side of the image, at most.
const SIDE: usize = 40;
const SAMPLES: u32 = 64;

/// The factor that gives the surfaces of the shot this mean luminance, as estimated at a grid of
/// pixels; 1 for a dark shot. The cost is not charged to a contender.
pub(super) fn exposure(illumination: &Illumination, mean_luminance: f64) -> f32 {
    let scale = mean_luminance / surface_luminance(illumination);
    if scale.is_finite() && scale > 0.0 {
        scale as f32
    } else {
        1.0
    }
}

fn surface_luminance(illumination: &Illumination) -> f64 {
    let shot = illumination.shot;
    let samples = Samples {
        light: SAMPLES,
        surface: SAMPLES,
        stratified: true,
    };
    let estimator = MultipleImportance::new(illumination, samples, SEED);
    let centres = |length: usize| -> Vec<usize> {
        let count = length.min(SIDE);
        (0..count)
            .map(|i| (2 * i + 1) * length / (2 * count))
            .collect()
    };
    let columns = centres(shot.width);
    let counter = RayCounter::default();
    let rows: Vec<(f64, u32)> = centres(shot.height)
        .into_par_iter()
        .map(|y| {
            let caster = shot.tracer.caster(&counter);
            let mut sum = (0.0, 0);
            for x in &columns {
                let pixel = (y * shot.width + x) as u32;
                if let Ok((at, seen)) = illumination.point(&caster, pixel, 0) {
                    let radiance = seen.throughput * estimator.radiance(&caster, &at, [pixel, 0]);
                    let value = f64::from(luminance(radiance.into()));
                    if value.is_finite() {
                        sum = (sum.0 + value, sum.1 + 1);
                    }
                }
            }
            sum
        })
        .collect();
    let (sum, count) = rows
        .iter()
        .fold((0.0, 0), |(s, n), (sum, count)| (s + sum, n + count));
    sum / f64::from(count)
}
