//! Statements over rows, judged per scene and swept value with the spread over repeats.

use std::collections::{BTreeSet, HashSet};

use serde::Serialize;

use super::named::Named;
use super::{Case, Cases, Expression, NamedPlace, Swept};
use crate::metric::statistics::Summary;

/// What the rows say of a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// True beyond the 95 % interval over repeats (or of a single run).
    Holds,
    /// The interval reaches over both.
    Inconclusive,
    /// False beyond the interval (or of a single run).
    DoesNotHold,
    /// A run of those that are compared has no value: it failed, or is missing.
    NoData,
}

/// A statement judged for one scene and one combination of swept values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judged {
    /// As tables call it, or `*` for the mean over all.
    pub scene: String,
    /// Swept values as text, empty without a sweep.
    pub at: String,
    /// Whether it holds.
    pub verdict: Verdict,
    /// Mean of the side that is stated to be smaller, and of the larger one.
    pub smaller: f64,
    /// See `smaller`.
    pub larger: f64,
    /// Whether the larger side is written first.
    pub larger_first: bool,
    /// Half width of the 95 % interval of `larger − smaller`, paired by seed; `None` for one run.
    pub half_width: Option<f64>,
    /// Seeds for which both sides have a value.
    pub repeats: usize,
    /// Seeds that are expected of what is compared.
    pub seeds: usize,
}

impl Judged {
    /// Both sides as the statement has them.
    pub fn sides(&self) -> (f64, f64) {
        match self.larger_first {
            true => (self.larger, self.smaller),
            false => (self.smaller, self.larger),
        }
    }
}

/// `LABEL@*` is the mean of a contender over the scenes.
pub const EVERY_SCENE: &str = "*";

/// Judges an expression for every scene that is expected (of `scenes`, or all) and swept value; one that
/// speaks of means over scenes alone is judged once for each swept value, and one that says itself at which value of a key
/// once for all of that key.
pub fn judge(expression: &Expression, cases: &Cases, scenes: &[String]) -> Vec<Judged> {
    let about =
        |place: &&NamedPlace| scenes.is_empty() || scenes.iter().any(|name| place.is_called(name));
    let places: Vec<&NamedPlace> = cases.places.iter().filter(about).collect();
    let names: Vec<Named> = names_of(expression).collect();
    let means = names.iter().all(|name| name.scene == Some(EVERY_SCENE));
    let fixed = |key: &str| names.iter().all(|name| name.fixes(key));
    let (mut judged, mut said) = (Vec::new(), HashSet::new());
    let mut add = |place: Option<&NamedPlace>, at: &Swept| {
        let expected: Vec<&NamedPlace> = places
            .iter()
            .copied()
            .filter(|p| cases.expects(&p.place, at))
            .collect();
        let there = place.map_or(!expected.is_empty(), |p| expected.contains(&p));
        let own = at.without(fixed);
        if there && said.insert((place.map(|p| p.place.clone()), own.text())) {
            let group = Group {
                cases,
                place,
                expected,
                at,
                own: &own,
            };
            judged.push(group.judge(expression));
        }
    };
    if means {
        cases.points.iter().for_each(|at| add(None, at));
    } else {
        for place in &places {
            cases.points.iter().for_each(|at| add(Some(place), at));
        }
    }
    judged
}

fn names_of(expression: &Expression) -> impl Iterator<Item = Named<'_>> {
    let names = expression.names().into_iter();
    names.filter_map(|(_, label)| Named::parse(label).ok())
}

/// What a statement is judged for at once.
struct Group<'a> {
    cases: &'a Cases,
    /// `None`: the mean over all that are expected.
    place: Option<&'a NamedPlace>,
    /// The places that the statement is about and that have jobs at this swept value.
    expected: Vec<&'a NamedPlace>,
    at: &'a Swept,
    /// Those of them that the statement does not fix.
    own: &'a Swept,
}

