//! The configs that travel in the program.

use super::Source;
use super::config::ConfigError;
use crate::suggest::nearest;

/// Path below [`FOLDER`] without its ending, and text, of every shipped config.
const SHIPPED: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/configs.rs"));

/// Where they lie in the sources.
pub(super) const FOLDER: &str = "configs";

/// Path and title of every shipped config, sorted by path.
///
/// # Errors
/// A config that is no TOML, which its tests would have told.
pub fn shipped_configs() -> Result<Vec<(&'static str, String)>, ConfigError> {
    let title = |text: &str| -> Result<String, ConfigError> {
        let source = Source {
            text: text.to_owned(),
            ..Source::default()
        };
        let table: toml::Table = source.parse()?;
        let title = table.get("title").and_then(toml::Value::as_str);
        Ok(title.unwrap_or_default().to_owned())
    };
    let configs = SHIPPED.iter();
    configs
        .map(|(path, text)| Ok((*path, title(text)?)))
        .collect()
}

/// Path and text of the config of a name: its path below `configs/`, or the end of that path if only one has it; with
/// or without `configs/` before and `.toml` behind.
///
/// # Errors
/// What there is, if no config or several have that name.
pub(super) fn find(name: &str) -> Result<(&'static str, &'static str), String> {
    let name = name.replace('\\', "/");
    let name = name.strip_prefix("./").unwrap_or(&name);
    let short = name.strip_suffix(".toml").unwrap_or(name);
    let short = short.strip_prefix("configs/").unwrap_or(short);
    if let Some(found) = SHIPPED.iter().find(|(path, _)| *path == short) {
        return Ok(*found);
    }
    let end = format!("/{short}");
    let ending: Vec<_> = SHIPPED.iter().filter(|(p, _)| p.ends_with(&end)).collect();
    match ending.as_slice() {
        [one] => Ok(**one),
        [] => {
            let paths: Vec<&str> = SHIPPED.iter().map(|(path, _)| *path).collect();
            let near = advice_on(short, &paths);
            Err(format!(
                "no such file, and no shipped config of that name{near}"
            ))
        }
        several => {
            let paths: Vec<&str> = several.iter().map(|(path, _)| *path).collect();
            let paths = paths.join(", ");
            Err(format!(
                "no such file, and several shipped configs of that name; say which: {paths}"
            ))
        }
    }
}

/// The nearest path, or the path of which the last part is nearest.
fn advice_on(short: &str, paths: &[&str]) -> String {
    let last = |path: &str| path.rsplit('/').next().unwrap_or_default().to_owned();
    let ends: Vec<String> = paths.iter().map(|path| last(path)).collect();
    let ends: Vec<&str> = ends.iter().map(String::as_str).collect();
    let whole = nearest(short, paths).map(str::to_owned);
    let near = whole.or_else(|| {
        let end = nearest(&last(short), &ends)?;
        let place = ends.iter().position(|known| *known == end)?;
        Some(paths[place].to_owned())
    });
    let list = "`lightbench list configs` lists them";
    near.map_or_else(
        || format!("; {list}"),
        |near| format!("; did you mean `{near}`? {list}"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn configs_are_found_by_path_and_by_name() {
        let path = |name: &str| find(name).expect(name).0;
        for name in ["quickstart", "quickstart.toml", "configs/quickstart.toml"] {
            assert_eq!(path(name), "quickstart");
        }
        assert_eq!(path("ao-fig6"), "papers/cache-placement/ao-fig6");
        assert_eq!(path("./configs/ours/ablation.toml"), "ours/ablation");
        assert_eq!(path("hash-cache/claims"), "papers/hash-cache/claims");
        let several = find("claims").expect_err("two papers have claims");
        assert!(several.contains("papers/light-cones/claims"), "{several}");
        let wrong = find("quickstrt").expect_err("no such config");
        assert!(wrong.contains("did you mean `quickstart`?"), "{wrong}");
        let wrong = find("ao-fug6").expect_err("no such config");
        assert!(wrong.contains("cache-placement/ao-fig6`?"), "{wrong}");
    }

    #[test]
    fn every_config_has_a_title() {
        let configs = shipped_configs().expect("all are TOML");
        assert!(configs.len() >= 50);
        for (path, title) in configs {
            assert!(!title.is_empty(), "{path}");
        }
    }
}
