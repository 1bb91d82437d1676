//! `list` and `explain`: the registry, for people.

use super::args::{ExplainArgs, ListArgs};
use super::exit::{self, Failure};
use super::out;
use super::out::say;
use crate::entry::{About, Bias, Kind, Parameter};
use crate::environment::embedded_maps;
use crate::experiment::shipped_configs;
use crate::registry::entries;
use crate::scene::{find_scene, shipped_scenes};
use crate::suggest::{advice, hint};

const KINDS: [&str; 9] = [
    "techniques",
    "distributions",
    "refinements",
    "interpolations",
    "methods",
    "samplers",
    "scenes",
    "maps",
    "configs",
];

/// One line an entry.
pub fn list(args: &ListArgs) -> Result<u8, Failure> {
    let wanted = |kind: &str| {
        // All configs would push the rest off the screen.
        args.kind.as_deref().map_or(kind != "configs", |k| {
            kind.trim_end_matches('s') == k.trim_end_matches('s')
        })
    };
    if !KINDS.iter().any(|kind| wanted(kind)) {
        let kind = args.kind.as_deref().unwrap_or("");
        return Err(Failure::usage(format!(
            "nothing is listed as `{kind}`; {}",
            advice(kind, &KINDS)
        )));
    }
    for kind in KINDS.iter().filter(|kind| wanted(kind)) {
        say!("{kind}:");
        for (_, about) in entries().iter().filter(|(k, _)| k == kind) {
            say!("  {:<20} {}", about.id, about.summary);
        }
        if *kind == "maps" {
            for (name, summary) in embedded_maps() {
                say!("  {name:<20} {summary}");
            }
        }
        if *kind == "configs" {
            for (path, title) in shipped_configs()? {
                say!("  {path:<40} {title}");
            }
        }
        if *kind == "scenes" {
            for name in shipped_scenes() {
                say!("  {name:<20} {}", find_scene(name)?.title);
            }
        }
    }
    Ok(exit::OK)
}

/// A page of Markdown for one entry, or for all.
pub fn explain(args: &ExplainArgs) -> Result<u8, Failure> {
    let (kind, name) = match args.entry.split_once('/') {
        Some((kind, name)) => (Some(kind), name),
        None => (None, args.entry.as_str()),
    };
    let all = entries();
    // `VGC+DGS` is two of them.
    let parts: Vec<&str> = name.split('+').collect();
    let of_kind = |(k, _): &&(&str, &About)| {
        kind.is_none_or(|kind| kind.trim_end_matches('s') == k.trim_end_matches('s'))
    };
    let of_kind: Vec<_> = all.iter().filter(of_kind).collect();
    let answers = |part: &str| of_kind.iter().any(|(_, about)| about.answers_to(part));
    if name != "all" && !parts.iter().all(|part| answers(part)) {
        let ids: Vec<&str> = all.iter().map(|(_, about)| about.id).collect();
        let known: Vec<String> = all.iter().map(|(k, a)| format!("{k}/{}", a.id)).collect();
        return Err(Failure::usage(format!(
            "no entry `{}`{} known: {}",
            args.entry,
            match hint(name, &ids) {
                none if none.is_empty() => ";".to_owned(),
                hint => hint,
            },
            known.join(", ")
        )));
    }
    for (kind, about) in of_kind {
        if name == "all" || parts.iter().any(|part| about.answers_to(part)) {
            out::write(page(kind, about));
        }
    }
    Ok(exit::OK)
}

/// The page of one entry.
pub fn page(kind: &str, about: &About) -> String {
    let mut text = format!("# {} ({kind})\n\n{}\n\n", about.id, about.summary);
    let comment = about.module.lines().map_while(|l| l.strip_prefix("//!"));
    for line in comment {
        text.push_str(line.trim_start());
        text.push('\n');
    }
    text.push('\n');
    if !about.aliases.is_empty() {
        text.push_str(&format!("Also called: {}\n\n", about.aliases.join(", ")));
    }
    let bias = match about.bias {
        Bias::Exact => "exact",
        Bias::Unbiased => "unbiased",
        Bias::Consistent => "consistent: converges to the reference as the budget grows",
        Bias::Biased => "biased at any budget",
    };
    text.push_str(&format!("Source: {}\n\nBias: {bias}\n", about.source));
    if !about.parameters.is_empty() {
        text.push_str(
            "\n| parameter | default | takes | unit | meaning |\n|---|---|---|---|---|\n",
        );
        for parameter in about.parameters {
            text.push_str(&lines(parameter, ""));
        }
    }
    if !about.failures.is_empty() {
        text.push_str("\nKnown failures:\n");
        for failure in about.failures {
            text.push_str(&format!("- {failure}\n"));
        }
    }
    text.push('\n');
    text
}

/// The line of a parameter, or those of its table, within the table that it lies in.
fn lines(parameter: &Parameter, table: &str) -> String {
    let key = format!("{table}{}", parameter.key);
    if let Kind::Table(parameters) = parameter.kind {
        let table = format!("{key}.");
        return parameters.iter().map(|p| lines(p, &table)).collect();
    }
    let default = (parameter.default)().map_or("none".into(), |text| format!("`{text}`"));
    format!(
        "| `{key}` | {default} | {} | {} | {} |\n",
        parameter.permitted(),
        parameter.unit,
        parameter.meaning
    )
}
