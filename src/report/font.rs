//! The embedded typefaces: how wide texts are. No font of the system is needed.

use std::io::Read;
use std::sync::{Arc, LazyLock};

use flate2::read::ZlibDecoder;
use resvg::usvg::fontdb::{Database, Source};
use ttf_parser::Face;

/// As the build packs them. The first that has a character draws it.
const PACKED: [&[u8]; 2] = [
    include_bytes!(concat!(env!("OUT_DIR"), "/UbuntuLight")),
    include_bytes!(concat!(env!("OUT_DIR"), "/HackRegular")),
];
/// Empty where what is packed is damaged.
static FACES: LazyLock<[Vec<u8>; 2]> = LazyLock::new(|| {
    PACKED.map(|packed| {
        let mut face = Vec::new();
        match ZlibDecoder::new(packed).read_to_end(&mut face) {
            Ok(_) => face,
            Err(_) => Vec::new(),
        }
    })
});

/// The typefaces, and the size of a figure's common text.
#[derive(Clone)]
pub struct Fonts {
    faces: Vec<Face<'static>>,
    /// For programs that draw SVG.
    pub database: Arc<Database>,
    /// Size of common text, units of the sheet.
    pub em: f32,
}

/// Size, weight and colour of a text.
#[derive(Clone, Copy, Debug)]
pub struct Ink {
    pub size: f32,
    pub bold: bool,
    /// sRGB-coded.
    pub color: [f32; 3],
}

impl Ink {
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

impl Fonts {
    /// Reads the embedded typefaces.
    pub fn load() -> Result<Self, String> {
        let faces: Result<_, _> = FACES.iter().map(|face| Face::parse(face, 0)).collect();
        let mut database = Database::new();
        for face in FACES.iter() {
            database.load_font_source(Source::Binary(Arc::new(face)));
        }
        Ok(Self {
            faces: faces.map_err(|e| format!("the embedded typeface cannot be read: {e}"))?,
            database: Arc::new(database),
            em: 1.0,
        })
    }

    /// The same typefaces with common text of another size.
    pub fn at(&self, em: f32) -> Self {
        Self { em, ..self.clone() }
    }

    /// Black text of a size relative to common text.
    pub fn ink(&self, share: f32) -> Ink {
        Ink {
            size: share * self.em,
            bold: false,
            color: [0.07; 3],
        }
    }

    /// Whole units for something that grows with the text.
    pub fn room(&self, share: f32) -> usize {
        (share * self.em).round() as usize
    }

    fn advance(&self, c: char, size: f32) -> f32 {
        let glyph = |face: &Face| {
            let advance = face.glyph_hor_advance(face.glyph_index(c)?)?;
            Some(f32::from(advance) / f32::from(face.units_per_em()))
        };
        size * self.faces.iter().find_map(glyph).unwrap_or(0.6)
    }

    /// Width of a line of text.
    pub fn width(&self, text: &str, size: f32) -> f32 {
        text.chars().map(|c| self.advance(c, size)).sum()
    }

    /// The text cut with an ellipsis, after its size was reduced by up to a third, to fit a width.
    pub fn fitted(&self, text: &str, ink: Ink, width: f32) -> (String, Ink) {
        let full = self.width(text, ink.size);
        let shrink = (width / full.max(1.0)).clamp(2.0 / 3.0, 1.0);
        let ink = Ink {
            size: ink.size * shrink,
            ..ink
        };
        let mut text = text.to_owned();
        if self.width(&text, ink.size) > width + 0.5 {
            while !text.is_empty()
                && self.width(&text, ink.size) + self.advance('…', ink.size) > width
            {
                text.pop();
            }
            text.push('…');
        }
        (text, ink)
    }

    /// The ink in which a text that must not be cut, such as a number, fits a width.
    pub fn shrunk(&self, text: &str, ink: Ink, width: f32) -> Ink {
        let share = width / self.width(text, ink.size).max(1.0);
        Ink {
            size: ink.size * share.min(1.0),
            ..ink
        }
    }

    /// The text in lines that fit a width, broken between words; a longer word stands alone.
    pub fn lines(&self, text: &str, ink: Ink, width: f32) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            match lines.last_mut() {
                Some(line) if self.width(&format!("{line} {word}"), ink.size) <= width => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_and_accents_have_glyphs_and_long_texts_are_cut_or_broken() {
        let fonts = Fonts::load().expect("embedded").at(24.0);
        for c in "aé±×—↓↑·…".chars() {
            let has = |face: &Face| face.glyph_index(c).is_some();
            assert!(fonts.faces.iter().any(has), "{c}");
        }
        let long = "a label that is far too long for its column ".repeat(3);
        let (cut, ink) = fonts.fitted(&long, fonts.ink(1.0), 200.0);
        assert!(cut.ends_with('…') && fonts.width(&cut, ink.size) <= 200.0);
        assert_eq!(fonts.fitted("IM", fonts.ink(1.0), 200.0).0, "IM");
        let lines = fonts.lines(&long, fonts.ink(1.0), 200.0);
        assert!(lines.iter().all(|line| fonts.width(line, 24.0) <= 200.0));
        assert_eq!(lines.join(" "), long.trim());
        assert_eq!(fonts.lines("", fonts.ink(1.0), 200.0).len(), 0);
    }
}
