//! The mean of passes of a shading function over a shot.

use super::{ShadingFunction, Shot, reference_pass};
use crate::image::{Image, ImageMean};
use crate::trace::RayCounter;

/// Passes added so far.
pub struct Passes<'a> {
    shot: &'a Shot<'a>,
    function: &'a dyn ShadingFunction,
    mean: ImageMean,
    /// Number of the first pass.
    first: u32,
    /// Values that were not finite and count as black.
    pub non_finite: u64,
}

impl<'a> Passes<'a> {
    /// No pass yet.
    pub fn new(shot: &'a Shot<'a>, function: &'a dyn ShadingFunction) -> Self {
        Self::starting_at(0, shot, function)
    }

    /// No pass yet; the first one will be number `first`.
    pub fn starting_at(first: u32, shot: &'a Shot<'a>, function: &'a dyn ShadingFunction) -> Self {
        Self {
            first,
            shot,
            function,
            mean: ImageMean::new(shot.width, shot.height),
            non_finite: 0,
        }
    }

    /// Adds the next pass.
    pub fn add(&mut self, counter: &RayCounter) {
        let (pass, non_finite) = reference_pass(
            self.function,
            self.shot,
            self.first.wrapping_add(self.count()),
            counter,
        );
        self.non_finite += non_finite;
        self.mean.add(&pass);
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.mean.count()
    }

    /// The mean; black without passes.
    pub fn mean(&self) -> Image {
        self.mean.image()
    }
}
