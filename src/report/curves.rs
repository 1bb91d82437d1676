//! Error against a swept or measured quantity: one panel per metric and scene.

use std::num::NonZeroUsize;

use glam::Vec2;

use super::axis::Axis;
use super::chart::{Around, Chart};
use super::data::{Asked, Data, SceneOf};
use super::figure::{Drawing, shows_method, shows_scene, title_of};
use super::font::Fonts;
use super::legend::Mark;
use super::look::{color, marker, unit};
use super::plot::{Plot, axis_name};
use super::sheet::{Sheet, Stroke};
use super::table_kinds::MOST_SCENES;
use super::{chart, lacking, number};
use crate::experiment::{Column, FigureSpec, is_declared};

/// Size of the inner part of a panel, about.
const PANEL: (f32, f32) = (600.0, 300.0);

/// A method's curve in one panel.
struct Curve {
    label: String,
    /// Position of the method in the config: decides colour and marker.
    index: usize,
    /// By rising x.
    points: Vec<Point>,
}

struct Point {
    x: f64,
    y: f64,
    /// Half the width of the interval of y.
    half: f64,
}

/// One metric in one scene.
struct Panel {
    title: String,
    x: (String, Axis),
    y: (String, Axis),
    curves: Vec<Curve>,
}

/// Draws all panels; says why when there is nothing to draw.
pub fn draw(fonts: &Fonts, data: &Data, spec: &FigureSpec) -> Result<Drawing, String> {
    let (columns, panels) = panels(data, spec);
    let is_empty = |p: &Panel| p.curves.iter().all(|c| c.points.is_empty());
    if panels.iter().all(is_empty) {
        return Err("no finished job has the quantities of its axes".into());
    }
    let columns = spec.columns.map_or(columns, NonZeroUsize::get);
    let left = chart::left_room(fonts, panels.iter().map(|panel| &panel.y.1));
    let around = panels.iter().map(|panel| Around {
        title: &panel.title,
        x: (&panel.x.0, &panel.x.1),
        y: (&panel.y.0, &panel.y.1),
        names: &[],
        left,
    });
    let curves = panels[0].curves.iter();
    let plot = Plot {
        title: title_of(spec),
        legend: curves
            .map(|c| (Mark::Method(c.index), c.label.clone()))
            .collect(),
        columns: columns.min(panels.len()),
        panel: PANEL,
    };
    let around: Vec<Around> = around.collect();
    let rows: Vec<&[Around]> = around.chunks(plot.columns).collect();
    Ok(Drawing {
        sheet: plot.draw(fonts, &rows, |sheet, index, chart| {
            paint(sheet, fonts, &panels[index], chart);
        }),
        caption: format!(
            "{}{}",
            match data.config.repeats {
                1 => "One run each; no intervals.",
                _ => "Means over seeds; bars are 95 % confidence intervals.",
            },
            lacking::seeds(data, spec, None)
        ),
    })
}

/// All panels, scene by scene, and the number of metrics; of many scenes, when the config names none, the
/// mean alone.
fn panels(data: &Data, spec: &FigureSpec) -> (usize, Vec<Panel>) {
    let x = spec.x.as_deref().unwrap_or("caches");
    let default = ["rmse".to_owned()];
    let metrics = if spec.y.is_empty() {
        &default[..]
    } else {
        &spec.y
    };
    let scenes = data.scenes.iter().filter(|scene| shows_scene(spec, scene));
    let mut scenes: Vec<SceneOf> = scenes.cloned().collect();
    if spec.scenes.is_empty() && scenes.len() > MOST_SCENES {
        scenes = vec![SceneOf::all()];
    }
    let panels = scenes
        .iter()
        .flat_map(|scene| metrics.iter().map(move |y| (scene, y)))
        .map(|(scene, y)| panel(data, spec, scene, [x, y]))
        .collect();
    (metrics.len(), panels)
}

fn panel(data: &Data, spec: &FigureSpec, scene: &SceneOf, [x, y]: [&str; 2]) -> Panel {
    let curves: Vec<Curve> = data
        .labels()
        .iter()
        .enumerate()
        .filter(|(_, label)| shows_method(spec, label))
        .map(|(index, label)| Curve {
            label: label.clone(),
            index,
            points: points(data, scene, label, [x, y]),
        })
        .collect();
    let all = || curves.iter().flat_map(|c| &c.points);
    let heading = |key: &str| axis_name(Column::of(key));
    Panel {
        title: scene.title(),
        x: (heading(x), Axis::over(all().map(|p| p.x), false)),
        y: (heading(y), Axis::over(all().flat_map(ends), true)),
        curves,
    }
}

/// A value and the ends of its interval, the lower one only where it is positive.
fn ends(point: &Point) -> impl Iterator<Item = f64> + use<> {
    let Point { y, half, .. } = *point;
    [y, y + half]
        .into_iter()
        .chain((y > half).then_some(y - half))
}

fn points(data: &Data, scene: &SceneOf, label: &str, [x, y]: [&str; 2]) -> Vec<Point> {
    let mut points: Vec<Point> = data
        .points()
        .iter()
        .filter_map(|point| {
            let case = Asked {
                scene,
                label,
                point,
            };
            let y = data.estimate(case, y)?;
            // A method that lacks a swept key has one row for all of its values, whose own is the first of them.
            let swept = point.number_of(x).filter(|_| !is_declared(x));
            Some(Point {
                x: swept.or_else(|| Some(data.estimate(case, x)?.mean))?,
                y: y.mean,
                half: y.half_width.unwrap_or(0.0),
            })
        })
        .collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    points
}

/// The lines of a panel with their intervals and markers.
fn paint(sheet: &mut Sheet, fonts: &Fonts, panel: &Panel, chart: &Chart) {
    let floor = panel.y.1.low();
    let unit = unit(fonts);
    for curve in &panel.curves {
        let color = color(curve.index);
        let stroke = Stroke::solid(color, 2.0 * unit);
        let places: Vec<Vec2> = curve.points.iter().map(|p| chart.at(p.x, p.y)).collect();
        sheet.line(&places, stroke);
        for p in curve.points.iter().filter(|p| p.half > 0.0) {
            let ends = [(p.y - p.half).max(floor), p.y + p.half].map(|end| chart.at(p.x, end));
            sheet.line(&ends, stroke);
            for Vec2 { x, y } in ends {
                let cap = [x - 5.0 * unit, x + 5.0 * unit].map(|x| Vec2::new(x, y));
                sheet.line(&cap, stroke);
            }
        }
        for place in &places {
            sheet.polygon(&marker(curve.index, *place, unit), color, 1.0);
        }
        for (p, place) in curve.points.iter().zip(places) {
            let text = format!(
                "{}, {}: {} {}, {}",
                curve.label,
                panel.title,
                panel.x.0,
                number::lone(p.x),
                value(&panel.y.0, p.y, p.half)
            );
            sheet.spot(place, &text);
        }
    }
}

/// `RMSE 0.084 ± 0.002`, without an interval where there is none.
pub fn value(name: &str, value: f64, half: f64) -> String {
    let interval = match half > 0.0 {
        true => format!(" ± {}", number::lone(half)),
        false => String::new(),
    };
    format!("{name} {}{interval}", number::lone(value))
}
