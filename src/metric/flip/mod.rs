//! FLIP (Andersson et al. 2020) and HDR-FLIP (Andersson et al. 2021), equal to the official
//! implementation (METHODS 9.3 and 9.4).
//!
//! *differs:* values above 1e15 count as 1e15; where the official exposure range is undefined, the
//! rules of [`ExposureRange::of`] hold.

mod color;
mod exposure;
mod kernel;
mod map;

pub use color::lab;
pub use exposure::ExposureRange;

use crate::image::{Image, Plane, ToneCurve, clamp_unit};
use kernel::Kernels;
use map::{Opponent, flip_map};

/// The official observer: 0.7 m from a display 0.7 m wide with 3840 pixels.
pub const DEFAULT_PIXELS_PER_DEGREE: f32 = 67.020_645;

/// Pixels per degree of visual angle for a viewing distance, a display width and its pixels.
pub fn pixels_per_degree(distance_m: f32, display_width_m: f32, display_width_px: f32) -> f32 {
    distance_m * (display_width_px / display_width_m) * (std::f32::consts::PI / 180.0)
}

/// The FLIP evaluator for one observer.
pub struct Flip {
    kernels: Kernels,
}

impl Flip {
    /// Prepares the filters; `pixels_per_degree` must be positive, its cost grows with it.
    pub fn new(pixels_per_degree: f32) -> Self {
        Self {
            kernels: Kernels::new(pixels_per_degree),
        }
    }

    /// LDR-FLIP per pixel of two linear images of one size, clamped to `[0, 1]`; its f64 mean is the
    /// image's score.
    pub fn ldr(&self, reference: &Image, test: &Image) -> Plane {
        self.map(reference, test, |pixel| pixel.map(clamp_unit))
    }

    /// HDR-FLIP per pixel of two linear images of one size: the largest LDR-FLIP over the exposures,
    /// each followed by the tone curve. Values must be finite and not negative.
    pub fn hdr(
        &self,
        reference: &Image,
        test: &Image,
        range: ExposureRange,
        curve: ToneCurve,
    ) -> Plane {
        let mut largest = Plane::new(reference.width, reference.height);
        for exposure in range.exposures() {
            let scale = exposure.exp2();
            let shown = |pixel: [f32; 3]| {
                let exposed = pixel.map(|value| value * scale);
                curve.apply(exposed).map(clamp_unit)
            };
            let map = self.map(reference, test, shown);
            for (top, value) in largest.values.iter_mut().zip(map.values) {
                *top = top.max(value);
            }
        }
        largest
    }

    fn map(
        &self,
        reference: &Image,
        test: &Image,
        shown: impl Fn([f32; 3]) -> [f32; 3] + Sync,
    ) -> Plane {
        let size = reference.size();
        let convert = |image: &Image| Opponent::new(size, |i| shown(image.pixels[i]));
        flip_map(&convert(reference), &convert(test), &self.kernels)
    }
}
