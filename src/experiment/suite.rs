//! A suite: several experiments run as one, under shared settings.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::config::{ConfigError, Source};
use super::limits::check_folder_name;
use super::overrides::Override;

/// A suite file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suite {
    /// Names the results folder; each experiment has a folder in it.
    pub name: String,
    /// Heading of the report; may be empty.
    #[serde(default)]
    pub title: String,
    /// Overrides of every experiment, as on the command line, which wins over them.
    #[serde(default)]
    pub set: Vec<String>,
    /// The experiments, in order.
    pub include: Vec<Member>,
}

/// An experiment of a suite.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Member {
    /// Its config, relative to the suite file.
    pub config: PathBuf,
    /// Overrides of this experiment, which win over those of the suite.
    #[serde(default)]
    pub set: Vec<String>,
}

impl Suite {
    /// The suite in a file, or `None` if the file is an experiment.
    ///
    /// # Errors
    /// A file with a key `include` that is no suite, with line and column.
    pub fn of(source: &Source) -> Result<Option<Self>, ConfigError> {
        let Ok(table) = toml::from_str::<toml::Table>(&source.text) else {
            return Ok(None); // Reading it as an experiment says what is wrong.
        };
        if !table.contains_key("include") {
            return Ok(None);
        }
        let suite: Self = source.parse()?;
        check_folder_name(&suite.name).map_err(|message| source.error(&["name"], message))?;
        if suite.include.is_empty() {
            let message = "expected at least one [[include]] with a `config`".into();
            return Err(source.error(&["include"], message));
        }
        check_overrides(&suite.set).map_err(|message| source.error(&["set"], message))?;
        for (index, member) in suite.include.iter().enumerate() {
            let at = |message| source.error(&["include", &index.to_string(), "set"], message);
            check_overrides(&member.set).map_err(at)?;
        }
        Ok(Some(suite))
    }

    /// The configs with their overrides: the suite's, the member's, then `given`; of overrides of
    /// one key the last stays.
    ///
    /// # Errors
    /// Overrides that cannot be read.
    pub fn members(
        &self,
        file: &Path,
        given: &[Override],
    ) -> Result<Vec<(PathBuf, Vec<Override>)>, ConfigError> {
        let folder = file.parent().unwrap_or(Path::new(""));
        let expand = |member: &Member| {
            let written = self.set.iter().chain(&member.set);
            let mut overrides: Vec<Override> = written
                .map(|text| Override::parse(text))
                .collect::<Result<_, _>>()?;
            overrides.extend(given.iter().cloned());
            Ok((folder.join(&member.config), last_of_each_key(overrides)))
        };
        self.include.iter().map(expand).collect()
    }
}

/// Refuses overrides that cannot be read, and a second one of a key in one list, of which only the last would count.
fn check_overrides(list: &[String]) -> Result<(), String> {
    let mut keys = HashSet::new();
    for text in list {
        let Override { key, .. } = Override::parse(text).map_err(|error| error.to_string())?;
        if !keys.insert(key.clone()) {
            return Err(format!("`{key}` is set twice: leave one of the two out"));
        }
    }
    Ok(())
}

fn last_of_each_key(overrides: Vec<Override>) -> Vec<Override> {
    let mut kept: Vec<Override> = Vec::new();
    for next in overrides {
        kept.retain(|o| o.key != next.key);
        kept.push(next);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(text: &str) -> Source {
        Source {
            file: "configs/all.toml".into(),
            text: text.into(),
        }
    }

    #[test]
    fn the_command_line_wins_over_the_member_over_the_suite() {
        let text = "name = 'all'\nset = ['scale=1/4', 'spp=1', 'repeats=2']\n\
                    [[include]]\nconfig = 'a.toml'\nset = ['spp=2', 'repeats=3']\n";
        let suite = Suite::of(&source(text)).expect("reads").expect("a suite");
        let given = [Override::parse("repeats=4").expect("reads")];
        let members = suite
            .members(Path::new("configs/all.toml"), &given)
            .expect("expands");
        assert_eq!(members[0].0, Path::new("configs/a.toml"));
        let texts: Vec<String> = members[0]
            .1
            .iter()
            .map(|o| format!("{}={}", o.key, o.values[0]))
            .collect();
        assert_eq!(texts, ["scale=\"1/4\"", "spp=2", "repeats=4"]);
    }

    #[test]
    fn experiments_are_no_suites_and_wrong_keys_have_a_place() {
        assert!(Suite::of(&source("name = 'x'\n")).expect("reads").is_none());
        let wrong = source("name = 'x'\nincludes = 1\n[[include]]\nconfig = 'a.toml'\n");
        let error = Suite::of(&wrong).expect_err("unknown key").to_string();
        assert!(error.contains("all.toml:2:1"), "{error}");
        for (text, expected) in [
            (
                "name = 'x'\ninclude = []\n",
                "all.toml:2:1: expected at least one",
            ),
            (
                "name = 'x'\nset = ['spp=1', 'spp=2']\n[[include]]\nconfig = 'a.toml'\n",
                "`spp` is set twice",
            ),
            (
                "name = 'x'\n[[include]]\nconfig = 'a.toml'\nset = ['spp']\n",
                "expected key=value",
            ),
        ] {
            let error = Suite::of(&source(text)).expect_err(text).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
