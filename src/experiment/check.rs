//! What a config says about rows, checked before the first ray: claims, gates, tables, figures.

use std::collections::{BTreeMap, BTreeSet};

use super::case::{Case, NamedPlace, Swept, as_in_rows, name_places, place_named, value_text};
use super::claim::EVERY_SCENE;
use super::config::{Config, ConfigError, Source};
use super::expression::Expression;
use super::named::Named;
use super::reported::FigureSpec;
use super::sequence::{frame_columns, is_frame_column};
use super::{Job, columns};
use crate::cache::interpolation::INTERPOLATIONS;
use crate::registry::TECHNIQUES;
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

/// Checks the sizes of a figure; else the key that is at fault, and why.
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
    Ok(())
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

/// What claims, tables and figures may name.
struct Names<'a> {
    labels: Vec<&'a str>,
    places: Vec<NamedPlace>,
    /// Keys, and what they are set to in turn: as the config has it, and as overrides do.
    swept: BTreeMap<String, BTreeSet<String>>,
}

impl<'a> Names<'a> {
    fn of(config: &Config, jobs: &'a [Job]) -> Self {
        let mut labels: Vec<&str> = jobs.iter().map(|job| job.label.as_str()).collect();
        labels.sort_unstable();
        labels.dedup();
        let mut swept: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (key, values) in &config.sweep {
            let values = values.iter().map(|value| value_text(&as_in_rows(value)));
            swept.insert(key.clone(), values.collect());
        }
        for (key, value) in jobs.iter().flat_map(|job| Swept::of_job(job).values) {
            swept.entry(key).or_default().insert(value_text(&value));
        }
        let places = jobs.iter().map(|job| (Case::of_job(job).place, None));
        Self {
            labels,
            places: name_places(places),
            swept,
        }
    }

    fn expression(&self, text: &str) -> Result<(), String> {
        let expression = Expression::parse(text)?;
        for (column, label) in expression.names() {
            self.column(column)?;
            let named = Named::parse(label)?;
            self.label(named.label)?;
            named.scene.map_or(Ok(()), |scene| self.scene(scene))?;
            for (key, value) in named.at {
                self.swept_value(key, value)?;
            }
        }
        Ok(())
    }

    fn scene(&self, scene: &str) -> Result<(), String> {
        if scene == EVERY_SCENE || place_named(&self.places, scene).is_some() {
            return Ok(());
        }
        let list = |of: &dyn Fn(&&NamedPlace) -> bool| {
            let names: Vec<&str> = self
                .places
                .iter()
                .filter(of)
                .map(|p| p.name.as_str())
                .collect();
            names.join(", ")
        };
        match list(&|p| p.place.scene == scene) {
            views if views.is_empty() => Err(format!(
                "no scene is called `{scene}`{}; there are: {}",
                hint(scene, &self.scenes()),
                list(&|_| true)
            )),
            views => Err(format!(
                "`{scene}` is seen from several views; say which: {views}"
            )),
        }
    }

    /// Checks a scene that a claim or gate is about: any name that it has will do, the paper's too, and that of a scene
    /// which another may stand in for.
    fn scene_of(&self, config: &Config, scene: &str) -> Result<(), String> {
        let written = config.scene.iter().flat_map(|choice| {
            let replaced = choice.otherwise.as_ref().map(|_| choice.name.as_str());
            choice.paper.as_deref().into_iter().chain(replaced)
        });
        let mut known = self.scenes();
        known.extend(self.places.iter().map(|p| p.place.scene.as_str()));
        known.extend(written);
        if known.contains(&scene) {
            return Ok(());
        }
        let mut seen = BTreeSet::new();
        known.retain(|name| seen.insert(*name));
        Err(format!(
            "no scene is called `{scene}`{} There are: {}",
            match hint(scene, &known) {
                none if none.is_empty() => ".".to_owned(),
                hint => hint,
            },
            known.join(", ")
        ))
    }

    fn scenes(&self) -> Vec<&str> {
        self.places.iter().map(|p| p.name.as_str()).collect()
    }

    fn label(&self, label: &str) -> Result<(), String> {
        if self.labels.contains(&label) {
            return Ok(());
        }
        Err(format!(
            "no method is called `{label}`{}; there are: {}",
            hint(label, &self.labels),
            self.labels.join(", ")
        ))
    }

    /// Checks a value that a claim or gate names behind `;`.
    fn swept_value(&self, key: &str, value: &str) -> Result<(), String> {
        let Some(values) = self.swept.get(key) else {
            let known: Vec<&str> = self.swept.keys().map(String::as_str).collect();
            return Err(format!(
                "`{key}` is not swept{}; there are: {}",
                hint(key, &known),
                known.join(", ")
            ));
        };
        if values.contains(value) {
            return Ok(());
        }
        let values: Vec<&str> = values.iter().map(String::as_str).collect();
        Err(format!(
            "`{key}` is never {value} in the sweep, but {}",
            values.join(", ")
        ))
    }

    fn column(&self, column: &str) -> Result<(), String> {
        if columns::is_declared(column)
            || self.swept.contains_key(column)
            || parameters().any(|key| key == column)
        {
            return Ok(());
        }
        let mut known: Vec<&str> = columns::declared().chain(parameters()).collect();
        known.extend(self.swept.keys().map(String::as_str));
        let hint = match hint(column, &known) {
            none if none.is_empty() => ".".to_owned(),
            hint => hint,
        };
        let listed: Vec<&str> = columns::declared().collect();
        Err(format!(
            "no column is called `{column}`{hint} There are: {}, seconds_<stage>, cpu_seconds_<stage>, \
             serial_share_<stage>, the methods' parameters and swept keys",
            listed.join(", ")
        ))
    }
}

/// Parameters that any contender declares: rows carry those that are set.
fn parameters() -> impl Iterator<Item = &'static str> {
    let listed = TECHNIQUES
        .iter()
        .flat_map(|technique| (technique.contenders)());
    let parts = listed.flat_map(|listed| listed.parts);
    let interpolations = INTERPOLATIONS.iter().map(|e| &e.about);
    parts
        .chain(interpolations)
        .flat_map(|about| about.parameters.iter().map(|p| p.key))
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
