//! What is computed: cached functions under a distribution of records, and the truths.
//!
//! Two seams: a [`CachedFunction`] knows how to evaluate, compare and interpolate records but not
//! where they are; a [`Distribution`] places them but not what they hold. [`cached::render`] is the
//! product of both; what a technique compares is a [`Method`].

pub mod ambient_occlusion;
pub mod cached;
mod distribution;
pub mod environment_lighting;
mod frame;
pub mod importance_caching;
pub mod irradiance_caching;
mod method;
mod passes;
mod paths;
mod per_sample;
pub mod truth;

pub use cached::{CachedFunction, CachedTechnique, Lookup, RecordSite};
pub use distribution::Distribution;
pub use frame::{Film, Frame, Missed, Seen, Site, shading_points};
pub use method::{Method, MethodEntry, OTHER_METHODS, other_method};
pub use passes::Passes;
pub use per_sample::{PER_SAMPLE, PerSample};

use glam::Vec3;
use rayon::prelude::*;

use crate::entry::{About, ParameterError};
use crate::environment::LightSet;
use crate::image::Image;
use crate::scene::{Needs, Scene};
use crate::trace::{Caster, RayCounter, RayCounts};

/// What a truth says to a contender.
const NO_CONTENDERS: &str = "this technique has one method only: reference";

/// Which methods a technique compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contenders {
    /// None: `reference` is the only method.
    None,
    /// Cache distributions, and the function itself at every sample.
    Distributions,
    /// Samplers of environment maps.
    EnvironmentSamplers,
}

/// A technique.
pub struct TechniqueEntry {
    pub about: About,
    pub build: fn(&toml::Table) -> Result<Box<dyn Technique>, ParameterError>,
    pub contenders: Contenders,
    /// Parameters that the reference does not depend on.
    pub of_contenders: &'static [&'static str],
}

/// A technique with its parameters set.
pub trait Technique: Send + Sync {
    /// What it reads of a scene.
    fn needs(&self) -> Needs;

    /// The shading function itself in one frame.
    fn shading_function<'a>(&'a self, frame: &'a Frame<'a>) -> Box<dyn ShadingFunction + 'a>;

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

    /// This technique as one of records; `None` where contenders are something else, or nothing.
    fn cached(&self) -> Option<&dyn CachedTechnique> {
        None
    }

    /// Renders one contender.
    ///
    /// # Errors
    /// A sentence, for methods that the technique does not take or that need what is not there.
    fn render(&self, frame: &Frame, contender: &Contender) -> Result<Rendered, String> {
        match self.cached() {
            Some(technique) => cached::render(technique, frame, contender),
            None => Err(NO_CONTENDERS.into()),
        }
    }

    /// What went into one pixel (row-major index) of a contender, a line each.
    ///
    /// # Errors
    /// As [`Technique::render`].
    fn replay(
        &self,
        frame: &Frame,
        contender: &Contender,
        pixel: u32,
    ) -> Result<Vec<String>, String> {
        match self.cached() {
            Some(technique) => cached::replay(technique, frame, contender, pixel),
            None => Err(NO_CONTENDERS.into()),
        }
    }
}

/// The function that records approximate, evaluated where the camera sees it.
pub trait ShadingFunction: Sync {
    /// Sample `sample` of consecutive pixels from `first_pixel` (row-major), both given in that
    /// order; returns the number of non-finite values, which are left black.
    fn pixels(
        &self,
        caster: &Caster,
        first_pixel_and_sample: (u32, u32),
        out: &mut [[f32; 3]],
    ) -> u64;
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

/// One pass of the reference over the whole frame, and its number of non-finite values.
pub fn reference_pass(
    function: &dyn ShadingFunction,
    frame: &Frame,
    sample: u32,
    counter: &RayCounter,
) -> (Image, u64) {
    let mut image = Image::new(frame.width, frame.height);
    let non_finite = image
        .pixels
        .par_chunks_mut(frame.width)
        .enumerate()
        .map(|(y, row)| {
            let caster = frame.tracer.caster(counter);
            let first = (y * frame.width) as u32;
            function.pixels(&caster, (first, sample), row)
        })
        .sum();
    (image, non_finite)
}

/// What a contender has to work with.
pub struct Contender<'a> {
    pub method: &'a Method,
    /// What the contenders of the technique share: records, or shadow rays per shading point.
    pub budget: usize,
    pub seed: u64,
    /// For settings that the paper picks by error (SD's minimum cluster size).
    pub reference: Option<&'a Image>,
}

/// A record of a finished job.
#[derive(Clone, Copy, Debug)]
pub struct PlacedRecord {
    pub site: Site,
    /// Row-major pixel index.
    pub pixel: u32,
    /// 0 first stage, 1 refinement.
    pub stage: u8,
}

/// What a contender produced.
#[derive(Clone, Debug, Default)]
pub struct Rendered {
    pub image: Image,
    pub records: Vec<PlacedRecord>,
    /// The lights of a global light set.
    pub lights: Option<LightSet>,
    /// The map that guided the refinement, row-major, if there was one.
    pub discontinuity: Option<Vec<f32>>,
    pub rays: RayCounts,
    pub lookups: u64,
    pub bytes_peak: usize,
    pub stages: Stages,
    /// Found parameters (σ_s, chosen cluster size, …).
    pub found: Vec<(&'static str, f64)>,
    pub notes: Vec<String>,
    pub non_finite: u64,
}

/// Seconds of each stage, in order of first execution.
#[derive(Clone, Debug, Default)]
pub struct Stages(pub Vec<(&'static str, f64)>);

impl Stages {
    /// Runs `work` and adds its wall time to the stage.
    pub fn time<T>(&mut self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        let start = std::time::Instant::now();
        let result = work();
        let seconds = start.elapsed().as_secs_f64();
        match self.0.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, total)) => *total += seconds,
            None => self.0.push((stage, seconds)),
        }
        result
    }

    pub fn total(&self) -> f64 {
        self.0.iter().map(|(_, seconds)| seconds).sum()
    }
}
