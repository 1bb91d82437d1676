//! What a cached technique and its function answer.

use glam::Vec3;

use super::Lookup;
use crate::cache::{Interpolation, Weighted};
use crate::entry::ParameterError;
use crate::technique::{Rendered, Seen, ShadingFunction, Shot, Site, Technique};
use crate::trace::{Caster, RayCounter};

/// A technique whose contenders are records of one function.
pub trait CachedTechnique: Technique {
    /// Whether its records can be interpolated so.
    ///
    /// # Errors
    /// What to set instead.
    fn accepts(&self, _: &Interpolation) -> Result<(), ParameterError> {
        Ok(())
    }

    /// The function without records, for one shot, and its run-time rule. The `seed`
    /// keys random choices of records.
    fn function<'a>(
        &'a self,
        shot: &'a Shot<'a>,
        interpolation: Interpolation,
        seed: u64,
    ) -> (Box<dyn CachedFunction + 'a>, Lookup);

    /// A random estimate of the function at every sample, for the contender without records; its
    /// samples count passes.
    fn estimator<'a>(&'a self, shot: &'a Shot<'a>, seed: u64) -> Box<dyn ShadingFunction + 'a>;

    /// Whether images from records are noisy.
    fn is_noisy(&self) -> bool {
        false
    }

    /// Adds to an image made from records what is not in them and costs all contenders the same.
    fn finish(&self, _: &Shot, _: &mut Rendered) {}
}

/// A function that is evaluated at few records and interpolated everywhere else.
pub trait CachedFunction: Sync {
    /// Evaluates at `sites` and appends the records.
    fn evaluate(&mut self, sites: &[Seen], counter: &RayCounter);

    /// Summed absolute difference of the gathering samples of two records.
    fn difference(&self, a: u32, b: u32) -> f32;

    /// What a record alone says of a shading point, linear RGB, and how far it is to be believed
    /// beside others at the same distance: positive.
    fn predict(&self, record: u32, of: &Site) -> (Vec3, f32);

    /// What the function is multiplied by on its way to the image where the camera sees a shading
    /// point.
    fn importance(&self, _: &Seen) -> Vec3 {
        Vec3::ONE
    }

    /// Length within which the function changes, scene units: positive and finite.
    fn length(&self) -> f32;

    /// The value of a camera sample from the records near it; `None` where they may not
    /// be used and the function must be evaluated. There are none when the lookup misses: no record, or none that
    /// passes the rule.
    fn shade(&self, caster: &Caster, seen: &Seen, near: Weighted) -> Option<[f32; 3]>;

    /// The value of a camera sample that records do not serve.
    fn shade_missed(&self, _: &Caster, _: &Seen) -> [f32; 3] {
        self.background()
    }

    /// The value where the camera sees no surface.
    fn background(&self) -> [f32; 3];

    /// Values that were not finite and were left out of records.
    fn non_finite(&self) -> u64 {
        0
    }

    /// What is worth reporting of lookups.
    fn found(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
}
