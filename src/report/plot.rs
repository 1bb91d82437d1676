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

/// Colours that stay apart for the colour-blind (Petroff 2021, "Accessible color sequences for data visualization"),
/// by the position of a method in the config.
const COLORS: [RGBColor; 10] = [
    RGBColor(63, 144, 218),
    RGBColor(255, 169, 14),
    RGBColor(189, 31, 1),
    RGBColor(148, 164, 162),
    RGBColor(131, 45, 182),
    RGBColor(169, 107, 89),
    RGBColor(231, 99, 0),
    RGBColor(185, 172, 112),
    RGBColor(113, 117, 129),
    RGBColor(146, 218, 221),
];

/// The colour of the method at a position in the config.
pub fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

/// A point of a plot and what it stands for, as the page tells under the pointer.
pub struct Spot {
    /// Pixels.
    pub at: (i32, i32),
    pub text: String,
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
    /// Draws it and adds its points.
    fn draw_on<B: DrawingBackend>(
        &self,
        root: &DrawingArea<B, Shift>,
        spots: &mut Vec<Spot>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>>;
}

/// Writes `<name>.svg` and `<name>.png` and returns their paths, or why the plot cannot be drawn.
pub fn write(
    data: &Data,
    (name, width_mm): (&str, Option<f64>),
    (size, plot): ((u32, u32), &impl Plot),
) -> io::Result<Result<Vec<String>, String>> {
    let mut svg = String::new();
    let (mut spots, mut same) = (Vec::new(), Vec::new());
    let mut bytes = vec![0; (size.0 * size.1 * 3) as usize];
    let drawn = register_font()
        .and_then(|()| draw((plot, &mut spots), SVGBackend::with_string(&mut svg, size)))
        .and_then(|()| {
            draw(
                (plot, &mut same),
                BitMapBackend::with_buffer(&mut bytes, size),
            )
        });
    if let Err(reason) = drawn {
        return Ok(Err(reason));
    }
    let name = escape::file_name(name);
    let files = vec![format!("figures/{name}.svg"), format!("figures/{name}.png")];
    let svg = on_paper(told(&svg, &spots), (size, width_mm));
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

/// A drawing that can be scaled, with its points told under the pointer.
fn told(svg: &str, spots: &[Spot]) -> String {
    let spot = |spot: &Spot| {
        let ((x, y), text) = (spot.at, escape::xml(&spot.text));
        format!(
            "<circle class=\"spot\" cx=\"{x}\" cy=\"{y}\" r=\"9\" fill=\"#fff\" fill-opacity=\"0\"><title>{text}</title></circle>\n"
        )
    };
    let spots: String = spots.iter().map(spot).collect();
    let body = svg.trim_end().trim_end_matches("</svg>");
    format!("{body}{spots}</svg>\n")
}

/// A drawing with its width on paper, if the config says it.
fn on_paper(svg: String, ((width, height), width_mm): ((u32, u32), Option<f64>)) -> String {
    let Some(width_mm) = width_mm else { return svg };
    let height_mm = width_mm * f64::from(height) / f64::from(width.max(1));
    let pixels = format!("width=\"{width}\" height=\"{height}\"");
    let paper = format!("width=\"{width_mm:.2}mm\" height=\"{height_mm:.2}mm\"");
    svg.replacen(&pixels, &paper, 1)
}

fn draw<B: DrawingBackend>(
    (plot, spots): (&impl Plot, &mut Vec<Spot>),
    backend: B,
) -> Result<(), String> {
    let root = backend.into_drawing_area();
    plot.draw_on(&root, spots).map_err(|e| e.to_string())?;
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

/// The outline of a method's marker around the origin, pixels. As many outlines as colours and one more: both repeat
/// together only after all their pairs.
pub fn marker(index: usize) -> Vec<(i32, i32)> {
    match index % (COLORS.len() + 1) {
        0 => wheel(16, [6.0; 2]),
        1 => vec![(-5, -5), (5, -5), (5, 5), (-5, 5)],
        2 => vec![(0, -7), (7, 5), (-7, 5)],
        3 => vec![(0, -8), (8, 0), (0, 8), (-8, 0)],
        4 => vec![(0, 7), (7, -5), (-7, -5)],
        5 => {
            let plus = [(-2, -7), (2, -7), (2, -2), (7, -2), (7, 2), (2, 2)];
            let rest = plus.map(|(x, y)| (-x, -y));
            plus.into_iter().chain(rest).collect()
        }
        6 => wheel(10, [9.0, 3.6]),
        7 => {
            let cross = [(-6, -4), (-4, -6), (0, -2), (4, -6), (6, -4), (2, 0)];
            let rest = cross.map(|(x, y)| (-x, -y));
            cross.into_iter().chain(rest).collect()
        }
        8 => vec![(-6, -7), (6, -7), (-6, 7), (6, 7)],
        9 => vec![(-7, 0), (5, -7), (5, 7)],
        _ => wheel(8, [9.0, 3.0]),
    }
}

/// Corners around a circle, the first on top, at two radii in turn.
fn wheel(corners: u32, radii: [f64; 2]) -> Vec<(i32, i32)> {
    let corner = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / f64::from(corners);
        let radius = radii[(i % 2) as usize];
        let (sin, cos) = angle.sin_cos();
        (
            (radius * sin).round() as i32,
            -(radius * cos).round() as i32,
        )
    };
    (0..corners).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::srgb_decode;

    /// Colours as they are seen by most people, without red, green and blue cones (Machado et al. 2009), linear.
    const SEEN: [[[f32; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [
            [0.152, 1.053, -0.205],
            [0.115, 0.786, 0.099],
            [-0.004, -0.048, 1.052],
        ],
        [
            [0.367, 0.861, -0.228],
            [0.280, 0.673, 0.047],
            [-0.012, 0.043, 0.969],
        ],
        [
            [1.256, -0.077, -0.179],
            [-0.078, 0.931, 0.148],
            [0.005, 0.691, 0.304],
        ],
    ];

    /// Oklab, in which distances are about as large as they look.
    fn oklab(rgb: [f32; 3]) -> [f32; 3] {
        let dot = |w: [f32; 3], v: [f32; 3]| w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
        let cones = [
            [0.412_221, 0.536_333, 0.051_446],
            [0.211_903, 0.680_7, 0.107_397],
            [0.088_302, 0.281_719, 0.629_979],
        ];
        let lms = cones.map(|w| dot(w, rgb).cbrt());
        [
            [0.210_454, 0.793_618, -0.004_072],
            [1.977_998, -2.428_592, 0.450_594],
            [0.025_904, 0.782_772, -0.808_676],
        ]
        .map(|w| dot(w, lms))
    }

    #[test]
    fn ten_methods_are_told_apart_whatever_cones_one_has() {
        for (kind, matrix) in SEEN.iter().enumerate() {
            let seen = COLORS.map(|c| {
                let rgb = [c.0, c.1, c.2].map(|v| srgb_decode(f32::from(v) / 255.0));
                let mix =
                    |w: &[f32; 3]| (w[0] * rgb[0] + w[1] * rgb[1] + w[2] * rgb[2]).clamp(0.0, 1.0);
                oklab([mix(&matrix[0]), mix(&matrix[1]), mix(&matrix[2])])
            });
            for (i, a) in seen.iter().enumerate() {
                for (j, b) in seen.iter().enumerate().skip(i + 1) {
                    let apart = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
                    assert!(apart > 0.055, "{kind}: {i} and {j}, {apart}");
                }
            }
        }
    }

    #[test]
    fn no_look_comes_twice_among_a_hundred_methods() {
        let looks = (0..100).map(|i| (color(i).0, color(i).1, color(i).2, marker(i)));
        let looks: std::collections::HashSet<_> = looks.collect();
        assert_eq!(looks.len(), 100);
    }
}
