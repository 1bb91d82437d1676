//! `new`: commented files to start from, that work as they are.

use std::path::{Path, PathBuf};

use super::args::NewVerb;
use super::exit::{self, Failure};
use crate::experiment::check_folder_name;
use crate::standard_error::tell;

const EXPERIMENT: &str = include_str!("experiment.toml");
const SCENE: &str = include_str!("scene.toml");

/// Writes `NAME.toml` or `NAME/scene.toml`, unless it is there.
pub fn run(verb: &NewVerb) -> Result<u8, Failure> {
    let (given, text) = match verb {
        NewVerb::Experiment { name } => (name, EXPERIMENT),
        NewVerb::Scene { name } => (name, SCENE),
    };
    let name = given.strip_suffix(".toml").unwrap_or(given);
    let is_sound = |c: char| c.is_alphanumeric() || "-_".contains(c);
    if name.is_empty() || name.starts_with('-') || !name.chars().all(is_sound) {
        return Err(Failure::usage(format!(
            "{given}: expected a name of letters, digits, - and _, for example my-test"
        )));
    }
    let (file, next) = match verb {
        NewVerb::Experiment { .. } => {
            let file = PathBuf::from(format!("{name}.toml"));
            (file, format!("lightbench run {name}.toml"))
        }
        NewVerb::Scene { .. } => {
            let file = Path::new(name).join("scene.toml");
            (file, format!("lightbench scene check {name}/scene.toml"))
        }
    };
    if matches!(verb, NewVerb::Experiment { .. }) {
        check_folder_name(name).map_err(Failure::usage)?;
    }
    if file.exists() {
        return Err(Failure::usage(format!(
            "{} is there already and is left as it is; choose another name",
            file.display()
        )));
    }
    crate::files::write(&file, text.replace("NAME", name))?;
    tell!("wrote {}; next: {next}", file.display());
    Ok(exit::OK)
}