impl Group<'_> {
    /// `LABEL` is a contender at the group's place, `LABEL@SCENE` one at another place and `LABEL@*` the
    /// mean over the expected places, at the same swept values, if it names no others, and seed. A mean that lacks a value
    /// of any place is no data.
    fn value(&self, column: &str, label: &str, seed: u64) -> Option<f64> {
        let cases = self.cases_of(label).into_iter();
        let values = cases.map(|case| self.cases.value(&case, seed, column));
        let values: Vec<f64> = values.collect::<Option<_>>()?;
        let count = Some(values.len()).filter(|count| *count > 0)?;
        Some(values.iter().sum::<f64>() / count as f64)
    }

    /// The cases that a label stands for; none where no scene has the name behind its `@`, or nothing ran at the values
    /// behind its `;`.
    fn cases_of(&self, label: &str) -> Vec<Case> {
        let Ok(named) = Named::parse(label) else {
            return Vec::new();
        };
        let Some(at) = named.point(&self.cases.points, self.at) else {
            return Vec::new();
        };
        let place = match named.scene {
            None => self.place,
            Some(EVERY_SCENE) => None,
            Some(name) => match self.cases.place(name) {
                None => return Vec::new(),
                place => place,
            },
        };
        let case = |place: &NamedPlace| self.cases.case(&place.place, named.label, at);
        match place {
            Some(place) => vec![case(place)],
            None => self.expected.iter().map(|place| case(place)).collect(),
        }
    }

    /// The seeds that are expected of any case that a statement speaks of.
    fn seeds(&self, expression: &Expression) -> BTreeSet<u64> {
        let names = expression.names().into_iter();
        let cases = names.flat_map(|(_, label)| self.cases_of(label));
        cases
            .flat_map(|case| self.cases.seeds_of(&case).collect::<Vec<_>>())
            .collect()
    }

    /// With a seed that has no value on one side, the others say nothing: it may be the one that decides.
    fn judge(&self, expression: &Expression) -> Judged {
        let seeds = self.seeds(expression);
        let sides: Vec<(f64, f64)> = seeds
            .iter()
            .filter_map(|&seed| {
                let value = |column: &str, label: &str| self.value(column, label, seed);
                let measured = expression.measure(&value)?;
                Some((measured.smaller, measured.larger))
            })
            .collect();
        let n = sides.len();
        let mean =
            |side: fn(&(f64, f64)) -> f64| sides.iter().map(side).sum::<f64>() / n.max(1) as f64;
        let (smaller, larger) = (mean(|s| s.0), mean(|s| s.1));
        let differences: Vec<f64> = sides.iter().map(|(s, l)| l - s).collect();
        let half_width = Summary::of(&differences).and_then(|s| s.half_width);
        let margin = larger - smaller;
        // Without a spread, as of one run or of counts, there is nothing to be in doubt about.
        let is_open = half_width.is_some_and(|half| half > 0.0 && margin.abs() <= half);
        let verdict = if n == 0 || n < seeds.len() || !margin.is_finite() {
            Verdict::NoData
        } else if is_open {
            Verdict::Inconclusive
        } else if margin > 0.0 || (margin == 0.0 && expression.or_equal()) {
            Verdict::Holds
        } else {
            Verdict::DoesNotHold
        };
        Judged {
            scene: self.place.map_or(EVERY_SCENE, |p| &p.name).to_owned(),
            at: self.own.text(),
            verdict,
            smaller,
            larger,
            larger_first: expression.larger_first(),
            half_width,
            repeats: n,
            seeds: seeds.len(),
        }
    }
}

