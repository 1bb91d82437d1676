//! A figure that is drawn once and comes out twice: as pixels, and as shapes with real text.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::canvas::{self, Rect};
use super::escape;
use super::font::{Align, Fonts, Ink};
use crate::image::{Image, png_bytes};

/// Pixels of a figure without a width in millimetres that go into an inch.
const PIXELS_PER_INCH: f64 = 300.0;
const MM_PER_INCH: f64 = 25.4;

/// The two drawings, from the same calls.
pub struct Sheet {
    pub image: Image,
    shapes: String,
    texts: Vec<Written>,
}

/// A line of text and the room it takes, pixels.
struct Written {
    text: String,
    left: f32,
    top: f32,
    right: f32,
    bottom: f32,
}

impl Sheet {
    /// A white sheet.
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            image: canvas::white(width, height),
            shapes: String::new(),
            texts: Vec::new(),
        }
    }

    pub fn width(&self) -> usize {
        self.image.width
    }

    pub fn height(&self) -> usize {
        self.image.height
    }

    /// Puts a picture with its top left pixel at `corner`.
    pub fn put(&mut self, picture: &Image, corner: (usize, usize)) {
        canvas::blit(&mut self.image, picture, corner);
        if let Ok(bytes) = png_bytes(picture) {
            self.shape(format_args!(
                "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" href=\"data:image/png;base64,{}\"/>",
                corner.0,
                corner.1,
                picture.width,
                picture.height,
                STANDARD.encode(bytes)
            ));
        }
    }

    /// Fills a rectangle.
    pub fn fill(&mut self, rect: Rect, color: [f32; 3]) {
        canvas::fill(&mut self.image, rect, color);
        self.shape(format_args!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>",
            rect.x,
            rect.y,
            rect.width,
            rect.height,
            coded(color)
        ));
    }

    /// Draws the border of a rectangle, `thickness` pixels inwards.
    pub fn frame(&mut self, rect: Rect, thickness: usize, color: [f32; 3]) {
        canvas::frame(&mut self.image, rect, thickness, color);
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

    /// Draws a disc; `center` and `radius` in pixels.
    pub fn disc(&mut self, center: (f32, f32), radius: f32, color: [f32; 3]) {
        canvas::disc(&mut self.image, center, radius, color);
        self.shape(format_args!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" fill=\"{}\"/>",
            center.0,
            center.1,
            coded(color)
        ));
    }

    /// Writes a line of text with its baseline at `position`. Its width is that of the embedded typeface, whatever
    /// typeface it is shown with.
    pub fn text(
        &mut self,
        fonts: &Fonts,
        (text, ink): (&str, Ink),
        position: (f32, f32),
        align: Align,
    ) {
        if text.is_empty() {
            return;
        }
        fonts.draw(&mut self.image, (text, ink), position, align);
        let width = fonts.width(text, ink.size_px);
        let (anchor, left) = match align {
            Align::Left => ("start", position.0),
            Align::Center => ("middle", position.0 - width / 2.0),
            Align::Right => ("end", position.0 - width),
        };
        let weight = if ink.bold {
            " font-weight=\"bold\""
        } else {
            ""
        };
        self.shape(format_args!(
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"{:.1}\" text-anchor=\"{anchor}\" textLength=\"{width:.1}\" lengthAdjust=\"spacingAndGlyphs\" fill=\"{}\"{weight}>{}</text>",
            position.0,
            position.1,
            ink.size_px,
            coded(ink.color),
            escape::xml(text)
        ));
        self.texts.push(Written {
            text: text.to_owned(),
            left,
            top: position.1 - 0.75 * ink.size_px,
            right: left + width,
            bottom: position.1 + 0.2 * ink.size_px,
        });
    }

    /// The drawing as SVG, this many millimetres wide.
    pub fn svg(&self, width_mm: Option<f64>) -> String {
        let (width, height) = (self.width(), self.height());
        let width_mm = width_mm.unwrap_or(width as f64 * MM_PER_INCH / PIXELS_PER_INCH);
        let height_mm = width_mm * height as f64 / width.max(1) as f64;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width_mm:.2}mm\" height=\"{height_mm:.2}mm\" viewBox=\"0 0 {width} {height}\" font-family=\"Ubuntu, 'Helvetica Neue', Arial, sans-serif\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n{}</svg>\n",
            self.shapes
        )
    }

    /// What is wrong with the texts: those that leave the sheet, and those that lie on one another.
    pub fn clashes(&self) -> Vec<String> {
        let (width, height) = (self.width() as f32, self.height() as f32);
        let mut clashes = Vec::new();
        for (index, a) in self.texts.iter().enumerate() {
            if a.left < -0.5 || a.top < -0.5 || a.right > width + 0.5 || a.bottom > height + 0.5 {
                clashes.push(format!("`{}` leaves the sheet", a.text));
            }
            for b in &self.texts[index + 1..] {
                let across = a.right.min(b.right) - a.left.max(b.left);
                let down = a.bottom.min(b.bottom) - a.top.max(b.top);
                if across > 0.5 && down > 0.5 {
                    clashes.push(format!("`{}` lies on `{}`", a.text, b.text));
                }
            }
        }
        clashes
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_drawings_show_the_same() {
        let fonts = Fonts::load().expect("embedded");
        let mut sheet = Sheet::new(200, 60);
        let rect = Rect {
            x: 10,
            y: 10,
            width: 20,
            height: 20,
        };
        sheet.fill(rect, [1.0, 0.0, 0.0]);
        sheet.frame(rect, 4, [0.0; 3]);
        sheet.put(&Image::new(8, 4), (100, 20));
        let ink = Ink::black(20.0).bold();
        sheet.text(&fonts, ("a < b", ink), (60.0, 50.0), Align::Left);
        assert_eq!(sheet.image.at(20, 20), [1.0, 0.0, 0.0]);
        let svg = sheet.svg(Some(85.0));
        for text in [
            "width=\"85.00mm\" height=\"25.50mm\"",
            "a &lt; b</text>",
            "#ff0000",
            "data:image/png;base64,",
        ] {
            assert!(svg.contains(text), "{text} in {svg}");
        }
        assert!(roxmltree::Document::parse(&svg).is_ok());
        assert!(sheet.clashes().is_empty());
        sheet.text(&fonts, ("above", ink), (70.0, 52.0), Align::Left);
        sheet.text(&fonts, ("out", ink), (190.0, 20.0), Align::Left);
        assert_eq!(sheet.clashes().len(), 2, "{:?}", sheet.clashes());
    }
}
