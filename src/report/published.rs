//! The paper's numbers, found for our cells.

use super::data::{Asked, Data, SceneOf};
use crate::experiment::{EVERY_SCENE, Published, Swept};

impl Data {
    /// The paper's number for a column of a method in a scene at a swept value.
    ///
    /// A number without `at` belongs to experiments without a sweep.
    pub fn published(&self, asked: Asked, column: &str) -> Option<f64> {
        let Asked {
            scene,
            label,
            point,
        } = asked;
        self.config
            .published
            .iter()
            .filter(|p| p.method == label && is_scene(p, scene) && self.is_point(p, point))
            .find_map(|p| value_of(p, column))
    }

    /// Whether any number of the paper stands beside a column in a scene.
    pub fn has_published(&self, scene: &SceneOf, column: &str) -> bool {
        self.labels().iter().any(|label| {
            self.points().iter().any(|point| {
                self.published(
                    Asked {
                        scene,
                        label,
                        point,
                    },
                    column,
                )
                .is_some()
            })
        })
    }

    /// Where the numbers that belong to a scene were printed, each place once.
    pub fn places_of(&self, scene: &SceneOf) -> Vec<&str> {
        let mut places = Vec::new();
        for p in self.config.published.iter().filter(|p| is_scene(p, scene)) {
            if !places.contains(&p.place.as_str()) {
                places.push(p.place.as_str());
            }
        }
        places
    }

    /// Published numbers that stand beside nothing, a sentence each.
    pub fn unplaced(&self) -> Vec<String> {
        let placed = |p: &Published| {
            self.labels().contains(&p.method)
                && (p.scene == EVERY_SCENE || self.scenes.iter().any(|s| is_scene(p, s)))
                && self.points().iter().any(|point| self.is_point(p, point))
        };
        self.config
            .published
            .iter()
            .filter(|p| !placed(p))
            .map(|p| {
                format!(
                    "the paper's numbers of {} in {} ({}) belong to no job of this plan",
                    p.method, p.scene, p.place
                )
            })
            .collect()
    }

    fn is_point(&self, published: &Published, point: &Swept) -> bool {
        if published.at.is_empty() {
            return !self.swept();
        }
        published.at.iter().all(|(key, wanted)| {
            let found = point.number_of(key);
            found.is_some_and(|v| (v - wanted).abs() <= 1e-9 * wanted.abs())
        })
    }
}

fn is_scene(published: &Published, scene: &SceneOf) -> bool {
    published.scene == scene.name || scene.paper.as_deref() == Some(published.scene.as_str())
}

fn value_of(published: &Published, column: &str) -> Option<f64> {
    let alias = match column {
        "flip" => "flip_ldr",
        "flip_ldr" => "flip",
        _ => column,
    };
    let values = &published.values;
    values.get(column).or_else(|| values.get(alias)).copied()
}
