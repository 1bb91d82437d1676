//! IM: image-space uniform sampling.
//!
//! Records lie at shading points drawn uniformly without repetition, or jittered: one in each cell of a
//! grid over the image.

use super::pick::{STREAM_CELLS, STREAM_UNIFORM, adjust, choice, keep_random};
use super::{FirstStage, Placement};
use crate::cache::{NO_POINT, ShadingPoints};
use crate::entry::{About, Bias, parameters, words};
use crate::placement::FirstStageEntry;
use crate::sample::Rng;

words! {
    /// How pixels are drawn.
    pub enum Pattern {
        /// Uniform random distinct pixels.
        Random = "random",
        /// One random pixel in each cell of a grid, then trimmed or filled up at random.
        Jittered = "jittered",
    }
}

parameters! {
    /// Distinct pixels with a shading point, drawn without regard to geometry.
    #[derive(Clone, Copy, Debug)]
    pub struct ImageSpace {
        /// Random, or jittered: one pixel per cell of a grid over the image, then trimmed or filled up at
        /// random to the exact count.
        pub pattern: Pattern = Pattern::Random;
    }
}

/// Registry entry.
pub const ENTRY: FirstStageEntry = FirstStageEntry {
    about: About {
        id: "IM",
        module: crate::entry::head_comment!("im.rs"),
        aliases: &["image-space", "uniform"],
        summary: "uniform random distinct pixels",
        source: "Wu & Shen 2023, section 4 (baseline IM); Georgiev et al. 2012",
        bias: Bias::Consistent,
        version: 1,
        failures: &[
            "Knows nothing of geometry: thin parts and distant curved surfaces get too few records.",
            "The random pattern clumps and leaves holes; pattern = \"jittered\" mends that only.",
        ],
        parameters: ImageSpace::PARAMETERS,
    },
    build: |table| Ok(Box::new(ImageSpace::read(table)?)),
};

impl FirstStage for ImageSpace {
    fn place(&self, points: &ShadingPoints, count: usize, seed: u64) -> Placement {
        let mut usable = match choice(points, count) {
            Ok(usable) => usable,
            Err(all) => return all,
        };
        if self.pattern == Pattern::Random {
            let mut rng = Rng::new(seed, STREAM_UNIFORM, 0, 0);
            keep_random(&mut usable, count, &mut rng);
            return Placement {
                sites: usable,
                ..Placement::default()
            };
        }
        let mut sites = one_per_cell(points, &usable, count, seed);
        let added = adjust(&mut sites, &usable, count, seed);
        Placement {
            sites,
            found: vec![("adjusted", added as f64)],
            notes: Vec::new(),
            map: None,
        }
    }
}

/// A random usable point of each square cell that has one; a cell holds as many pixels as there
/// are points per record.
fn one_per_cell(points: &ShadingPoints, usable: &[u32], count: usize, seed: u64) -> Vec<u32> {
    let side = (usable.len() as f64 / count as f64).sqrt().max(1.0);
    let columns = (points.width as f64 / side).ceil().max(1.0) as usize;
    let rows = (points.height as f64 / side).ceil().max(1.0) as usize;
    let cell = |point: u32| {
        let pixel = points.pixel[point as usize] as usize;
        let (x, y) = (pixel % points.width.max(1), pixel / points.width.max(1));
        let column = ((x as f64 + 0.5) / side) as usize;
        let row = ((y as f64 + 0.5) / side) as usize;
        row.min(rows - 1) * columns + column.min(columns - 1)
    };
    let mut chosen = vec![(0u32, NO_POINT); columns * rows];
    for &point in usable {
        // Reservoir of one: each point of a cell stays with equal probability.
        let index = cell(point);
        let (seen, kept) = &mut chosen[index];
        *seen += 1;
        let mut rng = Rng::new(seed, STREAM_CELLS, index as u64, u64::from(*seen));
        if rng.below(*seen as usize) == 0 {
            *kept = point;
        }
    }
    let kept = chosen.into_iter().map(|(_, point)| point);
    kept.filter(|&point| point != NO_POINT).collect()
}
