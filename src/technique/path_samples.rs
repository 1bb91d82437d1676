//! The contender `paths` of path tracing and direct lighting: a number of paths through each pixel of a frame, without memory.

use super::truth::{TracedPaths, Truth};
use super::{Contender, ContenderEntry, Passes, Rendered, Shot};
use crate::entry::{About, Bias, parameters};
use crate::trace::RayCounter;

/// Entry in the list of their contenders.
pub const ENTRY: ContenderEntry<Truth> = ContenderEntry {
    about: About {
        id: "paths",
        module: crate::entry::head_comment!("path_samples.rs"),
        aliases: &["samples"],
        summary: "as many paths through each pixel as the budget has samples, each frame anew",
        source: "Kajiya 1986; Veach 1997, power heuristic",
        bias: Bias::Unbiased,
        version: 3,
        failures: &["noise falls with the square root of the samples only"],
        parameters: Parameters::PARAMETERS,
    },
    start: |technique, table, terms| {
        let parameters = Parameters::read(table)?;
        Ok(Box::new(PathSamples {
            technique,
            times: parameters.times,
            samples: terms.budget as u32 * parameters.times,
            seed: terms.seed,
        }))
    },
};

parameters! {
    #[derive(Clone, Copy, Debug)]
    struct Parameters {
        /// Paths for each that the budget grants: how many times as many a cache is worth.
        times: u32 = 1, Within(1.0, 65536.0);
    }
}

struct PathSamples<'a> {
    technique: &'a Truth,
    times: u32,
    /// Paths of a pixel.
    samples: u32,
    seed: u64,
}

impl Contender for PathSamples<'_> {
    fn times(&self) -> f64 {
        self.times.into()
    }

    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        let samples = self.samples;
        let render = |shot: &Shot| {
            // Each frame takes other paths, or its noise would stick to the screen.
            let first = shot.frame.wrapping_mul(samples);
            let paths = self.technique.contender_paths(shot, self.seed);
            sampled(shot, &paths, first, samples)
        };
        Ok(shots.iter().map(render).collect())
    }
}

/// The mean of `count` paths through each pixel, from number `first` on.
pub(super) fn sampled(shot: &Shot, paths: &TracedPaths, first: u32, count: u32) -> Rendered {
    let mut rendered = Rendered::default();
    let counter = RayCounter::default();
    let mut passes = Passes::starting_at(first, shot, paths);
    rendered.stages.time("rendering", || {
        (0..count).for_each(|_| passes.add(&counter));
    });
    rendered.image = passes.mean();
    rendered.non_finite = passes.non_finite;
    rendered.notes.extend(passes.note());
    rendered.rays = counter.read();
    rendered
}
