//! What a config says about rows, checked before the first ray: claims, gates, tables, figures.

use super::Job;
use super::config::{Config, ConfigError, Source};
use super::known_names::Names;
use super::reported::FigureSpec;
use super::sequence::{frame_columns, is_frame_column};
use crate::suggest::hint;

/// Checks every expression, label and column against the labels and scenes of the planned jobs, which are
/// those of their rows.
pub fn check(source: &Source, config: &Config, jobs: &[Job]) -> Result<(), ConfigError> {
    let names = Names::of(config, jobs);
    let claims = config.claim.iter().map(|c| (&c.expect, &c.scenes));
    let gates = config.gate.iter().map(|g| (&g.expect, &g.scenes));
    for (list, (index, (expect, scenes))) in claims
        .enumerate()
        .map(|c| ("claim", c))
        .chain(gates.enumerate().map(|g| ("gate", g)))
    {
        let index = index.to_string();
        let at = |key: &str, message| source.error(&[list, &index, key], message);
        names.expression(expect).map_err(|m| at("expect", m))?;
        for scene in scenes {
            names
                .scene_of(config, scene)
                .map_err(|m| at("scenes", format!("scenes: {m}")))?;
        }
    }
    for (index, table) in config.table.iter().enumerate() {
        if table.metrics.is_empty() && table.kind.shows_metrics() {
            let message = "metrics: an empty list leaves the table no column: name some, or leave the key out for rmse and flip_ldr";
            return Err(source.error(&["table", &index.to_string(), "metrics"], message.into()));
        }
        for column in table.metrics.iter().chain([&table.cost]) {
            names.column(column).map_err(|message| {
                source.error(&["table", &index.to_string(), "metrics"], message)
            })?;
        }
    }
    for (index, published) in config.published.iter().enumerate() {
        let index = index.to_string();
        for column in published.values.keys() {
            // Of `averages`: the mean rank by a column.
            let column = column.strip_prefix("rank_").unwrap_or(column);
            names.column(column).map_err(|message| {
                source.error(&["published", &index, "values", column], message)
            })?;
        }
    }
    for (index, figure) in config.figure.iter().enumerate() {
        let index = index.to_string();
        let at = |key: &str, message| source.error(&["figure", &index, key], message);
        if figure.kind.is_about_frames() {
            about_frames(config, figure).map_err(|(key, message)| at(key, message))?;
        } else {
            for (key, column) in figure.x.iter().map(|x| ("x", x)).chain(y(figure)) {
                names.column(column).map_err(|message| at(key, message))?;
            }
        }
        on_paper(figure).map_err(|(key, message)| at(key, message))?;
        for pattern in &figure.scenes {
            names
                .shown(config, pattern)
                .map_err(|message| at("scenes", message))?;
        }
        for label in &figure.methods {
            names
                .label(label)
                .map_err(|message| at("methods", message))?;
        }
    }
    Ok(())
}

fn y(figure: &FigureSpec) -> impl Iterator<Item = (&'static str, &String)> {
    figure.y.iter().map(|y| ("y", y))
}

/// Checks sizes and insets of a figure; else the key that is at fault, and why.
fn on_paper(figure: &FigureSpec) -> Result<(), (&'static str, String)> {
    let sizes = [
        ("width_mm", figure.width_mm, 10.0..=2000.0),
        ("font_pt", figure.font_pt, 2.0..=72.0),
    ];
    for (key, size, range) in sizes {
        if let Some(size) = size.filter(|size| !range.contains(size)) {
            let (low, high) = (range.start(), range.end());
            return Err((key, format!("{key} is {low} to {high}, found {size}")));
        }
    }
    let lies_within = |[x, y, width, height]: &[f64; 4]| {
        let along = |from: f64, length: f64| from >= 0.0 && length > 0.0 && from + length <= 1.0;
        along(*x, *width) && along(*y, *height)
    };
    match figure.insets.iter().find(|inset| !lies_within(inset)) {
        None => Ok(()),
        Some(inset) => {
            let why =
                "an inset is [x, y, width, height] in fractions of the image and lies within it";
            Err(("insets", format!("{why}, found {inset:?}")))
        }
    }
}

