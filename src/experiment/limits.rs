//! What a config may be called, and how many jobs it may make.

use std::collections::{BTreeMap, HashMap};

use toml::Value;

use super::config::{Config, ConfigError, Source};

/// Most jobs of a plan: as many as lists and pages of them are good for.
const MOST_JOBS: u64 = 1_000_000;

/// Refuses more jobs than [`MOST_JOBS`] before they are made.
pub(super) fn check_count(
    source: &Source,
    config: &Config,
    axes: &BTreeMap<String, Vec<Value>>,
) -> Result<(), ConfigError> {
    let lists = [config.scene.len(), config.method.len()];
    let swept = axes.values().map(Vec::len);
    let sizes = lists.into_iter().chain(swept).map(|count| count as u64);
    let count = sizes.fold(u64::from(config.repeats), u64::saturating_mul);
    if count <= MOST_JOBS {
        return Ok(());
    }
    let message = format!(
        "repeats, sweeps, scenes and methods make {count} jobs; {MOST_JOBS} at most: split the config or sweep less"
    );
    Err(source.error(&["repeats"], message))
}

/// Names become folders and files, each of its own.
pub(super) fn check_names(source: &Source, config: &Config) -> Result<(), ConfigError> {
    let tables = config.table.iter().map(|table| ("table", &table.name));
    let figures = config.figure.iter().map(|figure| ("figure", &figure.name));
    let mut numbers = HashMap::new();
    let mut names = vec![(vec!["name".to_owned()], &config.name)];
    for (list, name) in tables.chain(figures) {
        let number: &mut usize = numbers.entry(list).or_default();
        names.push((
            vec![list.to_owned(), number.to_string(), "name".to_owned()],
            name,
        ));
        *number += 1;
    }
    for (place, name) in names {
        check_name(name).map_err(|message| {
            let place: Vec<&str> = place.iter().map(String::as_str).collect();
            source.error(&place, message)
        })?;
    }
    Ok(())
}

/// Whether a name is that of one folder or file, everywhere.
pub(super) fn check_name(name: &str) -> Result<(), String> {
    let refused = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
    let sound = !name.trim().is_empty()
        && !matches!(name, "." | "..")
        && name.len() <= 200
        && !name.contains(refused);
    match sound {
        true => Ok(()),
        false => Err(format!(
            "name: expected the name of one folder, without separators, control characters and any of :*?\"<>|, found {name:?}"
        )),
    }
}
