//! `key=value` from the shell: single values, lists `a,b,c` and ranges `from..to..step`.

use toml::{Table, Value};

use super::limits::is_finite;
use super::{ConfigError, SceneChoice};
use crate::suggest::hint;

/// Its values are ranges of frames themselves.
const FRAMES: &str = "sequence.frames";

/// An override with one or more values; more than one makes a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    /// Path of a key, its parts joined by dots.
    pub key: String,
    /// At least one.
    pub values: Vec<Value>,
}

impl std::fmt::Display for Override {
    /// As it is written on the command line.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let text = |value: &Value| match value {
            Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        let values: Vec<String> = self.values.iter().map(text).collect();
        write!(f, "{}={}", self.key, values.join(","))
    }
}

impl Override {
    /// Parses `key=value`. Numbers, booleans and TOML arrays in brackets are read as such, anything
    /// else is text; `1..4` is 1, 2, 3, 4 and `10..40..10` is 10, 20, 30, 40, but of `sequence.frames` a range is one value.
    pub fn parse(text: &str) -> Result<Self, ConfigError> {
        let bad = |message: &str| ConfigError::Override {
            text: text.to_owned(),
            message: message.to_owned(),
        };
        let (key, value) = text
            .split_once('=')
            .ok_or_else(|| bad("expected key=value, for example caches=2000 or spp=1,4"))?;
        let (key, value) = (key.trim(), value.trim());
        if key.is_empty() || value.is_empty() {
            return Err(bad("key and value must not be empty"));
        }
        let swept = if key == FRAMES { None } else { range(value) };
        let values = match swept {
            Some(Ok(values)) => values,
            Some(Err(message)) => return Err(bad(&message)),
            None if value.starts_with('[') => vec![scalar(value)],
            None => value.split(',').map(|part| scalar(part.trim())).collect(),
        };
        if !values.iter().all(is_finite) {
            return Err(bad("expected finite numbers"));
        }
        Ok(Self {
            key: key.to_owned(),
            values,
        })
    }
}

/// Scenes that set a key of the experiment themselves are not reached by an override of it, which is told.
///
/// # Errors
/// An override that reaches no scene.
pub(super) fn tell_reach(
    overrides: &[Override],
    scenes: &[SceneChoice],
    notes: &mut Vec<String>,
) -> Result<(), ConfigError> {
    for written in overrides {
        let key = &written.key;
        let own = scenes.iter().filter(|scene| scene.sets(key));
        let own: Vec<&str> = own.map(|scene| scene.name.as_str()).collect();
        if own.is_empty() {
            continue;
        }
        if own.len() == scenes.len() {
            return Err(ConfigError::Override {
                text: written.to_string(),
                message: format!(
                    "every scene of the config has `{key}` of its own: write scene.*.{key}=…, or scene.NAME.{key}=… for one"
                ),
            });
        }
        notes.push(format!(
            "`{written}` does not reach scenes that have `{key}` of their own: {} (scene.NAME.{key}=… does)",
            own.join(", ")
        ));
    }
    Ok(())
}

/// Keys and values of the overrides that sweep nothing.
pub(super) fn single(overrides: &[Override]) -> Vec<(String, Value)> {
    let single = overrides.iter().filter(|o| o.values.len() == 1);
    single
        .map(|o| (o.key.clone(), o.values[0].clone()))
        .collect()
}

/// A TOML scalar or array; bare words are strings.
fn scalar(text: &str) -> Value {
    format!("value = {text}")
        .parse::<Table>()
        .ok()
        .and_then(|mut table| table.remove("value"))
        .unwrap_or_else(|| Value::String(text.to_owned()))
}

