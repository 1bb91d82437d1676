//! Why two images cannot be compared.

use crate::image::{Image, ImageError};

/// Why two images cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum MetricError {
    /// The images differ in size.
    #[error(
        "the reference has {}x{} pixels but the test image has {}x{}; render or crop them to one size",
        reference.0, reference.1, test.0, test.1
    )]
    SizeMismatch {
        /// Width and height in pixels.
        reference: (usize, usize),
        /// Width and height in pixels.
        test: (usize, usize),
    },
    /// There is nothing to compare.
    #[error("the images have no pixels ({width}x{height})")]
    Empty {
        /// Pixels of a row.
        width: usize,
        /// Pixels of a column.
        height: usize,
    },
    /// FLIP's observer is given by pixels per degree of visual angle.
    #[error("pixels per degree must lie between 1 and 1000, not {0}; the default is 67.02")]
    PixelsPerDegree(f32),
    /// The display exposure is given in stops.
    #[error("the exposure must lie between -100 and 100 stops, not {0}")]
    Exposure(f32),
    /// One of the files could not be read.
    #[error(transparent)]
    Image(#[from] ImageError),
}

/// Checks that two images can be compared pixel by pixel.
pub(super) fn check_sizes(reference: &Image, test: &Image) -> Result<(), MetricError> {
    let size = (reference.width, reference.height);
    if size != (test.width, test.height) {
        return Err(MetricError::SizeMismatch {
            reference: size,
            test: (test.width, test.height),
        });
    }
    let complete = |image: &Image| image.pixels.len() == image.width * image.height;
    if reference.pixels.is_empty() || !complete(reference) || !complete(test) {
        return Err(MetricError::Empty {
            width: size.0,
            height: size.1,
        });
    }
    Ok(())
}
