//! What a config may be called, and how many jobs it may make.

use std::collections::{BTreeMap, HashMap, HashSet};

use toml::Value;

use super::config::{Config, ConfigError, Source};
use super::plan::Plan;
use super::reference_store::REFERENCES;
use super::sweep::Sweep;

/// Most jobs of a plan: as many as lists and pages of them are good for.
const MOST_JOBS: u64 = 1_000_000;

/// Most samples of a pixel: what is kept of them while a tile is drawn grows with their number.
const MOST_SAMPLES: u32 = 1 << 16;

/// Refuses more samples a pixel than [`MOST_SAMPLES`], and experiments of no sample or repeat.
pub(super) fn check_samples(source: &Source, config: &Config) -> Result<(), ConfigError> {
    let (key, message) = match (config.spp, config.repeats) {
        (1..=MOST_SAMPLES, 1..) => return Ok(()),
        (1..=MOST_SAMPLES, _) => ("repeats", "repeats: expected at least 1".to_owned()),
        (spp, _) => {
            let message = format!("spp: expected 1 to {MOST_SAMPLES} samples a pixel, found {spp}");
            ("spp", message)
        }
    };
    Err(source.error(&[key], message))
}

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

/// Refuses a swept technique, swept keys without values, and values that are listed twice.
pub(super) fn check_axes(sweep: &Sweep) -> Result<(), ConfigError> {
    for (key, values) in &sweep.axes {
        if key == "technique" {
            let message = "an experiment has one `technique`, which its columns, references and claims are about: run one \
                           experiment for each";
            return Err(sweep.error(key, message.into()));
        }
        let twice = values
            .iter()
            .enumerate()
            .find(|(place, value)| values[..*place].iter().any(|before| is_same(before, value)));
        let message = match twice {
            None if !values.is_empty() => continue,
            None => format!("`{key}` is swept over no value: list some, or leave it out"),
            Some((_, value)) => {
                format!("`{key}` is swept over {value} twice: list each value once")
            }
        };
        return Err(sweep.error(key, message));
    }
    Ok(())
}

/// Whether two values mean the same: 1 and 1.0 do.
fn is_same(a: &Value, b: &Value) -> bool {
    let number = |value: &Value| value.as_float().or(value.as_integer().map(|n| n as f64));
    a == b || number(a).zip(number(b)).is_some_and(|(a, b)| a == b)
}

impl Config {
    /// What is checked of a config before its scenes are looked for.
    pub(crate) fn check(source: &Source, config: &Self) -> Result<(), ConfigError> {
        check_numbers(source)?;
        check_names(source, config)?;
        check_axes(&Sweep::new(source, &config.sweep, &[]))?;
        check_count(source, config, &config.sweep)
    }
}

/// Refuses numbers that are not finite, wherever they stand: no parameter means anything by them, and results folders
/// could not be read back.
pub(super) fn check_numbers(source: &Source) -> Result<(), ConfigError> {
    let table: toml::Table = source.parse()?;
    let mut path = Vec::new();
    match not_finite(&Value::Table(table), &mut path) {
        None => Ok(()),
        Some(number) => {
            let keys: Vec<&str> = path.iter().map(String::as_str).collect();
            let key = path.iter().rfind(|key| key.parse::<usize>().is_err());
            let key = key.map_or("", String::as_str);
            let message = format!("{key}: expected finite numbers, found {number}");
            Err(source.error(&keys, message))
        }
    }
}

/// The first number in a value that is not finite; `path` leads to it.
fn not_finite(value: &Value, path: &mut Vec<String>) -> Option<f64> {
    let inner: Vec<(String, &Value)> = match value {
        Value::Float(number) => return (!number.is_finite()).then_some(*number),
        Value::Table(table) => table.iter().map(|(key, v)| (key.clone(), v)).collect(),
        Value::Array(list) => {
            let numbered = list.iter().enumerate();
            numbered.map(|(index, v)| (index.to_string(), v)).collect()
        }
        _ => return None,
    };
    for (key, value) in inner {
        path.push(key);
        if let Some(found) = not_finite(value, path) {
            return Some(found);
        }
        path.pop();
    }
    None
}

/// Whether all numbers in a value are finite.
pub(super) fn is_finite(value: &Value) -> bool {
    not_finite(value, &mut Vec::new()).is_none()
}

