//! EVERY: shading points at equal steps, in the order of pixels.

use super::pick::choice;
use super::{FirstStage, FirstStageEntry, Placement};
use crate::cache::ShadingPoints;
use crate::entry::{About, Bias, parameters};

parameters! {
    /// Shading points at equal steps.
    #[derive(Clone, Copy, Debug)]
    pub struct EveryNth {
        /// Where the first one lies, as a share of a step.
        start: f64 = 0.5, Within(0.0, 1.0), "steps";
    }
}

/// Registry entry.
pub const ENTRY: FirstStageEntry = FirstStageEntry {
    about: About {
        id: "EVERY",
        module: crate::entry::head_comment!("example.rs"),
        aliases: &["every-nth"],
        summary: "shading points at equal steps, in the order of pixels",
        source: "docs/adding.md",
        bias: Bias::Consistent,
        version: 1,
        failures: &["records line up in columns where a step is a whole number of rows"],
        parameters: EveryNth::PARAMETERS,
    },
    build: |table| Ok(Box::new(EveryNth::read(table)?)),
};

impl FirstStage for EveryNth {
    fn place(&self, points: &ShadingPoints, count: usize, _seed: u64) -> Placement {
        // Points with a finite position, or all of them where there are no more than `count`.
        let usable = match choice(points, count) {
            Ok(usable) => usable,
            Err(all) => return all,
        };
        let step = usable.len() as f64 / count as f64;
        let site = |i: usize| usable[((i as f64 + self.start) * step) as usize % usable.len()];
        Placement {
            sites: (0..count).map(site).collect(),
            found: vec![("step", step)], // A number for the row, under `params`.
            ..Placement::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn as_many_distinct_points_as_asked_for() {
        let points = ShadingPoints {
            position: vec![Vec3::ZERO; 100],
            normal: vec![Vec3::Y; 100],
            depth: vec![1.0; 100],
            ..ShadingPoints::default()
        };
        for start in [0.0, 0.5, 1.0] {
            let table = toml::Table::from_iter([("start".to_owned(), start.into())]);
            let placement = (ENTRY.build)(&table).expect("in range");
            for count in [1, 7, 99, 100, 200] {
                let mut sites = placement.place(&points, count, 1).sites;
                sites.sort_unstable();
                sites.dedup();
                assert_eq!(sites.len(), count.min(100), "{start} {count}");
            }
        }
        assert!(ENTRY.about.answers_to("every-nth"));
    }
}
