//! Error against a swept or measured quantity: one panel per metric and scene.

use std::io;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::Axis;
use super::column::Column;
use super::data::{Case, Data, SceneOf};
use super::escape;
use super::figure::{shows_method, shows_scene};
use super::font;
use super::number::Style;
use crate::experiment::FigureSpec;
use crate::image::{Image, write_png_coded};

const PANEL: (u32, u32) = (600, 450);
const LEGEND: u32 = 50;
const TITLE: u32 = 44;
const FACE: &str = "sans-serif";

/// Colours that stay apart for the colour-blind (Okabe & Ito, yellow left out), by the position of a
/// method in the config.
const COLORS: [RGBColor; 7] = [
    RGBColor(120, 120, 120),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(86, 180, 233),
    RGBColor(204, 121, 167),
    RGBColor(213, 94, 0),
    RGBColor(0, 90, 170),
];

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

type Files = (Vec<String>, String);

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
    let mut svg = String::new();
    let mut bytes = vec![0; (size.0 * size.1 * 3) as usize];
    let drawn = register_font()
        .and_then(|()| sheet.draw(SVGBackend::with_string(&mut svg, size)))
        .and_then(|()| sheet.draw(BitMapBackend::with_buffer(&mut bytes, size)));
    if let Err(reason) = drawn {
        return Ok(Err(reason));
    }
    let name = escape::file_name(&spec.name);
    let files = vec![format!("figures/{name}.svg"), format!("figures/{name}.png")];
    data.store.write(&files[0], &svg)?;
    let image = Image {
        width: size.0 as usize,
        height: size.1 as usize,
        pixels: bytes
            .chunks_exact(3)
            .map(|p| [p[0], p[1], p[2]].map(|v| f32::from(v) / 255.0))
            .collect(),
    };
    write_png_coded(&data.store.folder.join(&files[1]), &image).map_err(io::Error::other)?;
    Ok(Ok((
        files,
        "Means over seeds; bars are 95 % confidence intervals.".into(),
    )))
}

fn register_font() -> Result<(), String> {
    plotters::style::register_font(FACE, FontStyle::Normal, font::SANS)
        .map_err(|_| "the embedded typeface cannot be read".to_owned())
}

/// All panels, scene by scene, and the number of metrics.
fn panels(data: &Data, spec: &FigureSpec) -> (usize, Vec<Panel>) {
    let x = spec.x.as_deref().unwrap_or("caches");
    let default = ["rmse".to_owned()];
    let metrics = if spec.y.is_empty() {
        &default[..]
    } else {
        &spec.y
    };
    let panels = data
        .scenes
        .iter()
        .filter(|scene| shows_scene(spec, scene))
        .flat_map(|scene| metrics.iter().map(move |y| (scene, y)))
        .map(|(scene, y)| panel(data, spec, (scene, x, y)))
        .collect();
    (metrics.len(), panels)
}

fn panel(data: &Data, spec: &FigureSpec, (scene, x, y): (&SceneOf, &str, &str)) -> Panel {
    let curves: Vec<Curve> = data
        .labels
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
    // The embedded face has no arrows.
    let heading = |key: &str| {
        let column = Column::of(key);
        let unit = Style::of(column.unit, [1.0].into_iter()).unit;
        let unit = if unit.is_empty() {
            String::new()
        } else {
            format!(", {unit}")
        };
        format!("{}{unit}", column.heading)
    };
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
        .points
        .iter()
        .filter_map(|point| {
            let case = Case {
                scene: &scene.name,
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

impl Sheet<'_> {
    fn draw<B: DrawingBackend>(&self, backend: B) -> Result<(), String> {
        let root = backend.into_drawing_area();
        self.draw_on(&root).map_err(|e| e.to_string())?;
        root.present().map_err(|e| e.to_string())
    }

    fn draw_on<B: DrawingBackend>(
        &self,
        root: &DrawingArea<B, Shift>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        root.fill(&WHITE)?;
        let centre = Pos::new(HPos::Center, VPos::Center);
        let (width, height) = root.dim_in_pixel();
        let style = (FACE, 25).into_font().color(&BLACK).pos(centre);
        root.draw(&Text::new(
            self.title.to_owned(),
            (width as i32 / 2, TITLE as i32 / 2),
            style,
        ))?;
        let (_, below) = root.split_vertically(TITLE);
        let (sheets, legend) = below.split_vertically(height - TITLE - LEGEND);
        for (area, panel) in sheets.split_evenly(self.grid).iter().zip(self.panels) {
            draw_panel(area, panel)?;
        }
        self.panels
            .first()
            .map_or(Ok(()), |panel| draw_legend(&legend, &panel.curves))
    }
}

fn draw_panel<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    panel: &Panel,
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
        let color = COLORS[curve.index % COLORS.len()];
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
    }
    Ok(())
}

fn draw_legend<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    curves: &[Curve],
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let (width, height) = area.dim_in_pixel();
    let middle = Pos::new(HPos::Left, VPos::Center);
    let wide = |c: &Curve| 58 + 11 * c.label.chars().count() as i32;
    let total: i32 = curves.iter().map(wide).sum();
    let squeeze = (f64::from(width) / f64::from(total.max(1))).min(1.0);
    let mut x = ((width as i32 - total) / 2).max(4);
    let y = height as i32 / 2;
    for curve in curves {
        let color = COLORS[curve.index % COLORS.len()];
        area.draw(&PathElement::new(
            vec![(x, y), (x + 34, y)],
            color.stroke_width(2),
        ))?;
        let shape = marker(curve.index)
            .into_iter()
            .map(|(dx, dy)| (x + 17 + dx, y + dy));
        area.draw(&Polygon::new(shape.collect::<Vec<_>>(), color.filled()))?;
        let style = (FACE, 20.0 * squeeze).into_font().color(&BLACK).pos(middle);
        area.draw(&Text::new(curve.label.clone(), (x + 40, y), style))?;
        x += (f64::from(wide(curve)) * squeeze) as i32;
    }
    Ok(())
}

/// The outline of a method's marker around the origin, pixels.
fn marker(index: usize) -> Vec<(i32, i32)> {
    match index % 6 {
        0 => (0..16)
            .map(|i| {
                let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 16.0).sin_cos();
                ((6.0 * cos).round() as i32, (6.0 * sin).round() as i32)
            })
            .collect(),
        1 => vec![(-5, -5), (5, -5), (5, 5), (-5, 5)],
        2 => vec![(0, -7), (7, 5), (-7, 5)],
        3 => vec![(0, -8), (8, 0), (0, 8), (-8, 0)],
        4 => vec![(0, 7), (7, -5), (-7, -5)],
        _ => {
            let plus = [(-2, -7), (2, -7), (2, -2), (7, -2), (7, 2), (2, 2)];
            plus.into_iter()
                .chain(plus.map(|(x, y)| (-x, -y)))
                .collect()
        }
    }
}
