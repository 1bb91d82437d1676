//! What the contenders of an experiment share.

use std::collections::BTreeMap;
use std::fmt;

use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};

use super::config::{Config, SceneChoice};
use crate::technique::{TechniqueEntry, UNITS, Unit};

/// An amount that the contenders of an experiment share. It is written as `{"caches": 60}`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "BTreeMap<String, f64>")]
pub struct Budget {
    /// What is counted or timed.
    pub unit: &'static Unit,
    /// Whole, unless the unit is one that is spent.
    pub amount: f64,
}

/// How an experiment and its scenes write each unit.
type Reader = (
    &'static str,
    fn(&Config) -> Option<f64>,
    fn(&SceneChoice) -> Option<f64>,
);

macro_rules! readers {
    ($($key:ident),*) => {
        &[$((
            stringify!($key),
            |config| config.$key.map(|amount| amount as f64),
            |scene| scene.$key.map(|amount| amount as f64),
        )),*]
    };
}

static READERS: &[Reader] = readers![caches, lights, samples, seconds, rays_per_pixel];

/// What is written of a unit for a scene: its own amount, or the experiment's.
fn written(unit: &Unit, config: &Config, choice: &SceneChoice) -> Option<f64> {
    let (_, of_config, of_scene) = READERS.iter().find(|(key, ..)| *key == unit.key)?;
    of_scene(choice).or(of_config(config))
}

impl Budget {
    /// Records, paths or shadow rays; `None` where they follow from what is spent.
    pub fn count(self) -> Option<u64> {
        self.unit.spending.is_none().then_some(self.amount as u64)
    }

    /// The budget of one scene; an error names the key at fault. `usual` is the amount where none is
    /// written; without it one must be.
    pub(super) fn of(
        technique: &TechniqueEntry,
        config: &Config,
        choice: &SceneChoice,
        usual: Option<f64>,
    ) -> Result<Self, (&'static str, String)> {
        let amount = |unit: &&'static Unit| Some((*unit, written(unit, config, choice)?));
        let given: Vec<(&'static Unit, f64)> = UNITS.iter().filter_map(amount).collect();
        if let Some((unit, _)) = given.iter().find(|(u, _)| !technique.units.contains(u)) {
            let takes: Vec<String> = (technique.units.iter())
                .map(|unit| format!("`{}`", unit.key))
                .collect();
            let takes = match takes.as_slice() {
                [others @ .., last] if !others.is_empty() => {
                    format!("{} or {last}", others.join(", "))
                }
                all => all.concat(),
            };
            let message = format!(
                "{} takes {takes}, not `{}`, as its budget",
                technique.about.id, unit.key
            );
            return Err((unit.key, message));
        }
        if let [_, (second, _), ..] = given.as_slice() {
            let keys: Vec<&str> = given.iter().map(|(unit, _)| unit.key).collect();
            let message = format!(
                "two budgets, `{}`: expected one of them, for the experiment and its scenes alike",
                keys.join("` and `")
            );
            return Err((second.key, message));
        }
        let none = (technique.units[0], usual.unwrap_or(0.0));
        let (unit, amount) = given.first().copied().unwrap_or(none);
        let budget = Self { unit, amount };
        budget.check().map_err(|message| (unit.key, message))?;
        Ok(match unit.is_of_image {
            true => budget.scaled(config.scale.0 * config.scale.0),
            false => budget,
        })
    }

    fn check(self) -> Result<(), String> {
        let (key, amount, most) = (self.unit.key, self.amount, self.unit.most);
        match amount > 0.0 && amount <= most {
            true => Ok(()),
            false if self.unit.spending.is_some() || amount > most => {
                Err(format!("{key}: expected a number above 0 and up to {most}"))
            }
            false => Err(format!(
                "no number of {key}: set `{key}` for the experiment or the scene"
            )),
        }
    }

    /// For an image of this share of the pixels.
    fn scaled(self, share: f64) -> Self {
        let amount = (self.amount * share).round().max(1.0);
        Self { amount, ..self }
    }
}

impl fmt::Display for Budget {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}={}", self.unit.key, self.amount)
    }
}

impl Serialize for Budget {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(1))?;
        match self.count() {
            Some(count) => map.serialize_entry(self.unit.key, &count)?,
            None => map.serialize_entry(self.unit.key, &self.amount)?,
        }
        map.end()
    }
}

impl TryFrom<BTreeMap<String, f64>> for Budget {
    type Error = String;

    fn try_from(written: BTreeMap<String, f64>) -> Result<Self, String> {
        let (key, &amount) = written.first_key_value().ok_or("expected a budget")?;
        let unit = UNITS.into_iter().find(|unit| unit.key == key.as_str());
        let unit = unit.ok_or_else(|| format!("no budget is called `{key}`"))?;
        Ok(Self { unit, amount })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::TECHNIQUES;

    #[test]
    fn every_unit_is_read_from_experiments_and_scenes_and_written() {
        for unit in UNITS {
            let technique = TECHNIQUES.iter().find(|t| t.units.contains(&unit));
            let technique = technique.expect("a technique takes it");
            let read = |of_config: &str, of_scene: &str| {
                let text = format!(
                    "name = 'x'\ntechnique = 'x'\nmethod = []\n{of_config}\n[[scene]]\nname = 's'\n{of_scene}"
                );
                let config: Config = toml::from_str(&text).expect("a config");
                Budget::of(technique, &config, &config.scene[0], None)
            };
            let line = |amount: u32| format!("{} = {amount}", unit.key);
            let budget = read(&line(7), "").expect("a budget");
            assert_eq!(budget, Budget { unit, amount: 7.0 });
            assert_eq!(read(&line(7), &line(8)).map(|b| b.amount), Ok(8.0));
            assert_eq!(read(&line(0), "").map_err(|(key, _)| key), Err(unit.key));
            let beyond = format!("{} = {}", unit.key, unit.most as u64 + 1);
            let (_, told) = read(&beyond, "").expect_err("too much");
            assert!(told.contains("up to"), "{told}");
            assert_eq!(budget.to_string(), format!("{}=7", unit.key));
            let json = serde_json::to_string(&budget).expect("writes");
            let amount = if unit.spending.is_some() { "7.0" } else { "7" };
            assert_eq!(json, format!("{{\"{}\":{amount}}}", unit.key));
            assert_eq!(serde_json::from_str::<Budget>(&json).ok(), Some(budget));
        }
    }
}