/// Names become folders and files, each of its own.
pub(super) fn check_names(source: &Source, config: &Config) -> Result<(), ConfigError> {
    let tables = config.table.iter().map(|table| ("table", &table.name));
    let figures = config.figure.iter().map(|figure| ("figure", &figure.name));
    check_folder_name(&config.name).map_err(|message| source.error(&["name"], message))?;
    for (number, scene) in config.scene.iter().enumerate() {
        let sound = scene.label.as_deref().map_or(Ok(()), check_label);
        let place = ["scene", &number.to_string(), "label"];
        sound.map_err(|message| source.error(&place, message))?;
    }
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    let mut taken = HashSet::new();
    for (list, name) in tables.chain(figures) {
        let number = numbers.entry(list).or_default();
        let sound = match taken.insert((list, name)) {
            true => check_name(name),
            false => Err(format!(
                "name: {name:?} is that of another {list}, whose files it would replace"
            )),
        };
        sound.map_err(|message| source.error(&[list, &number.to_string(), "name"], message))?;
        *number += 1;
    }
    Ok(())
}

/// Whether a name is that of a folder of results, beside which the store of references lies.
pub(crate) fn check_folder_name(name: &str) -> Result<(), String> {
    check_name(name)?;
    match name.eq_ignore_ascii_case(REFERENCES) {
        false => Ok(()),
        true => Err(format!(
            "name: {name:?} is the folder of the references of all experiments; choose another name"
        )),
    }
}

/// Whether tables can show a label.
pub(super) fn check_label(label: &str) -> Result<(), String> {
    match label.trim().is_empty() || label.contains(char::is_control) || label.len() > 200 {
        true => Err(format!(
            "label: expected a word or some, without control characters, found {label:?}"
        )),
        false => Ok(()),
    }
}

/// Names that Windows keeps for devices, whatever follows a dot.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];

