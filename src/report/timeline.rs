//! Columns of `frames.csv` over the frames of a sequence: a panel for each column and swept value.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;

use super::axis::Axis;
use super::data::{Asked, Data, SceneOf};
use super::estimate::Estimate;
use super::figure::{shows_method, title_of};
use super::frame_table::FrameTable;
use super::lacking;
use super::plot::axis_name;
use super::timeline_plot::{Line, Panel, Point, Timeline};
use crate::experiment::{FigureSpec, Sequence, Swept, frame_column};

/// Panels side by side at most.
const ACROSS: usize = 2;
/// Numbers that are roots of means: of several viewers they are averaged as such, as rows do.
const ROOTS: [&str; 4] = ["rmse", "rmse_cold", "error_change", "reference_floor"];

/// A method at a swept value.
struct Played {
    /// Its position in the config.
    method: usize,
    runs: Vec<Run>,
}

/// The frames of one seed.
struct Run {
    seed: u64,
    frames: FrameTable,
}

/// What is drawn of a scene, and its caption; says why when there is nothing to draw. Jobs without a readable `frames.csv` and columns
/// without values become notes.
pub fn of_scene(
    data: &Data,
    spec: &FigureSpec,
    scene: &SceneOf,
    notes: &mut Vec<String>,
) -> Result<(Timeline, String), String> {
    let columns = columns(spec);
    let points: Vec<&Swept> = data
        .points()
        .iter()
        .filter(|point| data.sequence(scene, point).is_some())
        .collect();
    let mut panels: Vec<Vec<Panel>> = columns.iter().map(|_| Vec::new()).collect();
    let mut viewers = Vec::new();
    for point in &points {
        let played = played(data, spec, scene, point, notes);
        let Some(sequence) = data.sequence(scene, point) else {
            continue;
        };
        viewers = sequence.viewer_names();
        for (column, panels) in columns.iter().zip(&mut panels) {
            panels.push(panel(&played, sequence, point, spec, column));
        }
    }
    for (column, panels) in columns.iter().zip(&panels) {
        if panels.iter().all(Panel::is_empty) {
            let (figure, scene) = (&spec.name, &scene.name);
            notes.push(format!(
                "figure `{figure}` of {scene}: no frame has `{column}`"
            ));
        }
    }
    panels.retain(|panels| !panels.iter().all(Panel::is_empty));
    if panels.is_empty() {
        return Err("no finished job has the columns of its axes".into());
    }
    let several = spec.per_viewer && viewers.len() > 1;
    let timeline = Timeline {
        title: format!("{} — {}", title_of(spec), scene.title()),
        across: points
            .len()
            .clamp(1, spec.columns.map_or(ACROSS, NonZeroUsize::get)),
        has_warm_up: panels.iter().flatten().any(|p| p.warm_up_end.is_some()),
        columns: panels,
        methods: methods(data, spec),
        viewers: if several { viewers.clone() } else { Vec::new() },
    };
    let mut caption = caption(data, &timeline, viewers.len());
    caption.push_str(&lacking::seeds(data, spec, Some(scene)));
    Ok((timeline, caption))
}

fn columns(spec: &FigureSpec) -> Vec<String> {
    match spec.y.is_empty() {
        true => vec!["rmse".into()],
        false => spec.y.clone(),
    }
}

/// Positions in the config, and labels.
fn methods(data: &Data, spec: &FigureSpec) -> Vec<(usize, String)> {
    let labels = data.labels().iter().cloned().enumerate();
    labels.filter(|(_, l)| shows_method(spec, l)).collect()
}

fn played(
    data: &Data,
    spec: &FigureSpec,
    scene: &SceneOf,
    point: &Swept,
    notes: &mut Vec<String>,
) -> Vec<Played> {
    let mut of_method = |(method, label): (usize, String)| {
        let label = &label;
        let asked = Asked {
            scene,
            label,
            point,
        };
        let case = data.case(asked);
        let rows = data.cases.rows_of(&case);
        let runs = rows.filter_map(|row| {
            let table = FrameTable::of(data, row).map_err(|reason| notes.push(reason));
            Some(Run {
                seed: row.seed,
                frames: table.ok()?,
            })
        });
        Played {
            method,
            runs: runs.collect(),
        }
    };
    methods(data, spec)
        .into_iter()
        .map(&mut of_method)
        .collect()
}

