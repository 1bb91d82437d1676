//! The title of a figure of pictures, in as many lines as it needs.

use glam::Vec2;

use super::font::{Align, Fonts};
use super::sheet::Sheet;

const SIZE: f32 = 1.25;
const LINE: f32 = 1.6;

/// A title broken into lines.
pub struct Title {
    lines: Vec<String>,
    room: f32,
}

impl Title {
    /// Breaks a title so that it fits a width.
    pub fn new(fonts: &Fonts, title: &str, room: f32) -> Self {
        let ink = fonts.ink(SIZE).bold();
        Self {
            lines: fonts.lines(title, ink, room),
            room,
        }
    }

    pub fn height(&self, fonts: &Fonts) -> usize {
        self.lines.len() * fonts.room(LINE)
    }

    /// Writes the lines below and right of a corner.
    pub fn draw(&self, sheet: &mut Sheet, fonts: &Fonts, left: usize, top: usize) {
        for (index, line) in self.lines.iter().enumerate() {
            let (text, ink) = fonts.fitted(line, fonts.ink(SIZE).bold(), self.room);
            let baseline = (top + index * fonts.room(LINE)) as f32 + 0.8 * ink.size;
            sheet.text(
                fonts,
                &text,
                ink,
                Vec2::new(left as f32, baseline),
                Align::Left,
            );
        }
    }
}
