//! What the marks of a plot stand for, in as many lines as they need.

use glam::Vec2;

use super::font::{Align, Fonts, Ink};
use super::look::{color, marker, unit};
use super::sheet::{Sheet, Stroke};

/// What stands before a name.
#[derive(Clone, Copy, Debug)]
pub enum Mark {
    /// The line of a method, by its position in the config.
    Method(usize),
    /// A line with dashes and spaces, if it is not solid.
    Line(Option<(f32, f32)>),
    /// A shaded area.
    Shade,
}

/// Shaded areas are black of this opacity.
pub const SHADE: f32 = 0.08;
/// Width of a mark, of the space before and after a name, and height of a line, in sizes of common text.
const MARK: f32 = 1.9;
const BEFORE: f32 = 0.4;
const AFTER: f32 = 1.4;
const LINE: f32 = 1.6;

/// Names and their marks, broken into lines.
pub struct Legend {
    lines: Vec<Vec<Entry>>,
}

struct Entry {
    mark: Mark,
    name: String,
    ink: Ink,
    /// Of mark and name.
    width: f32,
}

impl Legend {
    /// Breaks the entries into lines of a width.
    pub fn new(fonts: &Fonts, entries: Vec<(Mark, String)>, width: f32) -> Self {
        let mut lines: Vec<Vec<Entry>> = Vec::new();
        let mut used = 0.0;
        for (mark, name) in entries {
            let before = (MARK + BEFORE) * fonts.em;
            let (name, ink) = fonts.fitted(&name, fonts.ink(1.0), width - before);
            let entry = Entry {
                mark,
                width: before + fonts.width(&name, ink.size),
                name,
                ink,
            };
            let next = used + AFTER * fonts.em + entry.width;
            match lines.last_mut() {
                Some(line) if next <= width => {
                    used = next;
                    line.push(entry);
                }
                _ => {
                    used = entry.width;
                    lines.push(vec![entry]);
                }
            }
        }
        Self { lines }
    }

    pub fn height(&self, fonts: &Fonts) -> f32 {
        (LINE * self.lines.len() as f32 + 0.8) * fonts.em
    }

    /// Draws the lines from `top` on, each in the middle of the sheet.
    pub fn draw(&self, sheet: &mut Sheet, fonts: &Fonts, top: f32) {
        let after = AFTER * fonts.em;
        for (index, line) in self.lines.iter().enumerate() {
            let total: f32 = line.iter().map(|entry| entry.width + after).sum();
            let mut x = (sheet.width as f32 - (total - after)) / 2.0;
            let y = top + (LINE * index as f32 + 0.9) * fonts.em;
            for entry in line {
                draw_mark(sheet, fonts, entry.mark, Vec2::new(x, y));
                let at = Vec2::new(x + (MARK + BEFORE) * fonts.em, y + 0.34 * fonts.em);
                sheet.text(fonts, &entry.name, entry.ink, at, Align::Left);
                x += entry.width + after;
            }
        }
    }
}

/// A mark whose left end is at a place, in the middle of its line.
fn draw_mark(sheet: &mut Sheet, fonts: &Fonts, mark: Mark, at: Vec2) {
    let Vec2 { x, y } = at;
    let right = x + MARK * fonts.em;
    let ends = [at, Vec2::new(right, y)];
    let stroke = |color| Stroke::solid(color, 2.0 * unit(fonts));
    match mark {
        Mark::Method(index) => {
            sheet.line(&ends, stroke(color(index)));
            let middle = Vec2::new((x + right) / 2.0, y);
            let outline = marker(index, middle, unit(fonts));
            sheet.polygon(&outline, color(index), 1.0);
        }
        Mark::Line(dash) => {
            let dashed = Stroke {
                dash,
                ..stroke([0.0; 3])
            };
            sheet.line(&ends, dashed);
        }
        Mark::Shade => {
            let (above, below) = (y - 0.5 * fonts.em, y + 0.5 * fonts.em);
            let corners = [(x, above), (right, above), (right, below), (x, below)];
            let corners = corners.map(|(x, y)| Vec2::new(x, y));
            sheet.polygon(&corners, [0.0; 3], SHADE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_names_take_many_lines() {
        let fonts = Fonts::load().expect("embedded").at(18.0);
        let legend = |names: Vec<String>| {
            let entries = names.into_iter().map(|name| (Mark::Shade, name));
            Legend::new(&fonts, entries.collect(), 600.0)
        };
        let methods = |count: usize| (0..count).map(|i| format!("method {i}")).collect();
        assert_eq!(legend(methods(3)).lines.len(), 1);
        assert_eq!(legend(methods(12)).lines.len(), 3);
        assert_eq!(legend(Vec::new()).lines.len(), 0);
        let long = "a name that is longer than the whole sheet is wide".repeat(3);
        assert!(legend(vec![long]).lines[0][0].width <= 601.0);
    }
}
