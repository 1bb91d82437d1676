//! What is computed: cached functions under a distribution of records, and the truths.
//!
//! Two seams: a [`CachedFunction`] knows how to evaluate, compare and interpolate records but not
//! where they are; a [`Distribution`] places them but not what they hold. What a technique compares are
//! [`Contender`]s, each listed in the technique's own folder; [`cached`] makes one of any distribution.

pub mod ambient_occlusion;
pub mod cached;
mod contender;
pub mod direct_lighting;
mod distribution;
pub mod environment_lighting;
#[cfg(test)]
mod example_contender;
#[cfg(test)]
mod example_technique;
pub mod importance_caching;
pub mod irradiance_caching;
mod light_cones;
mod passes;
mod path_samples;
mod paths;
pub mod radiance;
mod restir;
mod running_mean;
mod shading_points;
mod shot;
mod stages;
pub mod truth;
mod unit;

pub use cached::{CachedFunction, CachedTechnique, Lookup};
pub use contender::{
    Choice, Contender, ContenderEntry, Foreseen, PlacedRecord, Playing, Rendered, Search, Started,
    Terms,
};
pub use distribution::Distribution;

pub use passes::Passes;
pub use shading_points::shading_points;
pub use shot::{Film, Missed, Seen, Shot, Site};
pub use stages::{Clock, Seconds, Stage, Stages};
pub use unit::{CACHES, Casts, LIGHTS, RAYS_PER_PIXEL, SAMPLES, SECONDS, Spending, UNITS, Unit};

use glam::Vec3;
use rayon::prelude::*;

use crate::entry::{About, ParameterError};
use crate::image::Image;
use crate::scene::{Needs, Scene, SceneDescription};
use crate::trace::{Caster, RayCounter};

/// A technique.
pub struct TechniqueEntry {
    /// What the registry says of it.
    pub about: About,
    /// Makes the technique with the parameters of a table, which it checks.
    pub build: fn(&toml::Table) -> Result<Box<dyn Technique>, ParameterError>,
    /// Every contender it takes, by canonical id; the method `reference` comes besides.
    pub contenders: fn() -> Vec<Listed>,
    /// What they can share an amount of, the one that single images get first.
    pub units: &'static [&'static Unit],
    /// The full method of its paper.
    pub default_method: &'static str,
    /// Parameters that the reference does not depend on.
    pub of_contenders: &'static [&'static str],
}

/// A contender of a technique, and the entries it is made of.
pub struct Listed {
    /// Canonical id of the method.
    pub id: String,
    /// A method alone, or first stage and refinement.
    pub parts: Vec<&'static About>,
}

/// A technique with its parameters set.
pub trait Technique: Send + Sync {
    /// What it reads of a scene.
    fn needs(&self) -> Needs;

    /// Whether a scene has what the technique is about.
    ///
    /// # Errors
    /// A sentence with advice.
    fn fits(&self, _: &SceneDescription) -> Result<(), String> {
        Ok(())
    }

    /// The shading function itself in one shot.
    fn shading_function<'a>(&'a self, shot: &'a Shot<'a>) -> Box<dyn ShadingFunction + 'a>;

    /// Exposure of its images in stops, for previews and display metrics: 0 for unitless values in
    /// `[0, 1]`, the scene's for radiance.
    fn exposure_stops(&self, scene: &Scene) -> f32;

    /// Samples per pixel of a complete reference for images with `spp` samples per pixel.
    fn reference_samples(&self, spp: u32) -> u32;

    /// Whether the passes of a reference are random (its spread is then its noise) or exact.
    fn reference_is_random(&self) -> bool;

    /// Rays traced for one evaluation of the function, for cost estimates.
    fn rays_per_evaluation(&self) -> u64;

    /// Rays of one sample of the reference, for cost estimates.
    fn rays_per_reference_sample(&self) -> u64 {
        1 + self.rays_per_evaluation()
    }

    /// Bytes that a record takes, for estimates of memory; 0 where there are no records.
    fn bytes_per_record(&self) -> u64 {
        0
    }

    /// Builds the contender `id` with its parameters; no ray is cast yet, so that plans are checked with it.
    ///
    /// # Errors
    /// Ids that the technique does not take, unknown and unfit parameters; the key is named.
    fn start<'a>(
        &'a self,
        id: &str,
        parameters: &toml::Table,
        terms: Terms,
    ) -> Result<Started<'a>, ParameterError>;

    /// Whether [`Technique::exposure`] depends on the first shot.
    fn decides_exposure(&self) -> bool {
        false
    }

    /// The factor on radiance that gives images a comparable exposure, decided once for each viewer of a sequence, by
    /// its first shot, and charged to nobody.
    fn exposure(&self, _first: &Shot) -> f32 {
        1.0
    }

    /// Light of a shot that all contenders share: added to each of their images, charged to none.
    fn shared_layer(&self, _: &Shot) -> Option<Image> {
        None
    }
}

/// The function that records approximate, evaluated where the camera sees it.
pub trait ShadingFunction: Sync {
    /// Sample `sample` of consecutive pixels from `first_pixel` (row-major), both given in that
    /// order; returns the number of non-finite values, which are left black.
    fn pixels(&self, caster: &Caster, first_pixel: u32, sample: u32, out: &mut [[f32; 3]]) -> u64;
}

/// Writes what `shade` says of each of consecutive pixels from `first_pixel`; values that are not finite
/// stay as they are, black, and are counted.
fn each_pixel(first_pixel: u32, out: &mut [[f32; 3]], mut shade: impl FnMut(u32) -> Vec3) -> u64 {
    let mut non_finite = 0;
    for (pixel, value) in (first_pixel..).zip(out) {
        let rgb = shade(pixel);
        if rgb.is_finite() {
            *value = rgb.into();
        } else {
            non_finite += 1;
        }
    }
    non_finite
}

/// One pass of the reference over the whole shot, and its number of non-finite values.
pub fn reference_pass(
    function: &dyn ShadingFunction,
    shot: &Shot,
    sample: u32,
    counter: &RayCounter,
) -> (Image, u64) {
    let mut image = Image::new(shot.width, shot.height);
    let non_finite = image
        .pixels
        .par_chunks_mut(shot.width)
        .enumerate()
        .map(|(y, row)| {
            let caster = shot.tracer.caster(counter);
            let first = (y * shot.width) as u32;
            function.pixels(&caster, first, sample, row)
        })
        .sum();
    (image, non_finite)
}
