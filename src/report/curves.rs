//! Error against a swept or measured quantity: one panel per metric and scene.

use std::io;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axis::Axis;
use super::data::{Asked, Data, SceneOf};
use super::figure::{shows_method, shows_scene};
use super::number;
use super::plot::{self, FACE, LEGEND, Plot, Spot, TITLE, color, marker};
use super::table_kinds::MOST_SCENES;
use crate::experiment::Column;
use crate::experiment::FigureSpec;

const PANEL: (u32, u32) = (600, 450);

/// A method's curve in one panel.
struct Curve {
    label: String,
    /// Position of the method in the config: decides colour and marker.
    index: usize,
    /// x, y and the half width of the interval of y, by rising x.
    points: Vec<(f64, f64, f64)>,
}

/// One metric in one scene.
struct Panel {
    title: String,
    x: (String, Axis),
    y: (String, Axis),
    curves: Vec<Curve>,
}

/// Paths of a plot and its caption.
pub type Files = (Vec<String>, String);

/// Writes `<name>.svg` and `<name>.png`; says why when there is nothing to draw.
pub fn draw(data: &Data, spec: &FigureSpec) -> io::Result<Result<Files, String>> {
    let (columns, panels) = panels(data, spec);
    if panels
        .iter()
        .all(|p| p.curves.iter().all(|c| c.points.is_empty()))
    {
        return Ok(Err("no finished job has the quantities of its axes".into()));
    }
    let rows = panels.len().div_ceil(columns.max(1));
    let size = (
        PANEL.0 * columns as u32,
        TITLE + PANEL.1 * rows as u32 + LEGEND,
    );
    let sheet = Sheet {
        title: if spec.title.is_empty() {
            &spec.name
        } else {
            &spec.title
        },
        panels: &panels,
        grid: (rows, columns),
    };
    let caption = "Means over seeds; bars are 95 % confidence intervals.";
    let files = plot::write(data, (&spec.name, spec.width_mm), (size, &sheet))?;
    Ok(files.map(|files| (files, caption.into())))
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
        .map(|(scene, y)| panel(data, spec, (scene, x, y)))
        .collect();
    (metrics.len(), panels)
}

fn panel(data: &Data, spec: &FigureSpec, (scene, x, y): (&SceneOf, &str, &str)) -> Panel {
    let curves: Vec<Curve> = data
        .labels()
        .iter()
        .enumerate()
        .filter(|(_, label)| shows_method(spec, label))
        .map(|(index, label)| Curve {
            label: label.clone(),
            index,
            points: points(data, (scene, label), (x, y)),
        })
        .collect();
    let all = || curves.iter().flat_map(|c| &c.points);
    let heading = |key: &str| plot::axis_name(Column::of(key));
    Panel {
        title: scene.title(),
        x: (heading(x), Axis::over(all().map(|p| p.0), false)),
        y: (heading(y), Axis::over(all().flat_map(ends), true)),
        curves,
    }
}

/// A value and the ends of its interval, the lower one only where it is positive.
fn ends(point: &(f64, f64, f64)) -> impl Iterator<Item = f64> {
    let (_, y, half) = *point;
    [y, y + half]
        .into_iter()
        .chain((y > half).then_some(y - half))
}

fn points(
    data: &Data,
    (scene, label): (&SceneOf, &str),
    (x, y): (&str, &str),
) -> Vec<(f64, f64, f64)> {
    let mut points: Vec<(f64, f64, f64)> = data
        .points()
        .iter()
        .filter_map(|point| {
            let case = Asked {
                scene,
                label,
                point,
            };
            let y = data.estimate(case, y)?;
            Some((
                data.estimate(case, x)?.mean,
                y.mean,
                y.half_width.unwrap_or(0.0),
            ))
        })
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// Everything that is drawn, whatever the backend.
struct Sheet<'a> {
    title: &'a str,
    panels: &'a [Panel],
    grid: (usize, usize),
}

impl Plot for Sheet<'_> {
    fn draw_on<B: DrawingBackend>(
        &self,
        root: &DrawingArea<B, Shift>,
        spots: &mut Vec<Spot>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let (sheets, legend) = plot::titled(root, self.title)?;
        for (area, panel) in sheets.split_evenly(self.grid).iter().zip(self.panels) {
            draw_panel(area, panel, spots)?;
        }
        let curves = self.panels.first().map_or(&[][..], |p| &p.curves);
        let entries = curves.iter().map(|c| (c.index, c.label.as_str()));
        plot::legend(&legend, &entries.collect::<Vec<_>>())
    }
}

fn draw_panel<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    panel: &Panel,
    spots: &mut Vec<Spot>,
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, (FACE, 22))
        .margin_left(12)
        .margin_right(28)
        .margin_top(6)
        .x_label_area_size(56)
        .y_label_area_size(82)
        .build_cartesian_2d(panel.x.1.clone(), panel.y.1.clone())?;
    chart
        .configure_mesh()
        .x_desc(panel.x.0.clone())
        .y_desc(panel.y.0.clone())
        .label_style((FACE, 18))
        .axis_desc_style((FACE, 20))
        .bold_line_style(BLACK.mix(0.12))
        .light_line_style(TRANSPARENT)
        .draw()?;
    let floor = panel.y.1.low();
    for curve in &panel.curves {
        let color = color(curve.index);
        let line = color.stroke_width(2);
        chart.draw_series(LineSeries::new(
            curve.points.iter().map(|p| (p.0, p.1)),
            line,
        ))?;
        for (x, y, half) in curve.points.iter().filter(|p| p.2 > 0.0) {
            let ends = [(y - half).max(floor), y + half];
            chart.draw_series([PathElement::new(ends.map(|end| (*x, end)).to_vec(), line)])?;
            chart.draw_series(ends.map(|end| {
                EmptyElement::at((*x, end)) + PathElement::new(vec![(-5, 0), (5, 0)], line)
            }))?;
        }
        chart.draw_series(curve.points.iter().map(|p| {
            EmptyElement::at((p.0, p.1)) + Polygon::new(marker(curve.index), color.filled())
        }))?;
        spots.extend(curve.points.iter().map(|(x, y, half)| Spot {
            at: chart.plotting_area().map_coordinate(&(*x, *y)),
            text: format!(
                "{}, {}: {} {}, {}",
                curve.label,
                panel.title,
                panel.x.0,
                number::lone(*x),
                value(&panel.y.0, *y, *half)
            ),
        }));
    }
    Ok(())
}

/// `RMSE 0.084 ± 0.002`, without an interval where there is none.
pub fn value(name: &str, value: f64, half: f64) -> String {
    let interval = match half > 0.0 {
        true => format!(" ± {}", number::lone(half)),
        false => String::new(),
    };
    format!("{name} {}{interval}", number::lone(value))
}
