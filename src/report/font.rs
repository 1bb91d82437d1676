//! Text drawn with embedded typefaces: no font of the system is needed.

use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};

use super::canvas::blend;
use crate::image::Image;

/// The typefaces: the first that has a character draws it.
pub struct Fonts {
    faces: Vec<FontRef<'static>>,
}

/// Size, weight and colour of a text.
#[derive(Clone, Copy, Debug)]
pub struct Ink {
    pub size_px: f32,
    pub bold: bool,
    /// sRGB-coded.
    pub color: [f32; 3],
}

impl Ink {
    pub fn black(size_px: f32) -> Self {
        Self {
            size_px,
            bold: false,
            color: [0.07; 3],
        }
    }

    pub fn bold(self) -> Self {
        Self { bold: true, ..self }
    }
}

/// Where a text stands relative to its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    Left,
    Center,
    Right,
}

/// Bytes of the sans-serif face, for the plots.
pub const SANS: &[u8] = epaint_default_fonts::UBUNTU_LIGHT;

impl Fonts {
    /// Reads the embedded typefaces.
    pub fn load() -> Result<Self, String> {
        let faces = [SANS, epaint_default_fonts::HACK_REGULAR];
        let faces = faces
            .into_iter()
            .map(FontRef::try_from_slice)
            .collect::<Result<_, _>>()
            .map_err(|e| format!("the embedded typeface cannot be read: {e}"))?;
        Ok(Self { faces })
    }

    fn face(&self, c: char) -> &FontRef<'static> {
        let has = |face: &&FontRef| face.glyph_id(c).0 != 0;
        self.faces.iter().find(has).unwrap_or(&self.faces[0])
    }

    fn advance(&self, c: char, size_px: f32) -> f32 {
        let face = self.face(c);
        face.as_scaled(PxScale::from(size_px))
            .h_advance(face.glyph_id(c))
    }

    /// Width in pixels.
    pub fn width(&self, text: &str, size_px: f32) -> f32 {
        text.chars().map(|c| self.advance(c, size_px)).sum()
    }

    /// The text cut with an ellipsis, after its size was reduced by up to a third, to fit a width.
    pub fn fitted(&self, text: &str, ink: Ink, width: f32) -> (String, Ink) {
        let full = self.width(text, ink.size_px);
        let shrink = (width / full.max(1.0)).clamp(2.0 / 3.0, 1.0);
        let ink = Ink {
            size_px: ink.size_px * shrink,
            ..ink
        };
        let mut text = text.to_owned();
        if self.width(&text, ink.size_px) > width + 0.5 {
            while !text.is_empty()
                && self.width(&text, ink.size_px) + self.advance('…', ink.size_px) > width
            {
                text.pop();
            }
            text.push('…');
        }
        (text, ink)
    }

    /// Draws a line of text with its baseline at `position` (x, y) into an sRGB-coded image.
    pub fn draw(
        &self,
        canvas: &mut Image,
        (text, ink): (&str, Ink),
        position: (f32, f32),
        align: Align,
    ) {
        let width = self.width(text, ink.size_px);
        let mut x = match align {
            Align::Left => position.0,
            Align::Center => position.0 - width / 2.0,
            Align::Right => position.0 - width,
        };
        for c in text.chars() {
            let face = self.face(c);
            let strokes: &[f32] = if ink.bold { &[0.0, 0.35, 0.7] } else { &[0.0] };
            for offset in strokes {
                let at = point(x + offset * ink.size_px / 20.0, position.1);
                let glyph = face.glyph_id(c).with_scale_and_position(ink.size_px, at);
                if let Some(outline) = face.outline_glyph(glyph) {
                    let corner = outline.px_bounds().min;
                    outline.draw(|dx, dy, cover| {
                        let (px, py) = (
                            corner.x as i64 + i64::from(dx),
                            corner.y as i64 + i64::from(dy),
                        );
                        blend(canvas, (px, py), ink.color, cover);
                    });
                }
            }
            x += self.advance(c, ink.size_px);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_and_accents_have_glyphs_and_long_texts_are_cut() {
        let fonts = Fonts::load().expect("embedded");
        for c in "aé±×—↓↑·…".chars() {
            assert_ne!(fonts.face(c).glyph_id(c).0, 0, "{c}");
        }
        let long = "a label that is far too long for its column".repeat(3);
        let (cut, ink) = fonts.fitted(&long, Ink::black(24.0), 200.0);
        assert!(cut.ends_with('…') && fonts.width(&cut, ink.size_px) <= 200.0);
        assert_eq!(fonts.fitted("IM", Ink::black(24.0), 200.0).0, "IM");
    }

    #[test]
    fn drawing_over_the_border_is_cut() {
        let fonts = Fonts::load().expect("embedded");
        let mut canvas = Image::new(3, 2);
        fonts.draw(
            &mut canvas,
            ("WWW", Ink::black(40.0).bold()),
            (-10.0, 8.0),
            Align::Left,
        );
        assert!(canvas.pixels.iter().flatten().all(|v| v.is_finite()));
    }
}
