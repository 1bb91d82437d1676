//! Claims and gates, judged and put into words.

use std::cmp::Ordering;

use serde::Serialize;

use super::data::{Asked, Data, SceneOf};
use super::number::Style;
use crate::experiment::Unit;
use crate::experiment::{Expression, Judged, Measured, Swept, Verdict, judge, overall};

/// A claim or gate with its verdicts.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    pub text: String,
    /// Where the paper says so; empty for gates.
    pub place: String,
    pub expect: String,
    /// One of the words of [`words`], or `error`.
    pub verdict: String,
    /// Style class: `holds`, `fails`, `open`, `none`, `error`.
    pub class: String,
    /// Why the expression cannot be read, or empty.
    pub error: String,
    pub cases: Vec<CaseOf>,
    pub gate: bool,
}

/// The verdict for one scene and swept value.
#[derive(Clone, Debug, Serialize)]
pub struct CaseOf {
    pub scene: String,
    pub at: String,
    pub verdict: String,
    pub class: String,
    /// Our two sides in the order of the statement, `0.0749 < 0.0811`.
    pub ours: String,
    /// Their difference with its interval.
    pub margin: String,
    /// The paper's two sides, or empty.
    pub paper: String,
}

/// Judges every claim, then every gate.
pub fn judge_all(data: &Data) -> Vec<Claim> {
    let config = &data.config;
    let claims = config
        .claim
        .iter()
        .map(|c| judge_one(data, &c.text, &c.place, &c.expect, &c.scenes));
    let gates = config.gate.iter().map(|g| Claim {
        gate: true,
        ..judge_one(data, &g.text, "", &g.expect, &g.scenes)
    });
    claims.chain(gates).collect()
}

fn judge_one(data: &Data, text: &str, place: &str, expect: &str, scenes: &[String]) -> Claim {
    let claim = |verdict: &str, class: &str| Claim {
        text: text.to_owned(),
        place: place.to_owned(),
        expect: expect.to_owned(),
        verdict: verdict.to_owned(),
        class: class.to_owned(),
        error: String::new(),
        cases: Vec::new(),
        gate: false,
    };
    match Expression::parse(expect) {
        Err(error) => Claim {
            error,
            ..claim("cannot be read", "error")
        },
        Ok(expression) => {
            let judged = judge(&expression, &data.cases, scenes);
            let (verdict, class) = words(overall(&judged));
            Claim {
                cases: judged
                    .iter()
                    .map(|j| case_of(data, &expression, j))
                    .collect(),
                ..claim(verdict, class)
            }
        }
    }
}

fn case_of(data: &Data, expression: &Expression, judged: &Judged) -> CaseOf {
    let all = SceneOf::all();
    let scenes = data.scenes.iter().chain([&all]);
    let scene = scenes.into_iter().find(|s| s.name == judged.scene);
    let point = data.points().iter().find(|p| p.text() == judged.at);
    let (verdict, class) = words(judged.verdict);
    let there = judged.verdict != Verdict::NoData;
    CaseOf {
        scene: scene.map_or_else(|| judged.scene.clone(), SceneOf::title),
        at: judged.at.clone(),
        verdict: verdict.into(),
        class: class.into(),
        ours: if there {
            let (left, right) = judged.sides();
            sides(left, right)
        } else {
            String::new()
        },
        margin: match judged.repeats {
            _ if there => margin(judged),
            0 => String::new(),
            n => format!("only {n} of {} seeds", judged.seeds),
        },
        paper: scene
            .zip(point)
            .and_then(|(scene, point)| paper_sides(data, expression, scene, point))
            .unwrap_or_default(),
    }
}

fn sides(left: f64, right: f64) -> String {
    let sign = match left.partial_cmp(&right) {
        Some(Ordering::Less) => "<",
        Some(Ordering::Equal) => "=",
        _ => ">",
    };
    let style = Style::of(Unit::None, [left, right].into_iter());
    format!("{} {sign} {}", style.number(left), style.number(right))
}

fn margin(judged: &Judged) -> String {
    let difference = judged.larger - judged.smaller;
    let half = judged.half_width;
    let style = Style::of(Unit::None, [difference].into_iter().chain(half));
    let difference = style.number(difference);
    match half {
        Some(half) => format!(
            "{difference} ± {} ({} seeds)",
            style.number(half),
            judged.repeats
        ),
        None => format!("{difference} (one run)"),
    }
}

fn paper_sides(
    data: &Data,
    expression: &Expression,
    scene: &SceneOf,
    point: &Swept,
) -> Option<String> {
    let value = |column: &str, label: &str| {
        let label = label.strip_suffix("@*").unwrap_or(label);
        let asked = Asked {
            scene,
            label,
            point,
        };
        data.published(asked, column)
    };
    let Measured { smaller, larger } = expression.measure(&value)?;
    Some(match expression.larger_first() {
        true => sides(larger, smaller),
        false => sides(smaller, larger),
    })
}

/// A verdict in words, and its style class.
pub fn words(verdict: Verdict) -> (&'static str, &'static str) {
    match verdict {
        Verdict::Holds => ("holds", "holds"),
        Verdict::DoesNotHold => ("does not hold", "fails"),
        Verdict::Inconclusive => ("inconclusive", "open"),
        Verdict::NoData => ("no data", "none"),
    }
}