/// Whether a character turns the direction of text, so that a name would look like another.
fn turns_text(c: char) -> bool {
    matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Whether a name is that of one folder or file, everywhere.
pub(super) fn check_name(name: &str) -> Result<(), String> {
    let refused = |c: char| c.is_control() || turns_text(c) || "/\\:*?\"<>|".contains(c);
    let stem = name.split('.').next().unwrap_or_default().trim_end();
    let sound = !name.trim().is_empty()
        && !name.ends_with(['.', ' '])
        && !DEVICES
            .iter()
            .any(|device| stem.eq_ignore_ascii_case(device))
        && name.len() <= 200
        && !name.contains(refused);
    match sound {
        true => Ok(()),
        false => Err(format!(
            "name: expected the name of one folder on any system, without separators, control characters, any of :*?\"<>| and a dot at its end, found {name:?}"
        )),
    }
}

/// A config makes one job at least.
pub(super) fn check_jobs(source: &Source, config: &Config, plan: &Plan) -> Result<(), ConfigError> {
    if !plan.jobs.is_empty() {
        return Ok(());
    }
    let (key, expected) = match config.scene.is_empty() {
        true => ("scene", "at least one [[scene]]"),
        false => (
            "environment",
            "at least one map; without the key a scene has its own",
        ),
    };
    Err(source.error(
        &[key],
        format!("no job comes of an empty list: expected {expected}"),
    ))
}

#[cfg(test)]
mod tests {
    use super::super::overrides::Override;
    use super::*;

    #[test]
    fn two_tables_of_one_name_are_refused() {
        let text = "name = \"t\"\ntechnique = \"ambient-occlusion\"\n[[scene]]\nname = \"stairs\"\n[[method]]\nid = \"IM\"\n\
                    [[table]]\nname = \"a\"\n[[figure]]\nname = \"a\"\ntitle = \"f\"\nkind = \"side-by-side\"\n[[table]]\nname = \"a\"";
        let config: Config = toml::from_str(text).expect("a config");
        let source = Source {
            file: "c.toml".into(),
            text: text.to_owned(),
        };
        let message = check_names(&source, &config)
            .expect_err("two tables")
            .to_string();
        assert!(
            message.contains("c.toml:14:1") && message.contains("another table"),
            "{message}"
        );
    }

    #[test]
    fn empty_lists_make_no_experiment() {
        let refused = |scenes: &str| {
            let source = Source {
                file: "c.toml".into(),
                text: format!(
                    "name = \"t\"\ntechnique = \"environment-lighting\"\nlights = 4\n{scenes}\n[[method]]\nid = \"mis\"\n"
                ),
            };
            super::super::plan::plan(&source, &[]).map_err(|error| error.to_string())
        };
        for (scenes, expected) in [
            (
                "scene = []",
                "c.toml:4:1: no job comes of an empty list: expected at least one [[scene]]",
            ),
            (
                "environment = []\n[[scene]]\nname = \"still-puzzle\"",
                "c.toml:4:1: no job",
            ),
        ] {
            let message = refused(scenes).expect_err(scenes);
            assert!(message.starts_with(expected), "{message}");
        }
        refused("environment = [\"gym\"]\n[[scene]]\nname = \"still-puzzle\"").expect("a job");
    }

    #[test]
    fn samples_have_bounds() {
        let check = |lines: &str| {
            let text = format!("name = \"t\"\ntechnique = \"t\"\n{lines}\nscene = []\nmethod = []");
            let config: Config = toml::from_str(&text).expect("a config");
            let source = Source {
                file: "c.toml".into(),
                text,
            };
            check_samples(&source, &config).map_err(|error| error.to_string())
        };
        check("spp = 65536").expect("many");
        for (lines, told) in [
            (
                "spp = 0",
                "c.toml:3:1: spp: expected 1 to 65536 samples a pixel, found 0",
            ),
            ("spp = 65537", "c.toml:3:1: spp: expected 1 to 65536"),
            ("repeats = 0", "c.toml:3:1: repeats: expected at least 1"),
        ] {
            let error = check(lines).expect_err(lines);
            assert!(error.starts_with(told), "{error}");
        }
    }

    #[test]
    fn names_are_folders_on_any_system_and_labels_can_be_read() {
        for name in ["a.", "b ", "con", "NUL.txt", "aux .x", "a\u{202e}b"] {
            check_name(name).expect_err(name);
        }
        for name in ["a.b", "icon", "console", "-x", "ä", ".hidden"] {
            check_name(name).expect(name);
        }
        for label in ["", " ", "a\tb", "a\u{7}"] {
            check_label(label).expect_err(label);
        }
        check_label("ours, α = 2 (b)").expect("a label");
    }

    #[test]
    fn the_folder_of_references_is_no_experiment() {
        for name in ["references", "References"] {
            let message = check_folder_name(name).expect_err(name);
            assert!(message.contains("choose another name"), "{message}");
        }
        check_folder_name("my-references").expect("another folder");
    }

    #[test]
    fn sweeps_have_values_and_none_twice() {
        let check = |sweep: &str| {
            let text = format!("a = 1\n[sweep]\n{sweep}");
            let table: toml::Table = text.parse().expect("toml");
            let axes = table["sweep"].clone().try_into().expect("a sweep");
            let source = Source {
                file: "c.toml".into(),
                text,
            };
            check_axes(&Sweep::new(&source, &axes, &[])).map_err(|error| error.to_string())
        };
        check("caches = [1, 2]\nspp = [1]").expect("sound");
        let error = check("caches = []").expect_err("empty");
        assert!(
            error.starts_with("c.toml:3:") && error.contains("no value"),
            "{error}"
        );
        for twice in ["[1, 2, 1]", "[1, 1.0]", "[\"a\", \"a\"]"] {
            let error = check(&format!("caches = {twice}")).expect_err(twice);
            assert!(error.contains("twice"), "{error}");
        }
        let twice = [Override::parse("spp=1,1").expect("reads")];
        let (source, none) = (Source::default(), BTreeMap::new());
        let error = check_axes(&Sweep::new(&source, &none, &twice)).expect_err("an override");
        let error = error.to_string();
        assert!(error.starts_with("override `spp=1,1`: "), "{error}");
    }

    #[test]
    fn numbers_that_are_not_finite_are_refused_with_their_place() {
        for (text, expected) in [
            (
                "a = 1\nb = inf",
                "c.toml:2:1: b: expected finite numbers, found inf",
            ),
            ("parameters = { distance = -inf }", "distance"),
            ("[[scene]]\n[[scene]]\nao_distance = nan", "c.toml:3:"),
            (
                "[sweep]\n\"parameters.distance\" = [1.0, inf]",
                "parameters.distance",
            ),
            ("[sequence]\nfps = +inf", "fps"),
        ] {
            let source = Source {
                file: "c.toml".into(),
                text: text.to_owned(),
            };
            let error = check_numbers(&source).expect_err(text).to_string();
            assert!(error.contains(expected), "{error}");
        }
        for text in ["a=inf", "a=1,nan", "a=[1, -inf]", "a=0..inf"] {
            let error = Override::parse(text).expect_err(text).to_string();
            assert!(error.contains(text), "{error}");
        }
    }
}
