//! A drawing: pictures, shapes and real text, as SVG.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::Vec2;

use super::escape;
use super::font::{Align, Fonts, Ink};
use crate::image::{Image, Rect, png_bytes};

/// What a figure is drawn on, in units that are pixels of its pictures.
pub struct Sheet {
    pub width: usize,
    pub height: usize,
    shapes: String,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    pub color: [f32; 3],
    pub width: f32,
    /// Lengths of dashes and of the spaces between them.
    pub dash: Option<(f32, f32)>,
}

impl Stroke {
    pub fn solid(color: [f32; 3], width: f32) -> Self {
        Self {
            color,
            width,
            dash: None,
        }
    }
}

impl Sheet {
    /// A white sheet.
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            shapes: String::new(),
        }
    }

    /// Puts a picture with its top left pixel at a corner.
    pub fn put(&mut self, picture: &Image, x: usize, y: usize) {
        let (width, height) = (picture.width, picture.height);
        if let Ok(bytes) = png_bytes(picture) {
            let code = STANDARD.encode(bytes);
            self.shape(format_args!(
                "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{code}\"/>"
            ));
        }
    }

    /// Fills a rectangle.
    pub fn fill(&mut self, rect: Rect, color: [f32; 3]) {
        self.shape(format_args!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>",
            rect.x,
            rect.y,
            rect.width,
            rect.height,
            coded(color)
        ));
    }

    /// Draws the border of a rectangle, `thickness` inwards.
    pub fn frame(&mut self, rect: Rect, thickness: usize, color: [f32; 3]) {
        let thickness = thickness.min(rect.width).min(rect.height);
        let half = thickness as f64 / 2.0;
        self.shape(format_args!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{thickness}\"/>",
            rect.x as f64 + half,
            rect.y as f64 + half,
            rect.width - thickness,
            rect.height - thickness,
            coded(color)
        ));
    }

    /// Draws a disc.
    pub fn disc(&mut self, center: Vec2, radius: f32, color: [f32; 3]) {
        self.shape(format_args!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"/>",
            short(center.x),
            short(center.y),
            short(radius),
            coded(color)
        ));
    }

    /// Draws a line through points.
    pub fn line(&mut self, points: &[Vec2], stroke: Stroke) {
        let dash = stroke.dash.map_or(String::new(), |(dash, space)| {
            format!(" stroke-dasharray=\"{} {}\"", short(dash), short(space))
        });
        self.shape(format_args!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{dash}/>",
            listed(points),
            coded(stroke.color),
            short(stroke.width)
        ));
    }

    /// Fills an outline.
    pub fn polygon(&mut self, points: &[Vec2], color: [f32; 3], opacity: f32) {
        let opacity = match opacity < 1.0 {
            true => format!(" fill-opacity=\"{opacity}\""),
            false => String::new(),
        };
        self.shape(format_args!(
            "<polygon points=\"{}\" fill=\"{}\"{opacity}/>",
            listed(points),
            coded(color)
        ));
    }

    /// A place that tells what it stands for under the pointer.
    pub fn spot(&mut self, at: Vec2, text: &str) {
        self.shape(format_args!(
            "<circle class=\"spot\" cx=\"{}\" cy=\"{}\" r=\"9\" fill=\"#fff\" fill-opacity=\"0\"><title>{}</title></circle>",
            short(at.x),
            short(at.y),
            escape::xml(text)
        ));
    }

    /// Writes a line of text with its baseline at a place. Its width is that of the embedded typeface, whatever
    /// typeface it is shown with.
    pub fn text(&mut self, fonts: &Fonts, text: &str, ink: Ink, at: Vec2, align: Align) {
        self.write(fonts, text, ink, at, align, "");
    }

    /// Writes a line of text that runs upwards from a place.
    pub fn upright(&mut self, fonts: &Fonts, text: &str, ink: Ink, at: Vec2, align: Align) {
        let turned = format!(" transform=\"rotate(-90 {} {})\"", short(at.x), short(at.y));
        self.write(fonts, text, ink, at, align, &turned);
    }

    fn write(&mut self, fonts: &Fonts, text: &str, ink: Ink, at: Vec2, align: Align, turned: &str) {
        if text.is_empty() {
            return;
        }
        let anchor = match align {
            Align::Left => "start",
            Align::Center => "middle",
            Align::Right => "end",
        };
        let color = coded(ink.color);
        // There is one weight of the typeface: a rim makes it bold.
        let rim = match ink.bold {
            true => format!(
                " stroke=\"{color}\" stroke-width=\"{}\"",
                short(0.04 * ink.size)
            ),
            false => String::new(),
        };
        self.shape(format_args!(
            "<text x=\"{}\" y=\"{}\" font-size=\"{}\" text-anchor=\"{anchor}\" textLength=\"{}\" lengthAdjust=\"spacingAndGlyphs\" fill=\"{color}\"{rim}{turned}>{}</text>",
            short(at.x),
            short(at.y),
            short(ink.size),
            short(fonts.width(text, ink.size)),
            escape::xml(text)
        ));
    }

    /// The drawing, this many millimetres wide.
    pub fn svg(&self, width_mm: f64) -> String {
        let (width, height) = (self.width, self.height);
        let height_mm = width_mm * height as f64 / width.max(1) as f64;
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width_mm:.4}mm\" height=\"{height_mm:.4}mm\" viewBox=\"0 0 {width} {height}\" font-family=\"Ubuntu, 'Helvetica Neue', Arial, sans-serif\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n{}</svg>\n",
            self.shapes
        );
        escape::xml_text(&svg).into_owned()
    }

    fn shape(&mut self, shape: std::fmt::Arguments) {
        // Writing into a string cannot fail.
        let _ = writeln!(self.shapes, "{shape}");
    }
}

