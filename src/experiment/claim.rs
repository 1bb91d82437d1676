//! Statements over rows, judged per scene and swept value with the spread over repeats.

use serde::Serialize;

use super::{Expression, Row};
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
    /// No rows.
    NoData,
}

/// A statement judged for one scene and one combination of swept values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judged {
    pub scene: String,
    /// Swept values as text, empty without a sweep.
    pub at: String,
    pub verdict: Verdict,
    /// Mean of the side that is stated to be smaller, and of the larger one.
    pub smaller: f64,
    pub larger: f64,
    /// Half width of the 95 % interval of `larger − smaller`, paired by seed; `None` for one run.
    pub half_width: Option<f64>,
    pub repeats: usize,
}

/// `LABEL@*` is the mean of a contender over the scenes.
pub const EVERY_SCENE: &str = "*";

/// Judges an expression for every scene (of `scenes`, or all) and swept value; one that speaks of
/// means over scenes alone is judged once for each swept value.
pub fn judge(expression: &Expression, rows: &[Row], scenes: &[String]) -> Vec<Judged> {
    let about = |row: &Row| {
        scenes.is_empty()
            || scenes
                .iter()
                .any(|s| *s == row.scene || row.paper.as_deref() == Some(s))
    };
    let mut groups: Vec<(String, String)> = Vec::new();
    let names = expression.names();
    let of_every = |(_, label): &(&str, &str)| label.ends_with("@*");
    let means = !names.is_empty() && names.iter().all(of_every);
    for row in rows.iter().filter(|r| about(r)) {
        let scene = match means {
            true => EVERY_SCENE.to_owned(),
            false => row.scene.clone(),
        };
        let group = (scene, sweep_text(row));
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    groups
        .into_iter()
        .map(|group| judge_group(expression, (rows, &about), group))
        .collect()
}

/// Swept keys and values of a row as text.
pub fn sweep_text(row: &Row) -> String {
    let parts: Vec<String> = row
        .sweep
        .iter()
        .map(|(k, v)| match v.as_str() {
            Some(text) => format!("{k}={text}"),
            None => format!("{k}={v}"),
        })
        .collect();
    parts.join(" ")
}

/// Whether a row is of a scene that a statement is about.
type Admits<'a> = &'a dyn Fn(&Row) -> bool;

/// `LABEL` is a contender on the group's scene, `LABEL@SCENE` one on another scene and `LABEL@*` the
/// mean over the scenes that `about` admits, at the same swept values and seed.
fn judge_group(
    expression: &Expression,
    (rows, about): (&[Row], Admits),
    (scene, at): (String, String),
) -> Judged {
    let value = |column: &str, label: &str, seed: u64| {
        let (label, scene) = label.split_once('@').unwrap_or((label, &scene));
        let mut values = rows
            .iter()
            .filter(|r| r.ok() && r.seed == seed && r.label == label && sweep_text(r) == at)
            .filter(|r| r.scene == scene || scene == EVERY_SCENE && about(r))
            .map(|r| r.number(column));
        if scene != EVERY_SCENE {
            return values.next()?;
        }
        let values: Vec<f64> = values.collect::<Option<_>>()?;
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let in_group = |r: &&Row| (r.scene == scene || scene == EVERY_SCENE) && sweep_text(r) == at;
    let of_group = rows.iter().filter(in_group);
    let mut seeds: Vec<u64> = of_group.map(|r| r.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    let sides: Vec<(f64, f64)> = seeds
        .iter()
        .filter_map(|&seed| {
            let measured = expression.measure(&|column, label| value(column, label, seed))?;
            Some((measured.smaller, measured.larger))
        })
        .collect();
    let n = sides.len();
    let mean = |side: fn(&(f64, f64)) -> f64| sides.iter().map(side).sum::<f64>() / n.max(1) as f64;
    let (smaller, larger) = (mean(|s| s.0), mean(|s| s.1));
    let differences: Vec<f64> = sides.iter().map(|(s, l)| l - s).collect();
    let half_width = Summary::of(&differences).and_then(|s| s.half_width);
    let margin = larger - smaller;
    let verdict = if n == 0 || !margin.is_finite() {
        Verdict::NoData
    } else {
        match half_width {
            Some(half) if margin.abs() <= half => Verdict::Inconclusive,
            _ if margin > 0.0 => Verdict::Holds,
            _ => Verdict::DoesNotHold,
        }
    };
    Judged {
        scene,
        at,
        verdict,
        smaller,
        larger,
        half_width,
        repeats: n,
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

    fn verdict(rows: &[Row]) -> Verdict {
        let expression = Expression::parse("rmse(A) < rmse(B)").expect("parses");
        overall(&judge(&expression, rows, &[]))
    }

    #[test]
    fn means_over_scenes_are_judged_once() {
        let on = |scene: &str, row: Row| Row {
            scene: scene.into(),
            ..row
        };
        let rows = [
            on("s", row("A", 1, 0.3)),
            on("s", row("B", 1, 0.2)),
            on("t", row("A", 1, 0.1)),
            on("t", row("B", 1, 0.6)),
        ];
        let expression = Expression::parse("rmse(A@*) < rmse(B@*)").expect("parses");
        let judged = judge(&expression, &rows, &[]);
        assert_eq!(judged.len(), 1);
        assert_eq!(judged[0].verdict, Verdict::Holds);
        assert!((judged[0].smaller - 0.2).abs() < 1e-12 && (judged[0].larger - 0.4).abs() < 1e-12);
        let on_s = judge(&expression, &rows, &["s".into()]);
        assert_eq!(on_s[0].verdict, Verdict::DoesNotHold);
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