fn range(text: &str) -> Option<Result<Vec<Value>, String>> {
    let parts: Vec<&str> = text.split("..").collect();
    if parts.len() < 2 || parts.len() > 3 {
        return None;
    }
    let numbers: Option<Vec<f64>> = parts.iter().map(|p| p.trim().parse().ok()).collect();
    let numbers = numbers?;
    let (from, to) = (numbers[0], numbers[1]);
    let step = numbers.get(2).copied().unwrap_or(1.0);
    let count = ((to - from) / step + 1e-9).floor();
    if !(step > 0.0 && (0.0..10_000.0).contains(&count)) {
        return Some(Err(
            "a range is from..to or from..to..step, ascending, at most 10000 values".into(),
        ));
    }
    let whole = numbers.iter().all(|n| n.fract() == 0.0);
    let value = |i: usize| {
        let x = from + i as f64 * step;
        if whole {
            Value::Integer(x as i64)
        } else {
            Value::Float(x)
        }
    };
    Some(Ok((0..=count as usize).map(value).collect()))
}

/// Puts a value at a dotted key. `method.LABEL.key` reaches the methods with that id or label,
/// `method.*.key` all of them, `scene.NAME.key` the scenes of that name.
pub fn apply(table: &mut Table, key: &str, value: &Value) -> Result<(), ConfigError> {
    let error = |message: String| ConfigError::Override {
        text: format!("{key}={value}"),
        message,
    };
    let segments: Vec<&str> = key.split('.').collect();
    if let [list @ ("method" | "scene"), name, rest @ ..] = segments.as_slice() {
        if rest.is_empty() {
            return Err(error(format!("expected {list}.NAME.key")));
        }
        let names: &[&str] = if *list == "method" {
            &["label", "id"]
        } else {
            &["name"]
        };
        let mut touched = false;
        let mut known: Vec<String> = Vec::new();
        for entry in table
            .get_mut(*list)
            .and_then(Value::as_array_mut)
            .into_iter()
            .flatten()
        {
            let Some(entry) = entry.as_table_mut() else {
                continue;
            };
            let own = names.iter().filter_map(|k| entry.get(*k)?.as_str());
            known.extend(own.map(str::to_owned));
            let is = |k: &&str| entry.get(*k).and_then(Value::as_str) == Some(*name);
            if *name == "*" || names.iter().any(is) {
                set(entry, rest, value).map_err(error)?;
                touched = true;
            }
        }
        return if touched {
            Ok(())
        } else {
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            let hint = hint(name, &known);
            let message = format!("no {list} is called `{name}` in this config{hint}");
            Err(error(message))
        };
    }
    set(table, &segments, value).map_err(error)
}

fn set(table: &mut Table, path: &[&str], value: &Value) -> Result<(), String> {
    let [first, rest @ ..] = path else {
        return Err("empty key".into());
    };
    if rest.is_empty() {
        table.insert((*first).to_owned(), value.clone());
        return Ok(());
    }
    let inner = table
        .entry(*first)
        .or_insert_with(|| Value::Table(Table::new()))
        .as_table_mut()
        .ok_or_else(|| format!("`{first}` is not a table"))?;
    set(inner, rest, value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_ranges_and_text() {
        let values = |t: &str| Override::parse(t).expect(t).values;
        assert_eq!(values("caches=1,2"), [Value::Integer(1), Value::Integer(2)]);
        assert_eq!(values("caches=10..30..10").len(), 3);
        assert_eq!(values("scale=1/4"), [Value::String("1/4".into())]);
        assert_eq!(values("size=[4,2]").len(), 1);
        assert_eq!(
            values("sequence.frames=0..8"),
            values("sequence.frames=\"0..8\"")
        );
        assert!(Override::parse("caches").is_err());
        assert!(Override::parse("caches=5..1").is_err());
    }

    #[test]
    fn methods_are_reached_by_label_or_id() {
        let mut table: Table =
            "[[method]]\nid = \"SD\"\nlabel = \"SD-10\"\n[[method]]\nid = \"IM\"\n"
                .parse()
                .expect("toml");
        apply(
            &mut table,
            "method.SD-10.min_cluster_size",
            &Value::Integer(10),
        )
        .expect("applies");
        assert_eq!(
            table["method"][0]["min_cluster_size"].as_integer(),
            Some(10)
        );
        assert!(apply(&mut table, "method.XX.a", &Value::Integer(1)).is_err());
    }
}
