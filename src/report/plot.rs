//! What plots share: backends, title, legend, and the look of methods.

use std::io;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::data::Data;
use super::{escape, font};
use crate::experiment::{Column, Unit};
use crate::image::{Image, write_png_coded};

/// Heights of the legend and of the title, pixels.
pub const LEGEND: u32 = 50;
pub const TITLE: u32 = 44;
pub const FACE: &str = "sans-serif";

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

/// The colour of the method at a position in the config.
pub fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

/// The name of an axis and its unit, the one that values of the column have: ticks are not scaled.
pub fn axis_name(column: Column) -> String {
    let unit = match column.unit {
        Unit::None | Unit::Count => return column.heading,
        Unit::Decibel => "dB",
        Unit::Seconds => "s",
        Unit::Bytes => "bytes",
    };
    format!("{}, {unit}", column.heading)
}

/// Something that is drawn alike on every backend.
pub trait Plot {
    fn draw_on<B: DrawingBackend>(
        &self,
        root: &DrawingArea<B, Shift>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>>;
}

/// Writes `<name>.svg` and `<name>.png` and returns their paths, or why the plot cannot be drawn.
pub fn write(
    data: &Data,
    name: &str,
    (size, plot): ((u32, u32), &impl Plot),
) -> io::Result<Result<Vec<String>, String>> {
    let mut svg = String::new();
    let mut bytes = vec![0; (size.0 * size.1 * 3) as usize];
    let drawn = register_font()
        .and_then(|()| draw(plot, SVGBackend::with_string(&mut svg, size)))
        .and_then(|()| draw(plot, BitMapBackend::with_buffer(&mut bytes, size)));
    if let Err(reason) = drawn {
        return Ok(Err(reason));
    }
    let name = escape::file_name(name);
    let files = vec![format!("figures/{name}.svg"), format!("figures/{name}.png")];
    data.store.write(&files[0], &escape::xml_text(&svg))?;
    let image = Image {
        width: size.0 as usize,
        height: size.1 as usize,
        pixels: bytes
            .chunks_exact(3)
            .map(|p| [p[0], p[1], p[2]].map(|v| f32::from(v) / 255.0))
            .collect(),
    };
    write_png_coded(&data.store.folder.join(&files[1]), &image).map_err(io::Error::other)?;
    Ok(Ok(files))
}

fn draw<B: DrawingBackend>(plot: &impl Plot, backend: B) -> Result<(), String> {
    let root = backend.into_drawing_area();
    plot.draw_on(&root).map_err(|e| e.to_string())?;
    root.present().map_err(|e| e.to_string())
}

fn register_font() -> Result<(), String> {
    plotters::style::register_font(FACE, FontStyle::Normal, font::SANS)
        .map_err(|_| "the embedded typeface cannot be read".to_owned())
}

/// A white sheet with a title; returns the areas for the panels and for the legend.
#[expect(clippy::type_complexity, reason = "the types of plotters")]
pub fn titled<B: DrawingBackend>(
    root: &DrawingArea<B, Shift>,
    title: &str,
) -> Result<(DrawingArea<B, Shift>, DrawingArea<B, Shift>), DrawingAreaErrorKind<B::ErrorType>> {
    root.fill(&WHITE)?;
    let centre = Pos::new(HPos::Center, VPos::Center);
    let (width, height) = root.dim_in_pixel();
    let style = (FACE, 25).into_font().color(&BLACK).pos(centre);
    let middle = (width as i32 / 2, TITLE as i32 / 2);
    root.draw(&Text::new(title.to_owned(), middle, style))?;
    let (_, below) = root.split_vertically(TITLE);
    Ok(below.split_vertically(height - TITLE - LEGEND))
}

/// Names methods, given by their position in the config and their label, in one line.
pub fn legend<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    methods: &[(usize, &str)],
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let (width, height) = area.dim_in_pixel();
    let middle = Pos::new(HPos::Left, VPos::Center);
    let wide = |(_, label): &(usize, &str)| 58 + 11 * label.chars().count() as i32;
    let total: i32 = methods.iter().map(wide).sum();
    let squeeze = (f64::from(width) / f64::from(total.max(1))).min(1.0);
    let mut x = ((width as i32 - total) / 2).max(4);
    let y = height as i32 / 2;
    for method in methods {
        let (index, label) = *method;
        let color = color(index);
        area.draw(&PathElement::new(
            vec![(x, y), (x + 34, y)],
            color.stroke_width(2),
        ))?;
        let shape = marker(index)
            .into_iter()
            .map(|(dx, dy)| (x + 17 + dx, y + dy));
        area.draw(&Polygon::new(shape.collect::<Vec<_>>(), color.filled()))?;
        let style = (FACE, 20.0 * squeeze).into_font().color(&BLACK).pos(middle);
        area.draw(&Text::new(label.to_owned(), (x + 40, y), style))?;
        x += (f64::from(wide(method)) * squeeze) as i32;
    }
    Ok(())
}

/// The outline of a method's marker around the origin, pixels.
pub fn marker(index: usize) -> Vec<(i32, i32)> {
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
