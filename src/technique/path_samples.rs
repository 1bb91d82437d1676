//! The contender `paths` of path tracing and direct lighting: a number of paths through each pixel of a frame, without memory.

use super::truth::{TracedPaths, Truth};
use super::{Contender, ContenderEntry, Passes, Rendered, Shot, Terms};
use crate::entry::{About, Bias, check_keys};
use crate::trace::RayCounter;

/// Entry in the list of their contenders.
pub const ENTRY: ContenderEntry<Truth> = ContenderEntry {
    about: About {
        id: "paths",
        module: include_str!("path_samples.rs"),
        aliases: &["samples"],
        summary: "as many paths through each pixel as the budget has samples, each frame anew",
        source: "Kajiya 1986; Veach 1997, power heuristic",
        bias: Bias::Unbiased,
        version: 1,
        failures: &["noise falls with the square root of the samples only"],
        parameters: &[],
    },
    start: |technique, table, terms| {
        check_keys(table, &[])?;
        Ok(Box::new(PathSamples { technique, terms }))
    },
};

struct PathSamples<'a> {
    technique: &'a Truth,
    terms: Terms,
}

impl Contender for PathSamples<'_> {
    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        let samples = self.terms.budget as u32;
        let render = |shot| {
            sampled(
                shot,
                &self.technique.contender_paths(shot, self.terms.seed),
                0,
                samples,
            )
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
    rendered.rays = counter.read();
    rendered
}