fn panel(
    played: &[Played],
    sequence: &Sequence,
    point: &Swept,
    spec: &FigureSpec,
    column: &str,
) -> Panel {
    let in_time = spec.x.as_deref() == Some("time");
    let x = |frame: u32| match in_time {
        true => sequence.time_s(frame),
        false => f64::from(frame),
    };
    let viewers: Vec<Option<usize>> = match spec.per_viewer {
        true => (0..sequence.viewers.len()).map(Some).collect(),
        false => vec![None],
    };
    let mut lines = Vec::new();
    for Played { method, runs } in played {
        for viewer in &viewers {
            let values = values(runs, column, *viewer);
            let point = |(place, frame): (usize, &u32)| {
                let estimate = values.get(frame)?;
                Some(Point {
                    place,
                    x: x(*frame),
                    y: estimate.mean,
                    half: estimate.half_width.unwrap_or(0.0),
                })
            };
            lines.push(Line {
                method: *method,
                viewer: viewer.unwrap_or(0),
                points: sequence
                    .frames
                    .iter()
                    .enumerate()
                    .filter_map(point)
                    .collect(),
            });
        }
    }
    let (first, last) = (
        sequence.frames[0],
        sequence.frames[sequence.frames.len() - 1],
    );
    let step = if in_time { 0.0 } else { 1.0 };
    let before = sequence.warm_up.checked_sub(1);
    Panel {
        title: point.text(),
        x: (
            if in_time { "time, s" } else { "frame" }.into(),
            Axis::between([x(first), x(last)], step),
        ),
        y: (axis_name(frame_column(column)), scale(&lines)),
        warm_up_end: before.map(|last| {
            let ends = [last, last + 1].map(|place| x(sequence.frames[place]));
            (ends[0] + ends[1]) / 2.0
        }),
        lines,
    }
}

/// An axis for all values, and for what lies within their intervals unless that is far from all values.
fn scale(lines: &[Line]) -> Axis {
    let points = || lines.iter().flat_map(|line| &line.points);
    let most = 1.3 * points().map(|p| p.y).fold(0.0, f64::max);
    let ends = points().flat_map(|p| [p.y, (p.y + p.half).min(most.max(p.y))]);
    Axis::over(ends, true)
}

/// Of each frame the mean over viewers and seeds, with its interval over seeds.
fn values(runs: &[Run], column: &str, viewer: Option<usize>) -> BTreeMap<u32, Estimate> {
    let mut of_frames: BTreeMap<u32, BTreeMap<u64, Vec<f64>>> = BTreeMap::new();
    for Run { seed, frames } in runs {
        let seen = |v: u16| viewer.is_none_or(|viewer| viewer == usize::from(v));
        for line in frames.lines.iter().filter(|line| seen(line.viewer)) {
            if let Some(value) = frames.number(line, column) {
                let of_frame = of_frames.entry(line.frame).or_default();
                of_frame.entry(*seed).or_default().push(value);
            }
        }
    }
    let mean = |values: Vec<f64>| match (&values[..], ROOTS.contains(&column)) {
        ([one], _) => *one,
        (all, true) => (all.iter().map(|v| v * v).sum::<f64>() / all.len() as f64).sqrt(),
        (all, false) => all.iter().sum::<f64>() / all.len() as f64,
    };
    let estimate = |seeds: BTreeMap<u64, Vec<f64>>| {
        Estimate::new(seeds.into_iter().map(|(seed, v)| (seed, mean(v))).collect())
    };
    let estimates = of_frames.into_iter();
    estimates
        .filter_map(|(frame, seeds)| Some((frame, estimate(seeds)?)))
        .collect()
}

fn caption(data: &Data, timeline: &Timeline, viewers: usize) -> String {
    let seeds = data.config.repeats > 1;
    let mut text = match (seeds, viewers > 1 && timeline.viewers.is_empty()) {
        (true, true) => "Means over seeds and viewers".to_owned(),
        (true, false) => "Means over seeds".into(),
        (false, true) => "Means over viewers".into(),
        (false, false) => "Every measured frame".into(),
    };
    text.push_str(match seeds {
        true => "; bands are 95 % confidence intervals over seeds.",
        false => ".",
    });
    if timeline.has_warm_up {
        text.push_str(" Shaded: the warm-up, which is not measured.");
    }
    text
}
