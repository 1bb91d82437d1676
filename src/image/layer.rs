//! Named layers of an image file.

use super::Image;

/// One value per pixel, row-major, the top left pixel first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plane {
    /// Pixels of a row.
    pub width: usize,
    /// Pixels of a column.
    pub height: usize,
    /// `width * height` values.
    pub values: Vec<f32>,
}

impl Plane {
    /// A plane of zeros.
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            values: vec![0.0; width * height],
        }
    }

    /// The f64 mean of all values; 0 for a plane without any.
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.values.iter().map(|&value| f64::from(value)).sum();
        sum / self.values.len().max(1) as f64
    }
}

/// The pixels of a layer: three channels or one.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Channels `R`, `G` and `B`, linear.
    Color(Image),
    /// One channel.
    Gray(Plane),
}

/// A named layer of an EXR file; the name `""` is the picture itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// What stands before the names of its channels, as in `name.R`.
    pub name: String,
    /// Its pixels.
    pub samples: Samples,
}

impl Layer {
    /// A three-channel layer.
    pub fn color(name: impl Into<String>, image: Image) -> Self {
        Self {
            name: name.into(),
            samples: Samples::Color(image),
        }
    }

    /// A single-channel layer.
    pub fn gray(name: impl Into<String>, plane: Plane) -> Self {
        Self {
            name: name.into(),
            samples: Samples::Gray(plane),
        }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (usize, usize) {
        match &self.samples {
            Samples::Color(image) => (image.width, image.height),
            Samples::Gray(plane) => (plane.width, plane.height),
        }
    }

    pub(super) fn value_count(&self) -> usize {
        match &self.samples {
            Samples::Color(image) => image.pixels.len(),
            Samples::Gray(plane) => plane.values.len(),
        }
    }
}

/// Provenance stored with an image: names with strings, numbers or nested values, in the order
/// they were added.
pub type Attributes = serde_json::Map<String, serde_json::Value>;