/// A colour as `#rrggbb`.
fn coded(color: [f32; 3]) -> String {
    let [r, g, b] = color.map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A length to a hundredth of a unit.
fn short(value: f32) -> f64 {
    (f64::from(value) * 100.0).round() / 100.0
}

fn listed(points: &[Vec2]) -> String {
    let point = |at: &Vec2| format!("{},{}", short(at.x), short(at.y));
    points.iter().map(point).collect::<Vec<_>>().join(" ")
}

/// A red square on a small sheet, for tests of what is drawn.
#[cfg(test)]
pub(super) fn with_square() -> (Sheet, Rect, Fonts) {
    let fonts = Fonts::load().expect("embedded").at(20.0);
    let mut sheet = Sheet::new(200, 60);
    let square = Rect {
        x: 10,
        y: 10,
        width: 20,
        height: 20,
    };
    sheet.fill(square, [1.0, 0.0, 0.0]);
    (sheet, square, fonts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drawing_is_xml_with_real_text() {
        let (mut sheet, square, fonts) = with_square();
        sheet.frame(square, 40, [0.0; 3]);
        sheet.put(&Image::new(8, 4), 100, 20);
        sheet.line(
            &[Vec2::new(1.0, 2.0), Vec2::new(3.333, 4.0)],
            Stroke::solid([0.0, 0.0, 1.0], 2.0),
        );
        let bold = fonts.ink(1.0).bold();
        let place = Vec2::new(60.0, 50.0);
        sheet.text(&fonts, "a < b\u{7}", bold, place, Align::Left);
        let svg = sheet.svg(85.0);
        for text in [
            "width=\"85.0000mm\" height=\"25.5000mm\"",
            "a &lt; b\u{fffd}</text>",
            "#ff0000",
            "data:image/png;base64,",
            "1,2 3.33,4",
        ] {
            assert!(svg.contains(text), "{text} in {svg}");
        }
        assert!(roxmltree::Document::parse(&svg).is_ok());
    }
}
