//! The name of a method above or beside its pictures, in one line or two.

use glam::Vec2;

use super::font::{Align, Fonts, Ink};
use super::sheet::Sheet;

/// Height of a line, in sizes of its text.
const LINE: f32 = 1.15;
/// After these characters a name is broken rather than within words.
const BREAKS: &str = " +-_/,:;@)";

/// A name that fits a width: in one line, in smaller letters if need be; else in two; what is too long for those is
/// cut.
pub struct Name {
    lines: Vec<String>,
    ink: Ink,
}

impl Name {
    /// Of a text in an ink, within a width in units.
    pub fn new(fonts: &Fonts, text: &str, ink: Ink, width: f32) -> Self {
        let (line, small) = fonts.fitted(text, ink, width);
        if line == text {
            return Self {
                lines: vec![line],
                ink: small,
            };
        }
        let halves = halves(fonts, text, ink);
        let [first, second] = halves.map(|half| fonts.fitted(&half, ink, width));
        let size = first.1.size.min(second.1.size);
        Self {
            lines: vec![first.0, second.0],
            ink: Ink { size, ..ink },
        }
    }

    /// Height of what is above its last line, units.
    fn above(&self) -> f32 {
        (self.lines.len() - 1) as f32 * LINE * self.ink.size
    }

    /// Writes it with the baseline of its last line at a place.
    pub fn draw(&self, sheet: &mut Sheet, fonts: &Fonts, at: Vec2, align: Align) {
        for (index, line) in self.lines.iter().enumerate() {
            let baseline = at.y - self.above() + index as f32 * LINE * self.ink.size;
            sheet.text(fonts, line, self.ink, Vec2::new(at.x, baseline), align);
        }
    }

    /// Writes it with its middle where a single line would have its own.
    pub fn draw_around(&self, sheet: &mut Sheet, fonts: &Fonts, at: Vec2, align: Align) {
        let last = Vec2::new(at.x, at.y + self.above() / 2.0);
        self.draw(sheet, fonts, last, align);
    }
}

/// Whole units that the tallest of some names takes above a single line.
pub fn room_above<'a>(
    fonts: &Fonts,
    names: impl Iterator<Item = &'a str>,
    ink: Ink,
    width: f32,
) -> usize {
    let above = names.map(|name| Name::new(fonts, name, ink, width).above());
    above.fold(0.0, f32::max).ceil() as usize
}

/// A text broken where its longer part is shortest.
fn halves(fonts: &Fonts, text: &str, ink: Ink) -> [String; 2] {
    let parts = |at: usize| [text[..at].trim_end(), text[at..].trim_start()];
    let longer = |at: usize| {
        let widths = parts(at).map(|part| fonts.width(part, ink.size));
        widths[0].max(widths[1])
    };
    let all = || text.char_indices().map(|(at, c)| (at + c.len_utf8(), c));
    let best = |places: &mut dyn Iterator<Item = usize>| {
        places.min_by(|a, b| longer(*a).total_cmp(&longer(*b)))
    };
    let words = best(&mut all().filter(|(_, c)| BREAKS.contains(*c)).map(|(at, _)| at));
    let letters = || best(&mut all().map(|(at, _)| at)).unwrap_or(text.len());
    // A word that is most of the name is broken itself.
    let whole = fonts.width(text, ink.size);
    let at = words.filter(|at| longer(*at) < 0.75 * whole);
    parts(at.unwrap_or_else(letters)).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_take_two_lines_and_keep_all_their_letters() {
        let fonts = Fonts::load().expect("embedded").at(20.0);
        let lines = |text: &str| {
            let name = Name::new(&fonts, text, fonts.ink(1.0), 200.0);
            let fits = |line: &String| fonts.width(line, name.ink.size) <= 201.0;
            assert!(name.lines.iter().all(fits), "{:?}", name.lines);
            name.lines
        };
        assert_eq!(lines("IM"), ["IM"]);
        let long = "irradiance-caching with gradients and rounds";
        assert_eq!(
            lines(long),
            ["irradiance-caching with", "gradients and rounds"]
        );
        let one_word = "x".repeat(40);
        assert_eq!(lines(&one_word).concat(), one_word);
        assert_eq!(lines(&"too long for all ".repeat(9)).len(), 2);
        let names = ["IM", long];
        let ink = fonts.ink(1.0);
        assert!(room_above(&fonts, names.into_iter(), ink, 200.0) > 10);
        assert_eq!(room_above(&fonts, ["IM"].into_iter(), ink, 200.0), 0);
    }
}
