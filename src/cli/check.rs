//! `scene check`: what a scene gives, and what each technique takes of it.

use super::args::CheckArgs;
use super::exit::{self, Failure};
use super::out::say;
use crate::registry::TECHNIQUES;
use crate::scene::{check_scene, find_scene};

/// Loads everything once and prints what was found, dropped, approximated and what it costs.
pub fn run(args: &CheckArgs) -> Result<u8, Failure> {
    let description = find_scene(&args.scene)?;
    let check = check_scene(&description)?;
    let mut json = serde_json::to_value(&check)?;
    let mut techniques = serde_json::Map::new();
    for entry in TECHNIQUES {
        let technique = (entry.build)(&toml::Table::new())?;
        let needs = technique.needs();
        let mut names = Vec::new();
        for (name, needed) in [
            ("normals", needs.normals),
            ("materials", needs.materials),
            ("textures", needs.textures),
            ("emitters", needs.emitters),
            ("environment", needs.environment),
        ] {
            if needed {
                names.push(name);
            }
        }
        let bytes = check.report.cost.of(needs);
        techniques.insert(
            entry.about.id.into(),
            serde_json::json!({ "needs": names, "bytes": bytes }),
        );
    }
    json["techniques"] = techniques.into();
    if args.json {
        say!("{json:#}");
    } else {
        json["movable_shapes"] = shortened(&check.movable_shapes);
        json["movable_lights"] = shortened(&check.movable_lights);
        print(&json, 0);
    }
    Ok(exit::OK)
}

/// Most names that the text has of a list.
const NAMES: usize = 24;

/// Names on one line, the first of many; nothing where there are none.
fn shortened(names: &[String]) -> serde_json::Value {
    let mut line = names[..names.len().min(NAMES)].join(", ");
    if names.len() > NAMES {
        line += &format!(", … and {} more", names.len() - NAMES);
    }
    match names.is_empty() {
        true => Vec::<String>::new().into(),
        false => vec![line].into(),
    }
}

/// `key: value` lines, nested values indented; empty lists are left out.
fn print(value: &serde_json::Value, depth: usize) {
    let indent = "  ".repeat(depth);
    let Some(object) = value.as_object() else {
        return;
    };
    for (key, value) in object {
        match value {
            serde_json::Value::Object(_) => {
                say!("{indent}{key}:");
                print(value, depth + 1);
            }
            serde_json::Value::Array(items) if items.iter().all(|i| i.is_string()) => {
                for item in items {
                    say!("{indent}{key}: {}", item.as_str().unwrap_or_default());
                }
            }
            serde_json::Value::Array(items) => {
                for item in items {
                    say!("{indent}{key}: {item}");
                }
            }
            other => say!("{indent}{key}: {other}"),
        }
    }
}
