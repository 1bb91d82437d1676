//! Saying of which cases of a plot seeds failed or are missing: what is drawn of them is over the others.

use super::data::{Asked, Data, SceneOf};
use super::figure::{shows_method, shows_scene};
use crate::experiment::FigureSpec;

/// As many are named; the others are counted.
const NAMED: usize = 6;

/// A sentence for the caption of a plot of the methods of a figure, in one scene or in all that it is about; empty where all
/// seeds finished, or none of a case, of which nothing is drawn.
pub fn seeds(data: &Data, spec: &FigureSpec, only: Option<&SceneOf>) -> String {
    let scenes = data.scenes.iter().filter(|scene| match only {
        Some(only) => scene.name == only.name,
        None => shows_scene(spec, scene),
    });
    let mut lacking = Vec::new();
    for scene in scenes {
        for label in data.labels().iter().filter(|l| shows_method(spec, l)) {
            for point in data.points() {
                let case = data.case(Asked {
                    scene,
                    label,
                    point,
                });
                let expected = data.cases.seeds_of(&case).count();
                let there = data.cases.rows_of(&case).count();
                if (1..expected).contains(&there) {
                    let at = match point.values.is_empty() {
                        true => String::new(),
                        false => format!(", {}", point.text()),
                    };
                    let scene = &scene.name;
                    lacking.push(format!("{label} in {scene}{at} ({there} of {expected})"));
                }
            }
        }
    }
    let more = match lacking.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    lacking.truncate(NAMED);
    match lacking.is_empty() {
        true => String::new(),
        false => format!(
            " Seeds failed or are missing: {}{more}. Their points are means over the others, and means over scenes have none.",
            lacking.join("; ")
        ),
    }
}
