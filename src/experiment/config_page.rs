//! `docs/config.md` against the reader.

use serde::de::DeserializeOwned;

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

/// The keys in the table below a heading.
fn documented(heading: &str) -> Vec<String> {
    let section = PAGE.split(&format!("\n{heading}\n")).nth(1);
    let section = section.unwrap_or_else(|| panic!("no heading `{heading}`"));
    let lines = section.lines().take_while(|line| !line.starts_with('#'));
    let mut keys: Vec<String> = lines
        .filter_map(|line| line.strip_prefix("| `")?.split('`').next())
        .map(str::to_owned)
        .collect();
    keys.sort();
    keys
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
        assert_eq!(documented(heading), keys, "{heading}");
    }
}
