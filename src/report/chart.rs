//! A panel of a plot: its grid, its axes with their numbers and names, and where values stand in it.

use glam::Vec2;

use super::axis::Axis;
use super::font::{Align, Fonts};
use super::look::unit;
use super::sheet::{Sheet, Stroke};

const GRID: [f32; 3] = [0.88; 3];
const BLACK: [f32; 3] = [0.07; 3];
/// Size of the names of axes, and of titles of panels, relative to common text.
const NAME: f32 = 1.1;
const TITLE: f32 = 1.2;
/// Room above a panel without a title, and right of it, in sizes of common text.
const TOP: f32 = 0.7;
const RIGHT: f32 = 1.2;

/// A part of a sheet.
#[derive(Clone, Copy, Debug)]
pub struct Area {
    pub left: f32,
    pub top: f32,
    pub right: f32,
    pub bottom: f32,
}

/// What stands around a panel.
pub struct Around<'a> {
    pub title: &'a str,
    pub x: (&'a str, &'a Axis),
    pub y: (&'a str, &'a Axis),
    /// Names that stand upright below the values 0, 1, … of the horizontal axis, in place of numbers.
    pub names: &'a [String],
    /// Width for the numbers and the name of the vertical axis.
    pub left: f32,
}

/// The inner part of a panel that was drawn.
pub struct Chart<'a> {
    pub area: Area,
    x: &'a Axis,
    y: &'a Axis,
}

/// Width for the numbers and the name of vertical axes.
pub fn left_room<'a>(fonts: &Fonts, axes: impl Iterator<Item = &'a Axis>) -> f32 {
    let labels = axes.flat_map(|axis| axis.ticks().iter().map(|tick| axis.label(*tick)));
    let widest = labels.map(|label| fonts.width(&label, fonts.em));
    widest.fold(0.0, f32::max) + (NAME + 1.6) * fonts.em
}

/// Height of what stands above and below the inner part of panels.
pub fn outer_height(fonts: &Fonts, around: &Around) -> f32 {
    above(fonts, around) + below(fonts, around)
}

fn above(fonts: &Fonts, around: &Around) -> f32 {
    let title = if around.title.is_empty() {
        0.0
    } else {
        TITLE + 0.3
    };
    (TOP + title) * fonts.em
}

fn below(fonts: &Fonts, around: &Around) -> f32 {
    let name = if around.x.0.is_empty() {
        0.0
    } else {
        NAME + 0.4
    };
    let names = around.names.iter();
    let longest = names.map(|name| fonts.width(name, fonts.em));
    let labels = longest.fold(fonts.em, f32::max);
    labels + (0.7 + name) * fonts.em
}

impl<'a> Chart<'a> {
    /// Draws everything but the data.
    pub fn draw(sheet: &mut Sheet, fonts: &Fonts, cell: Area, around: &Around<'a>) -> Self {
        let area = Area {
            left: cell.left + around.left,
            top: cell.top + above(fonts, around),
            right: cell.right - RIGHT * fonts.em,
            bottom: cell.bottom - below(fonts, around),
        };
        let chart = Self {
            area,
            x: around.x.1,
            y: around.y.1,
        };
        let middle = Vec2::new(
            (area.left + area.right) / 2.0,
            (area.top + area.bottom) / 2.0,
        );
        let title = fonts.fitted(around.title, fonts.ink(TITLE), cell.right - area.left);
        let at = Vec2::new(middle.x, area.top - 0.5 * fonts.em);
        sheet.text(fonts, &title.0, title.1, at, Align::Center);
        chart.horizontal(sheet, fonts, around.names);
        chart.vertical(sheet, fonts);
        let border = Stroke::solid(BLACK, unit(fonts));
        let head = Vec2::new(area.left, area.top);
        let foot = Vec2::new(area.left, area.bottom);
        let end = Vec2::new(area.right, area.bottom);
        sheet.line(&[head, foot, end], border);
        let name = fonts.fitted(around.x.0, fonts.ink(NAME), area.right - cell.left);
        let at = Vec2::new(middle.x, cell.bottom - 0.35 * fonts.em);
        sheet.text(fonts, &name.0, name.1, at, Align::Center);
        let name = fonts.fitted(around.y.0, fonts.ink(NAME), cell.bottom - cell.top);
        let at = Vec2::new(cell.left + (NAME + 0.1) * fonts.em, middle.y);
        sheet.upright(fonts, &name.0, name.1, at, Align::Center);
        chart
    }

    /// Where a value stands on the sheet.
    pub fn at(&self, x: f64, y: f64) -> Vec2 {
        let Area {
            left,
            top,
            right,
            bottom,
        } = self.area;
        Vec2::new(
            left + (right - left) * self.x.share(x),
            bottom + (top - bottom) * self.y.share(y),
        )
    }

    /// Grid and numbers, or names, of the horizontal axis.
    fn horizontal(&self, sheet: &mut Sheet, fonts: &Fonts, names: &[String]) {
        let grid = Stroke::solid(GRID, unit(fonts));
        let place = |tick: f64| self.at(tick, self.y.low()).x;
        for tick in self.x.ticks() {
            let x = place(*tick);
            let ends = [self.area.top, self.area.bottom].map(|y| Vec2::new(x, y));
            sheet.line(&ends, grid);
        }
        let foot = self.area.bottom;
        for (index, name) in names.iter().enumerate() {
            let x = place(index as f64) + 0.35 * fonts.em;
            let at = Vec2::new(x, foot + 0.4 * fonts.em);
            sheet.upright(fonts, name, fonts.ink(1.0), at, Align::Right);
        }
        if !names.is_empty() {
            return;
        }
        let half = |tick: f64| fonts.width(&self.x.label(tick), fonts.em) / 2.0;
        let fits =
            |a: f64, b: f64| (place(b) - place(a)).abs() >= half(a) + half(b) + 0.5 * fonts.em;
        for tick in self.x.labelled(fits) {
            let at = Vec2::new(place(tick), foot + 1.3 * fonts.em);
            let label = self.x.label(tick);
            sheet.text(fonts, &label, fonts.ink(1.0), at, Align::Center);
        }
    }

    /// Grid and numbers of the vertical axis.
    fn vertical(&self, sheet: &mut Sheet, fonts: &Fonts) {
        let grid = Stroke::solid(GRID, unit(fonts));
        let place = |tick: f64| self.at(self.x.low(), tick).y;
        for tick in self.y.ticks() {
            let y = place(*tick);
            let ends = [self.area.left, self.area.right].map(|x| Vec2::new(x, y));
            sheet.line(&ends, grid);
        }
        for tick in self
            .y
            .labelled(|a, b| (place(b) - place(a)).abs() >= 1.1 * fonts.em)
        {
            let at = Vec2::new(
                self.area.left - 0.4 * fonts.em,
                place(tick) + 0.35 * fonts.em,
            );
            let label = self.y.label(tick);
            sheet.text(fonts, &label, fonts.ink(1.0), at, Align::Right);
        }
    }
}
