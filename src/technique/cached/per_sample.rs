//! The contender without records: the function itself, estimated at every camera sample.
//!
//! Passes of one random estimate a pixel are added until the counted rays reach those that evaluating the
//! budget's records would take: one path (irradiance), one occlusion ray (ambient occlusion), and one
//! virtual light or path (importance caching) a pass.

use super::function::CachedTechnique;
use crate::cache::Interpolation;
use crate::entry::{About, Bias, parameters};
use crate::memory::released;
use crate::technique::{
    Clock, Contender, ContenderEntry, Passes, Rendered, Search, Seen, Shot, Terms, shading_points,
};
use crate::trace::{RayCounter, RayCounts};

parameters! {
    #[derive(Clone, Copy, Debug)]
    struct Parameters {
        /// Estimates of each pixel; without it passes are added until the rays counted reach those of evaluating
        /// the budget's records, measured on 64 of them.
        passes: Option<u32> = None, Within(1.0, u32::MAX as f64);
    }
}

/// The registry's entry.
pub const PER_SAMPLE: ContenderEntry<dyn CachedTechnique> = ContenderEntry {
    about: About {
        id: "per-sample",
        module: crate::entry::head_comment!("per_sample.rs"),
        aliases: &["path-tracing", "monte-carlo"],
        summary: "no records: the function itself, estimated at every camera sample with as many \
                  rays as the records would take",
        source: "the outside contender of cached techniques: path tracing for irradiance, random \
                 occlusion rays for ambient occlusion, one virtual light by its power or one \
                 path for importance",
        bias: Bias::Unbiased,
        version: 3,
        failures: &["noise falls with the square root of the rays only"],
        parameters: Parameters::PARAMETERS,
    },
    start: |technique, table, terms| {
        Ok(Box::new(PerSample {
            technique,
            parameters: Parameters::read(table)?,
            terms,
        }))
    },
};

/// The contender: no records, the function estimated at every camera sample with few random samples.
struct PerSample<'a> {
    technique: &'a dyn CachedTechnique,
    parameters: Parameters,
    terms: Terms,
}

/// Records whose cost tells what the budget's records would take.
const MEASURED: usize = 64;
/// The golden ratio less 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Passes end here however cheap they are.
const MOST_PASSES: u32 = 1 << 16;

impl Contender for PerSample<'_> {
    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        Ok(shots.iter().map(|shot| self.render(shot)).collect())
    }
}

impl PerSample<'_> {
    /// Adds passes until their number, or the rays of the budget, are reached.
    fn render(&self, shot: &Shot) -> Rendered {
        let mut rendered = Rendered::default();
        let mut budget = u64::MAX;
        if self.parameters.passes.is_none() {
            let clock = Clock::start();
            let (records, rays) = self.rays_of_records(shot);
            rendered.search = Search {
                seconds: clock.seconds(),
                rays,
            };
            rendered.found.push(("rays_of_records", records as f64));
            budget = records;
        }
        let most = self.parameters.passes.unwrap_or(MOST_PASSES);
        let counter = RayCounter::default();
        let function = self.technique.estimator(shot, self.terms.seed);
        let mut passes = Passes::new(shot, function.as_ref());
        while passes.count() < most && (passes.count() == 0 || counter.read().all() < budget) {
            rendered.stages.time("rendering", || passes.add(&counter));
        }
        rendered.image = passes.mean();
        rendered.non_finite = passes.non_finite;
        rendered.notes.extend(passes.note());
        rendered.rays = counter.read();
        rendered.found.push(("passes", f64::from(passes.count())));
        rendered.bytes_cache = released(function);
        rendered
    }

    /// Rays that the budget's records would take: the mean of records spread over the view by the golden
    /// ratio (an even stride may run along a column of pixels); and the rays that finding out took. The
    /// camera rays of shading points and of the image are not among the former.
    fn rays_of_records(&self, shot: &Shot) -> (u64, RayCounts) {
        let counter = RayCounter::default();
        let points = shading_points(shot, &counter);
        let mut spent = counter.read();
        let count = MEASURED.min(points.len());
        let place = |i: usize| (i as f64 * GOLDEN).fract() * points.len() as f64;
        let sites: Vec<Seen> = (0..count)
            .map(|i| Seen::of(&points, place(i) as u32))
            .collect();
        let counter = RayCounter::default();
        let (interpolation, seed) = (Interpolation::default(), self.terms.seed);
        let (mut records, _) = self.technique.function(shot, interpolation, seed);
        records.evaluate(&sites, &counter);
        let rays = counter.read();
        spent += rays;
        let mean = rays.all() as f64 / count.max(1) as f64;
        let records = (mean * self.terms.budget.min(points.len()) as f64).round();
        (records as u64, spent)
    }
}
