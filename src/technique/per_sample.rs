//! The contender without records: the function itself, estimated at every camera sample.
//!
//! Passes of one random estimate a pixel are added until the counted rays reach those that evaluating the
//! budget's records would take: one path (irradiance), one occlusion ray (ambient occlusion), and one
//! virtual light or path (importance caching) a pass.

use serde::Deserialize;

use super::cached::CachedTechnique;
use super::{Contender, Frame, Method, Passes, RecordSite, Rendered, Stages, shading_points};
use crate::cache::Interpolation;
use crate::entry::{About, Bias, Parameter};
use crate::technique::MethodEntry;
use crate::trace::RayCounter;

/// The outside contender of cached techniques: no records, the function estimated at every camera
/// sample with few random samples.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PerSample {
    /// Estimates of each pixel; `None` takes as many as cost the rays of the budget's records.
    pub passes: Option<std::num::NonZeroU32>,
}

/// The registry's entry.
pub const PER_SAMPLE: MethodEntry = MethodEntry {
    about: About {
        id: "per-sample",
        module: include_str!("per_sample.rs"),
        aliases: &["path-tracing", "monte-carlo"],
        summary: "no records: the function itself, estimated at every camera sample with as many \
                  rays as the records would take",
        source: "the outside contender of cached techniques: path tracing for irradiance, random \
                 occlusion rays for ambient occlusion, one virtual light by its power or one \
                 path for importance",
        bias: Bias::Unbiased,
        version: 1,
        failures: &["noise falls with the square root of the rays only"],
        parameters: &[Parameter {
            key: "passes",
            default: "equal rays",
            unit: "",
            meaning: "estimates of each pixel; by default passes are added until the rays counted \
                      reach those of evaluating the budget's records, measured on 64 of them",
        }],
    },
    techniques: &[
        "ambient-occlusion",
        "irradiance-caching",
        "importance-caching",
    ],
    build: |table| Ok(Method::PerSample(crate::entry::parameters(table)?)),
};

/// Records whose cost tells what the budget's records would take.
const MEASURED: usize = 64;
/// The golden ratio less 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Passes end here however cheap they are.
const MOST_PASSES: u32 = 1 << 16;

/// Adds passes until their number, or the rays of the budget, are reached.
pub(super) fn render(
    technique: &dyn CachedTechnique,
    frame: &Frame,
    contender: &Contender,
    method: &PerSample,
) -> Result<Rendered, String> {
    let mut rendered = Rendered::default();
    let mut stages = Stages::default();
    let budget = match method.passes {
        Some(_) => u64::MAX,
        None => rays_of_records(technique, frame, contender)?,
    };
    let most = method.passes.map_or(MOST_PASSES, |passes| passes.get());
    let counter = RayCounter::default();
    let function = technique.estimator(frame, contender.seed);
    let mut passes = Passes::new(frame, function.as_ref());
    let mut spent = 0;
    while passes.count < most && (passes.count == 0 || spent < budget) {
        stages.time("rendering", || passes.add(&counter));
        let rays = counter.read();
        spent = rays.closest + rays.shadow;
    }
    rendered.image = passes.mean();
    rendered.non_finite = passes.non_finite;
    rendered.rays = counter.read();
    rendered.bytes_peak = frame.tracer.bytes() + passes.bytes();
    rendered.stages = stages;
    rendered.found.push(("passes", f64::from(passes.count)));
    if budget != u64::MAX {
        rendered.found.push(("rays_of_records", budget as f64));
    }
    Ok(rendered)
}

/// Rays that the budget's records would take: the mean of records spread over the view by the golden
/// ratio (an even stride may run along a column of pixels). The
/// camera rays of shading points and of the image are not counted.
fn rays_of_records(
    technique: &dyn CachedTechnique,
    frame: &Frame,
    contender: &Contender,
) -> Result<u64, String> {
    let points = shading_points(frame, &RayCounter::default());
    let count = MEASURED.min(points.len());
    let place = |i: usize| (i as f64 * GOLDEN).fract() * points.len() as f64;
    let sites: Vec<RecordSite> = (0..count)
        .map(|i| RecordSite::of(&points, place(i) as u32))
        .collect();
    let counter = RayCounter::default();
    let how = (Interpolation::default(), contender.seed);
    let (mut records, _) = technique.function(frame, how)?;
    records.evaluate(&sites, &counter);
    let rays = counter.read();
    let mean = (rays.closest + rays.shadow) as f64 / count.max(1) as f64;
    Ok((mean * contender.budget.min(points.len()) as f64).round() as u64)
}
