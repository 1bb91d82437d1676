//! What tells rows apart: the case. Rows of one case differ in their seed alone, which is the repeat.

use std::collections::{BTreeMap, HashSet};
use std::fmt;

use serde_json::Value;

use super::{Job, Row};

/// A scene seen from one of its views.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Place {
    /// What rows call it: the config's label, or its name.
    pub scene: String,
    /// A view by name, or the paths that viewers follow.
    pub view: String,
}

/// Swept keys and their values, sorted by key; empty without a sweep.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Swept {
    /// Key and value, a key once.
    pub values: Vec<(String, Value)>,
}

/// Everything that a row can differ in but its seed.
///
/// Tables, figures, claims, gates and comparisons of runs group rows by it, and no two jobs of a plan
/// have the same case and seed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Case {
    /// What is seen.
    pub place: Place,
    /// Canonical id of what is computed.
    pub technique: String,
    /// What tables call the contender.
    pub label: String,
    /// Where in the sweep it lies.
    pub swept: Swept,
}

impl Case {
    /// The case that a job's row will have.
    pub fn of_job(job: &Job) -> Self {
        Self {
            place: Place {
                scene: job.scene.clone(),
                view: job.view.clone(),
            },
            technique: job.technique.clone(),
            label: job.label.clone(),
            swept: Swept::of_job(job),
        }
    }

    /// The case that a job's row will have, and those for which it stands as well.
    pub fn all_of_job(job: &Job) -> impl Iterator<Item = Self> {
        let own = Self::of_job(job);
        let at = move |values| Self {
            swept: Swept::of_values(values),
            ..own.clone()
        };
        std::iter::once(&job.sweep).chain(&job.also_at).map(at)
    }

    /// The case of a row.
    pub fn of_row(row: &Row) -> Self {
        Self {
            place: Place {
                scene: row.scene.clone(),
                view: row.view.clone(),
            },
            technique: row.technique.clone(),
            label: row.label.clone(),
            swept: Swept::of(row.sweep.iter().map(|(k, v)| (k.clone(), v.clone()))),
        }
    }
}

/// `kitchen (top), ambient-occlusion, VGC, caches=100`: for messages.
impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Place { scene, view } = &self.place;
        write!(f, "{scene} ({view}), {}, {}", self.technique, self.label)?;
        match self.swept.values.is_empty() {
            true => Ok(()),
            false => write!(f, ", {}", self.swept.text()),
        }
    }
}

impl Swept {
    /// Swept keys and values in any order.
    pub fn of(values: impl Iterator<Item = (String, Value)>) -> Self {
        let mut values: Vec<_> = values.collect();
        values.sort_by(|a, b| a.0.cmp(&b.0));
        Self { values }
    }

    /// What was swept for a job.
    pub fn of_job(job: &Job) -> Self {
        Self::of_values(&job.sweep)
    }

    fn of_values(values: &BTreeMap<String, toml::Value>) -> Self {
        let values = values.iter();
        Self::of(values.map(|(key, value)| (key.clone(), as_in_rows(value))))
    }

    /// `caches=100 ratio=0.5`; empty without a sweep.
    pub fn text(&self) -> String {
        let parts: Vec<String> = self
            .values
            .iter()
            .map(|(k, v)| format!("{k}={}", value_text(v)))
            .collect();
        parts.join(" ")
    }

    /// The value of a key as text.
    pub fn text_of(&self, key: &str) -> Option<String> {
        let found = self.values.iter().find(|(k, _)| k == key);
        found.map(|(_, value)| value_text(value))
    }

    /// The value of a key that is a number.
    pub fn number_of(&self, key: &str) -> Option<f64> {
        let found = self.values.iter().find(|(k, _)| k == key);
        found.and_then(|(_, value)| value.as_f64())
    }

    /// Without some of its keys.
    pub fn without(&self, leaves_out: impl Fn(&str) -> bool) -> Self {
        let kept = self.values.iter().filter(|(key, _)| !leaves_out(key));
        Self {
            values: kept.cloned().collect(),
        }
    }

    /// The values alone.
    pub fn short(&self) -> String {
        let parts: Vec<String> = self.values.iter().map(|(_, v)| value_text(v)).collect();
        parts.join(", ")
    }

    /// The swept keys.
    pub fn keys(&self) -> String {
        let keys: Vec<&str> = self.values.iter().map(|(k, _)| k.as_str()).collect();
        keys.join(", ")
    }
}

/// A value of a config as rows have it.
pub(super) fn as_in_rows(value: &toml::Value) -> Value {
    serde_json::to_value(value).unwrap_or(Value::Null)
}

pub(super) fn value_text(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

/// A place as tables, figures and claims call it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedPlace {
    /// As rows have it.
    pub place: Place,
    /// The scene's name where one view of it occurs, else `scene (view)`.
    pub name: String,
    /// The paper's name of the scene.
    pub paper: Option<String>,
}

impl NamedPlace {
    /// Whether `name` is its name, its scene's or the paper's.
    pub fn is_called(&self, name: &str) -> bool {
        self.name == name || self.place.scene == name || self.paper.as_deref() == Some(name)
    }
}

/// Names places: each once, in the order in which they come.
pub fn name_places(places: impl Iterator<Item = (Place, Option<String>)>) -> Vec<NamedPlace> {
    let mut named: Vec<NamedPlace> = Vec::new();
    let mut known = HashSet::new();
    for (place, paper) in places {
        if known.insert(place.clone()) {
            let name = place.scene.clone();
            named.push(NamedPlace { place, name, paper });
        }
    }
    for index in 0..named.len() {
        let Place { scene, view } = &named[index].place;
        let views = named.iter().filter(|other| other.place.scene == *scene);
        if views.count() > 1 {
            named[index].name = format!("{scene} ({view})");
        }
    }
    named
}

/// The place that `LABEL@name` speaks of: none where there is none, or several views, of that name.
pub fn place_named<'a>(places: &'a [NamedPlace], name: &str) -> Option<&'a NamedPlace> {
    places.iter().find(|place| place.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(scene: &str, view: &str) -> (Place, Option<String>) {
        let (scene, view) = (scene.into(), view.into());
        (Place { scene, view }, None)
    }

    #[test]
    fn a_view_is_named_where_its_scene_has_several() {
        let places = [
            place("kitchen", "top"),
            place("atrium", "main"),
            place("kitchen", "front"),
            place("kitchen", "top"),
        ];
        let named = name_places(places.into_iter());
        let names: Vec<&str> = named.iter().map(|n| n.name.as_str()).collect();
        assert_eq!(names, ["kitchen (top)", "atrium", "kitchen (front)"]);
        assert!(place_named(&named, "kitchen").is_none());
        let front = place_named(&named, "kitchen (front)").expect("named");
        assert!(front.is_called("kitchen") && !front.is_called("atrium"));
    }

    #[test]
    fn swept_values_are_the_same_in_any_order() {
        let swept = |keys: [(&str, i64); 2]| {
            Swept::of(keys.into_iter().map(|(k, v)| (k.to_owned(), v.into())))
        };
        let one = swept([("spp", 4), ("caches", 100)]);
        assert_eq!(one, swept([("caches", 100), ("spp", 4)]));
        assert_eq!(one.text(), "caches=100 spp=4");
        assert_eq!(
            (one.short(), one.keys()),
            ("100, 4".into(), "caches, spp".into())
        );
    }
}
