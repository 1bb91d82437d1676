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

/// Sets the scale so that the surfaces of the frame have this mean luminance, as estimated at a grid
/// of pixels; a dark frame keeps its scale. The cost is not charged to a contender.
pub(super) fn expose(illumination: &mut Illumination, mean_luminance: f64) {
    let mean = surface_luminance(illumination);
    let scale = mean_luminance / mean;
    if scale.is_finite() && scale > 0.0 {
        illumination.scale *= scale as f32;
    }
}

fn surface_luminance(illumination: &Illumination) -> f64 {
    let frame = illumination.frame;
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
    let columns = centres(frame.width);
    let counter = RayCounter::default();
    let rows: Vec<(f64, u32)> = centres(frame.height)
        .into_par_iter()
        .map(|y| {
            let caster = frame.tracer.caster(&counter);
            let mut sum = (0.0, 0);
            for x in &columns {
                let pixel = (y * frame.width + x) as u32;
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
