//! The mean of passes of a shading function over a shot.

use super::{ShadingFunction, Shot, reference_pass};
use crate::image::Image;
use crate::trace::RayCounter;

/// Passes added so far, in f64.
pub struct Passes<'a> {
    shot: &'a Shot<'a>,
    function: &'a dyn ShadingFunction,
    sums: Vec<[f64; 3]>,
    /// Number of the first pass.
    first: u32,
    pub count: u32,
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
            sums: vec![[0.0; 3]; shot.pixels()],
            count: 0,
            non_finite: 0,
        }
    }

    /// Adds the next pass.
    pub fn add(&mut self, counter: &RayCounter) {
        let (pass, non_finite) = reference_pass(
            self.function,
            self.shot,
            self.first.wrapping_add(self.count),
            counter,
        );
        self.count += 1;
        self.non_finite += non_finite;
        for (sum, value) in self.sums.iter_mut().zip(&pass.pixels) {
            (0..3).for_each(|c| sum[c] += f64::from(value[c]));
        }
    }

    /// The mean; black without passes.
    pub fn mean(&self) -> Image {
        let mut image = Image::new(self.shot.width, self.shot.height);
        let count = f64::from(self.count.max(1));
        for (pixel, sum) in image.pixels.iter_mut().zip(&self.sums) {
            *pixel = sum.map(|s| (s / count) as f32);
        }
        image
    }
}