/// Checks a figure about frames; else the key that is at fault, and why.
fn about_frames(config: &Config, figure: &FigureSpec) -> Result<(), (&'static str, String)> {
    if config.sequence.is_none() {
        let why = "a figure of this kind is about the frames of a sequence, and the config has no [sequence]";
        return Err(("kind", why.into()));
    }
    if let Some(x) = figure
        .x
        .as_ref()
        .filter(|x| !["frame", "time"].contains(&x.as_str()))
    {
        let why = format!("x of a figure about frames is `frame` or `time`, found `{x}`");
        return Err(("x", why));
    }
    match y(figure).find(|(_, column)| !is_frame_column(column)) {
        None => Ok(()),
        Some((key, column)) => {
            let known = frame_columns();
            let names: Vec<&str> = known.iter().map(String::as_str).collect();
            let why = format!(
                "frames have no column `{column}`{} There are: {}, seconds_<stage> and cpu_seconds_<stage>",
                hint(column, &names),
                names.join(", ")
            );
            Err((key, why))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::{Job, Override, plan};

    const CONFIG: &str = r#"
name = "n"
technique = "ambient-occlusion"
caches = 60
[[scene]]
name = "hard-cases"
view = "poles"
[[scene]]
name = "hard-cases"
view = "VIEW"
[[method]]
id = "IM"
[[claim]]
text = "t"
where = "w"
expect = "EXPECT"
"#;

    /// What planning says of the config with more text at its end.
    fn planned_with(more: &str) -> Result<(), String> {
        let text = CONFIG.replace("EXPECT", "rmse(IM) < 1");
        let text = text.replace("view = \"VIEW\"", "view = \"poles\"\nlabel = \"again\"");
        let source = Source {
            file: "c.toml".into(),
            text: format!("{text}{more}"),
        };
        plan(&source, &[]).map(drop).map_err(|e| e.to_string())
    }

    fn planned(expect: &str, overrides: &[Override]) -> Result<Vec<Job>, String> {
        let description = crate::scene::find_scene("hard-cases").expect("shipped");
        let other = description.views.iter().find(|v| v.name != "poles");
        let view = &other.expect("a second view").name;
        let source = Source {
            file: "c.toml".into(),
            text: CONFIG.replace("EXPECT", expect).replace("VIEW", view),
        };
        let (_, plan) = plan(&source, overrides).map_err(|e| e.to_string())?;
        Ok(plan.jobs)
    }

    #[test]
    fn a_scene_of_several_views_is_named_with_one() {
        planned("rmse(IM@hard-cases (poles)) < 1", &[]).expect("plans");
        let error = planned("rmse(IM@hard-cases) < 1", &[]).expect_err("several");
        assert!(
            error.contains("hard-cases (poles), hard-cases ("),
            "{error}"
        );
        let error = planned("rmse(IM@elsewhere) < 1", &[]).expect_err("none");
        assert!(error.contains("no scene is called `elsewhere`"), "{error}");
    }

    #[test]
    fn swept_values_that_a_claim_names_are_those_of_the_sweep() {
        let sweep = [Override::parse("caches=40,60").expect("override")];
        planned("rmse(IM; caches=60) < rmse(IM; caches=40)", &sweep).expect("plans");
        for (expect, expected) in [
            (
                "rmse(IM; caches=50) < 1",
                "never 50 in the sweep, but 40, 60",
            ),
            ("rmse(IM; cache=60) < 1", "`cache` is not swept"),
            ("rmse(IM; caches) < 1", "expected a swept key and its value"),
        ] {
            let error = planned(expect, &sweep).expect_err(expect);
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn claims_and_gates_are_about_scenes_that_are_there() {
        let planned = |head: &str, scenes: &str| {
            planned_with(&format!(
                "\n{head}\ntext = \"t\"\nexpect = \"rmse(IM) < 1\"\nscenes = {scenes}"
            ))
        };
        let (claim, gate) = ("[[claim]]\nwhere = \"w\"", "[[gate]]");
        for head in [claim, gate] {
            planned(head, r#"["hard-cases", "again"]"#).expect("plans");
            let error = planned(head, r#"["again", "hard-case"]"#).expect_err("unknown");
            let expected = "scenes: no scene is called `hard-case`; did you mean `hard-cases`? \
                            There are: hard-cases, again";
            assert!(error.contains(expected), "{error}");
        }
        let error = planned(gate, r#"["attic"]"#).expect_err("unknown");
        assert!(error.starts_with("c.toml:22:1: scenes: no"), "{error}");
    }

    #[test]
    fn published_numbers_are_of_columns() {
        let planned = |values: &str| {
            planned_with(&format!(
                "\n[[published]]\nwhere = \"Table 1\"\nscene = \"*\"\nmethod = \"IM\"\nvalues = {values}"
            ))
        };
        planned("{ rmse = 1, flip = 1, rank_rmse = 2, seconds_placement = 3, sigma_a_deg = 4 }")
            .expect("plans");
        let error = planned("{ rmse = 1, rmes = 1 }").expect_err("unknown");
        assert!(
            error.starts_with("c.toml:") && error.contains("`rmes`; did you mean `rmse`?"),
            "{error}"
        );
    }

    #[test]
    fn tables_have_a_column_at_least() {
        let planned = |keys: &str| planned_with(&format!("\n[[table]]\nname = \"t\"\n{keys}"));
        for kind in [
            "methods",
            "averages",
            "sweep",
            "change",
            "equal-cost",
            "equal-error",
        ] {
            let error = planned(&format!("kind = \"{kind}\"\nmetrics = []")).expect_err(kind);
            assert!(
                error.starts_with("c.toml:22:1: metrics: an empty list"),
                "{error}"
            );
        }
        planned("kind = \"stages\"\nmetrics = []").expect("its columns are others");
    }

    #[test]
    fn figures_about_frames_need_a_sequence_and_its_columns() {
        let planned = |sequence: &str, figure: &str| {
            planned_with(&format!("{sequence}\n[[figure]]\nname = \"f\"\n{figure}"))
        };
        let sequence = "[sequence]\nframes = 4";
        let figure = "kind = \"timeline\"\ny = [\"rmse\", \"seconds_placement\"]";
        planned(sequence, figure).expect("plans");
        let error = planned("", figure).expect_err("no sequence");
        assert!(
            error.starts_with("c.toml:21:1: a figure of this kind"),
            "{error}"
        );
        let error = planned(sequence, &figure.replace("rmse", "rmes")).expect_err("unknown");
        assert!(
            error.starts_with("c.toml:23:1: frames have no column `rmes`; did you mean `rmse`?"),
            "{error}"
        );
        let error = planned(sequence, "kind = \"timeline\"\nx = \"caches\"").expect_err("x");
        assert!(
            error.contains("is `frame` or `time`, found `caches`"),
            "{error}"
        );
    }

    #[test]
    fn figures_are_as_large_as_paper_and_their_text_can_be_read() {
        let planned = |keys: &str| {
            planned_with(&format!(
                "\n[[figure]]\nname = \"f\"\nkind = \"curves\"\n{keys}"
            ))
        };
        planned("width_mm = 85\nfont_pt = 8").expect("plans");
        for (keys, why) in [
            ("width_mm = 0", "width_mm is 10 to 2000, found 0"),
            ("font_pt = 100", "font_pt is 2 to 72, found 100"),
        ] {
            let error = planned(keys).expect_err(keys);
            assert!(error.contains(why), "{error}");
        }
    }

    #[test]
    fn found_and_set_parameters_and_swept_keys_are_columns() {
        for column in ["allowed_error", "passes", "affordable", "sigma_a_deg"] {
            planned(&format!("{column}(IM) < 1"), &[]).expect(column);
        }
        let swept = Override::parse("parameters.side=8,16").expect("reads");
        planned("parameters.side(IM) < 1", &[swept]).expect("swept");
        let error = planned("rmes(IM) < 1", &[]).expect_err("unknown");
        assert!(error.contains("did you mean `rmse`?"), "{error}");
        let error = planned("label(IM) < 1", &[]).expect_err("text");
        assert!(error.contains("no column is called `label`"), "{error}");
    }
}
