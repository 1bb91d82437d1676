//! `docs/config.md` against the reader.

use std::collections::BTreeMap;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::config::{Config, SceneChoice, SceneTransform};
use super::reported::{ClaimSpec, FigureSpec, GateSpec, Published, TableSpec};
use super::sequence::{SequenceSpec, ViewerRule};
use super::suite::{Member, Suite};

const PAGE: &str = include_str!("../../docs/config.md");

/// The keys that a table of a config may have, from what the reader says of an unknown one.
fn keys<T: DeserializeOwned>() -> Vec<String> {
    let error = toml::from_str::<T>("no_such_key = 1")
        .err()
        .expect("unknown");
    let message = error.message().to_owned();
    let known = message.split("expected").nth(1).unwrap_or_default();
    let mut keys: Vec<String> = known
        .split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect();
    keys.sort();
    assert!(!keys.is_empty(), "{message}");
    keys
}

/// The keys in the table below a heading, with their defaults.
fn documented(heading: &str) -> BTreeMap<String, String> {
    let section = PAGE.split(&format!("\n{heading}\n")).nth(1);
    let section = section.unwrap_or_else(|| panic!("no heading `{heading}`"));
    let lines = section.lines().take_while(|line| !line.starts_with('#'));
    let entry = |line: &str| {
        let (key, rest) = line.strip_prefix("| `")?.split_once("` |")?;
        let default = rest.split('|').next()?.trim();
        Some((key.to_owned(), default.to_owned()))
    };
    lines.filter_map(entry).collect()
}

/// The value that a default stands for; `None` where it is said in words.
fn value_of(default: &str) -> Option<Value> {
    match default {
        "none" => return Some(Value::Null),
        "empty" => return Some("".into()),
        _ => {}
    }
    let literal = format!("value = {}", default.replace('`', ""));
    if let Ok(table) = literal.parse::<toml::Table>() {
        return serde_json::to_value(&table["value"]).ok();
    }
    let words = default.split(", ");
    let words = words.map(|word| word.strip_prefix('`')?.strip_suffix('`'));
    let words: Vec<&str> = words.collect::<Option<_>>()?;
    match words[..] {
        [word] => Some(word.into()),
        _ => Some(words.into()),
    }
}

/// Whether two values are the same; nothing is the same as an empty list.
fn is_same(a: &Value, b: &Value) -> bool {
    let is_nothing = |v: &Value| {
        let is_list = v.as_array().is_some_and(Vec::is_empty);
        v.is_null() || is_list || v.as_object().is_some_and(serde_json::Map::is_empty)
    };
    let all = |a: &Vec<Value>, b: &Vec<Value>| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_same(a, b))
    };
    a == b
        || is_nothing(a) && is_nothing(b)
        || a.as_f64().is_some_and(|number| b.as_f64() == Some(number))
        || a.as_array()
            .zip(b.as_array())
            .is_some_and(|(a, b)| all(a, b))
}

/// Compares the defaults below a heading with what is read of a table with the needed keys only, and returns how many
/// have a value.
fn compare_defaults<T: DeserializeOwned + Serialize>(heading: &str, needed: &str) -> usize {
    let table: toml::Table = needed.parse().expect(heading);
    let read = |table: toml::Table| table.try_into::<T>();
    let defaults = serde_json::to_value(read(table.clone()).expect(heading)).expect(heading);
    let mut compared = 0;
    for (key, default) in documented(heading) {
        let is_needed = default == "needed";
        assert_eq!(is_needed, table.contains_key(&key), "{heading}: {key}");
        if is_needed {
            let mut without = table.clone();
            without.remove(&key);
            assert!(read(without).is_err(), "{heading}: {key} is not needed");
        } else if let (Some(value), Some(found)) = (value_of(&default), defaults.get(&key)) {
            let is_same = is_same(&value, found);
            assert!(is_same, "{heading}: {key} is {found}, not {default}");
            compared += 1;
        }
    }
    compared
}

#[test]
fn the_page_has_the_defaults_of_a_config() {
    let config = "name = \"n\"\ntechnique = \"t\"\nscene = [{ name = \"s\" }]\nmethod = []";
    let published = "where = \"w\"\nscene = \"s\"\nmethod = \"m\"\nvalues = {}";
    let claim = "text = \"t\"\nwhere = \"w\"\nexpect = \"e\"";
    let compared = [
        compare_defaults::<Config>("## The experiment", config),
        compare_defaults::<SceneChoice>("## `[[scene]]`", "name = \"s\""),
        compare_defaults::<SceneTransform>("### `transform`", ""),
        compare_defaults::<SequenceSpec>("## `[sequence]`", "frames = 3"),
        compare_defaults::<ViewerRule>("### `viewers`", "count = 1"),
        compare_defaults::<TableSpec>("## `[[table]]`", "name = \"t\""),
        compare_defaults::<FigureSpec>("## `[[figure]]`", "name = \"f\"\nkind = \"curves\""),
        compare_defaults::<ClaimSpec>("## `[[claim]]`", claim),
        compare_defaults::<GateSpec>("## `[[gate]]`", "text = \"t\"\nexpect = \"e\""),
        compare_defaults::<Published>("## `[[published]]`", published),
    ];
    assert!(compared.iter().sum::<usize>() > 30, "{compared:?}");
}

#[test]
fn the_page_has_every_key_of_a_config() {
    for (heading, keys) in [
        ("## The experiment", keys::<Config>()),
        ("## `[[scene]]`", keys::<SceneChoice>()),
        ("### `transform`", keys::<SceneTransform>()),
        ("## `[sequence]`", keys::<SequenceSpec>()),
        ("### `viewers`", keys::<ViewerRule>()),
        ("## `[[table]]`", keys::<TableSpec>()),
        ("## `[[figure]]`", keys::<FigureSpec>()),
        ("## `[[claim]]`", keys::<ClaimSpec>()),
        ("## `[[gate]]`", keys::<GateSpec>()),
        ("## `[[published]]`", keys::<Published>()),
        ("## A suite", keys::<Suite>()),
        ("### `[[include]]`", keys::<Member>()),
    ] {
        let documented: Vec<String> = documented(heading).into_keys().collect();
        assert_eq!(documented, keys, "{heading}");
    }
}
