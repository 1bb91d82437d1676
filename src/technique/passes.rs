//! The mean of passes of a shading function over a shot.

use super::{ShadingFunction, Shot, reference_pass};
use crate::image::{Image, ImageMean};
use crate::trace::RayCounter;

/// Values that were not finite are located up to this many.
const LOCATED: usize = 8;

/// Passes added so far.
pub struct Passes<'a> {
    shot: &'a Shot<'a>,
    function: &'a dyn ShadingFunction,
    mean: ImageMean,
    /// Number of the first pass.
    first: u32,
    /// Values that were not finite and count as black.
    pub non_finite: u64,
    /// Pixels and samples of the first of them.
    located: Vec<(u32, u32)>,
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
            located: Vec::new(),
        }
    }

    /// Adds the next pass.
    pub fn add(&mut self, counter: &RayCounter) {
        let sample = self.first.wrapping_add(self.count());
        let (pass, non_finite) = reference_pass(self.function, self.shot, sample, counter);
        self.non_finite += non_finite;
        if non_finite > 0 {
            self.locate(sample);
        }
        self.mean.add(&pass);
    }

    /// Looks for the pixels of a pass that were not finite, one by one; its rays do not count.
    fn locate(&mut self, sample: u32) {
        let counter = RayCounter::default();
        let caster = self.shot.tracer.caster(&counter);
        for pixel in 0..(self.shot.width * self.shot.height) as u32 {
            if self.located.len() == LOCATED {
                return;
            }
            let mut alone = [[0.0; 3]];
            if self.function.pixels(&caster, pixel, sample, &mut alone) > 0 {
                self.located.push((pixel, sample));
            }
        }
    }

    /// Where the first values were that were not finite; nothing where all were.
    pub fn note(&self) -> Option<String> {
        let width = self.shot.width as u32;
        let place = |(pixel, sample): &(u32, u32)| {
            format!("pixel {},{} sample {sample}", pixel % width, pixel / width)
        };
        let places: Vec<String> = self.located.iter().map(place).collect();
        let more = if self.non_finite > places.len() as u64 {
            ", …"
        } else {
            ""
        };
        (!places.is_empty()).then(|| format!("not finite: {}{more}", places.join(", ")))
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
