//! Error metrics between a reference and a test image, and statistics over repeats.
//!
//! [`compare`] gives all metrics of two images at once. Linear (scene-referred) images are compared
//! twice: RMSE and relMSE on linear values, PSNR, SSIM, MS-SSIM and LDR-FLIP on the display form
//! (exposure, clamp, sRGB), HDR-FLIP over its automatic range of exposures. Display-referred images
//! (8- and 16-bit files) are compared on their coded values. Images are sanitised first and what was
//! replaced is counted; no metric is ever NaN. Sums are f64 and taken in a fixed order, so results
//! do not depend on the number of threads.

mod compare;
mod convolve;
mod error;
mod flip;
mod ms_ssim;
mod pixel;
mod ssim;
pub mod statistics;
mod z_test;

pub use compare::{CompareOptions, Comparison, Maps, compare, compare_files};
pub use error::MetricError;
pub use flip::lab;
pub use flip::{DEFAULT_PIXELS_PER_DEGREE, ExposureRange, Flip, pixels_per_degree};
pub use ms_ssim::{MsSsim, ms_ssim};
pub use pixel::{PixelErrors, absolute_error, pixel_errors, psnr};
pub use ssim::ssim;
pub use z_test::{ZTest, block_z_scores, z_test};