/// One verdict for all scenes and values: false if it is false anywhere, open if it is open anywhere.
pub fn overall(judged: &[Judged]) -> Verdict {
    let any = |verdict| judged.iter().any(|j| j.verdict == verdict);
    if any(Verdict::DoesNotHold) {
        Verdict::DoesNotHold
    } else if any(Verdict::Inconclusive) {
        Verdict::Inconclusive
    } else if any(Verdict::Holds) && !any(Verdict::NoData) {
        Verdict::Holds
    } else {
        Verdict::NoData
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Row;

    fn row(label: &str, seed: u64, rmse: f64) -> Row {
        Row {
            label: label.into(),
            scene: "s".into(),
            seed,
            rmse: Some(rmse),
            status: "ok".into(),
            ..Row::default()
        }
    }

    fn judged(expression: &str, rows: &[Row]) -> Vec<Judged> {
        let expression = Expression::parse(expression).expect("parses");
        judge(&expression, &Cases::new(&[], rows.to_vec()), &[])
    }

    fn verdict(rows: &[Row]) -> Verdict {
        overall(&judged("rmse(A) < rmse(B)", rows))
    }

    fn on(scene: &str, row: Row) -> Row {
        Row {
            scene: scene.into(),
            ..row
        }
    }

    #[test]
    fn two_values_of_a_sweep_are_compared_once() {
        let at = |viewers: u32, row: Row| Row {
            sweep: [("viewers".to_owned(), viewers.into())]
                .into_iter()
                .collect(),
            ..row
        };
        let rows: Vec<Row> = (1..4)
            .flat_map(|seed| {
                [
                    at(8, row("A", seed, 0.3)),
                    at(16, row("A", seed, 0.4)),
                    at(8, row("B", seed, 0.1)),
                    at(16, row("B", seed, 0.5)),
                ]
            })
            .collect();
        let of = |text: &str| -> Vec<(String, Verdict)> {
            let judged = judged(text, &rows);
            judged.into_iter().map(|j| (j.at, j.verdict)).collect()
        };
        let once = of("rmse(A; viewers=8) < 0.8 * rmse(B; viewers=16)");
        assert_eq!(once, [(String::new(), Verdict::Holds)]);
        let mean = of("rmse(A@*; viewers=8) > 0.8 * rmse(B@*; viewers=16)");
        assert_eq!(mean, [(String::new(), Verdict::DoesNotHold)]);
        let both = of("rmse(A) < rmse(B@s; viewers=16)");
        assert_eq!(both.len(), 2);
        assert!(both.iter().all(|(_, verdict)| *verdict == Verdict::Holds));
        assert_eq!(both[1].0, "viewers=16");
        let none = of("rmse(A; viewers=9) < 1");
        assert_eq!(none, [(String::new(), Verdict::NoData)]);
    }

    #[test]
    fn a_mean_without_one_of_its_scenes_is_no_data() {
        let mut rows = vec![
            on("easy", row("A", 1, 0.1)),
            on("easy", row("B", 1, 0.2)),
            on("hard", row("A", 1, 5.0)),
            on("hard", row("B", 1, 0.3)),
        ];
        let of = |rows: &[Row]| overall(&judged("rmse(A@*) < rmse(B@*)", rows));
        assert_eq!(of(&rows), Verdict::DoesNotHold);
        rows[2].status = "failed: it crashed on the hard scene".into();
        assert_eq!(of(&rows), Verdict::NoData);
        rows.remove(2);
        assert_eq!(of(&rows), Verdict::NoData);
    }

    #[test]
    fn a_failed_or_missing_seed_is_no_data() {
        let run = |label, seed, rmse| on("easy", row(label, seed, rmse));
        let mut rows: Vec<Row> = (1..4)
            .flat_map(|seed| [run("A", seed, 0.1), run("B", seed, 0.2)])
            .collect();
        assert_eq!(verdict(&rows), Verdict::Holds);
        rows[2].status = "failed: it crashed with this seed".into();
        let failed = judged("rmse(A) < rmse(B)", &rows).remove(0);
        assert_eq!(failed.verdict, Verdict::NoData);
        assert_eq!((failed.repeats, failed.seeds), (2, 3));
        rows.remove(2);
        for statement in [
            "rmse(A) < rmse(B)",
            "rmse(A@*) < rmse(B@*)",
            "rmse(A@easy) < rmse(B)",
        ] {
            assert_eq!(overall(&judged(statement, &rows)), Verdict::NoData);
        }
        assert_eq!(overall(&judged("rmse(B) < 1", &rows)), Verdict::Holds);
    }

    #[test]
    fn two_views_of_a_scene_are_judged_apart() {
        let from = |view: &str, row: Row| Row {
            view: view.into(),
            ..row
        };
        let rows = [
            from("top", row("A", 1, 0.1)),
            from("top", row("B", 1, 0.2)),
            from("front", row("A", 1, 0.3)),
            from("front", row("B", 1, 0.2)),
        ];
        let apart = judged("rmse(A) < rmse(B)", &rows);
        let verdicts: Vec<_> = apart
            .iter()
            .map(|j| (j.scene.as_str(), j.verdict))
            .collect();
        let expected = [
            ("s (top)", Verdict::Holds),
            ("s (front)", Verdict::DoesNotHold),
        ];
        assert_eq!(verdicts, expected);
        let named = judged("rmse(A@s (front)) > rmse(A@s (top))", &rows);
        assert!(named.iter().all(|j| j.verdict == Verdict::Holds));
        assert_eq!(overall(&judged("rmse(A@s) < 1", &rows)), Verdict::NoData);
    }

    #[test]
    fn means_over_scenes_are_judged_once() {
        let rows = [
            on("s", row("A", 1, 0.3)),
            on("s", row("B", 1, 0.2)),
            on("t", row("A", 1, 0.1)),
            on("t", row("B", 1, 0.6)),
        ];
        let expression = Expression::parse("rmse(A@*) < rmse(B@*)").expect("parses");
        let cases = Cases::new(&[], rows.to_vec());
        let judged = judge(&expression, &cases, &[]);
        assert_eq!(judged.len(), 1);
        assert_eq!(judged[0].verdict, Verdict::Holds);
        assert!((judged[0].smaller - 0.2).abs() < 1e-12 && (judged[0].larger - 0.4).abs() < 1e-12);
        let on_s = judge(&expression, &cases, &["s".into()]);
        assert_eq!(on_s[0].verdict, Verdict::DoesNotHold);
    }

    #[test]
    fn equal_sides_hold_where_the_statement_says_so() {
        let once = [row("A", 1, 0.2), row("B", 1, 0.2)];
        let thrice: Vec<Row> = (1..4)
            .flat_map(|s| [row("A", s, 0.2), row("B", s, 0.2)])
            .collect();
        for rows in [&once[..], &thrice] {
            let of = |expression: &str| overall(&judged(expression, rows));
            assert_eq!(of("rmse(A) <= rmse(B)"), Verdict::Holds);
            assert_eq!(of("rmse(A) >= rmse(B)"), Verdict::Holds);
            assert_eq!(of("rmse(A) < rmse(B)"), Verdict::DoesNotHold);
            assert_eq!(of("rmse(A) > rmse(B)"), Verdict::DoesNotHold);
        }
        let apart = [row("A", 1, 0.3), row("B", 1, 0.2)];
        let of = |expression: &str| overall(&judged(expression, &apart));
        assert_eq!(of("rmse(A) <= rmse(B)"), Verdict::DoesNotHold);
        assert_eq!(of("rmse(A) >= rmse(B)"), Verdict::Holds);
    }

    #[test]
    fn repeats_decide_and_noise_leaves_it_open() {
        let clear: Vec<Row> = (0..3)
            .flat_map(|s| [row("A", s, 0.1 + s as f64 * 0.001), row("B", s, 0.2)])
            .collect();
        assert_eq!(verdict(&clear), Verdict::Holds);
        let open = [
            row("A", 1, 0.1),
            row("B", 1, 0.2),
            row("A", 2, 0.2),
            row("B", 2, 0.15),
        ];
        assert_eq!(verdict(&open), Verdict::Inconclusive);
        assert_eq!(
            verdict(&[row("A", 1, 0.3), row("B", 1, 0.2)]),
            Verdict::DoesNotHold
        );
        assert_eq!(verdict(&[row("A", 1, 0.3)]), Verdict::NoData);
    }
}
