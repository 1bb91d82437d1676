//! A plot: its panels in columns, under a title and above a legend.

use glam::Vec2;

use super::chart::{Area, Around, Chart, outer_height};
use super::font::{Align, Fonts};
use super::legend::{Legend, Mark};
use super::sheet::Sheet;
use crate::experiment::{Column, Unit};

/// From the border of the sheet to what is drawn, in sizes of common text.
const MARGIN: f32 = 0.6;
const TITLE: f32 = 1.35;

/// What all plots have.
pub struct Plot<'a> {
    pub title: &'a str,
    pub legend: Vec<(Mark, String)>,
    /// Panels side by side.
    pub columns: usize,
    /// Width of a panel with its axis, and height without.
    pub panel: (f32, f32),
}

impl Plot<'_> {
    /// Draws rows of panels; `paint` adds the data of a panel, counted over all rows.
    pub fn draw(
        &self,
        fonts: &Fonts,
        rows: &[&[Around]],
        mut paint: impl FnMut(&mut Sheet, usize, &Chart),
    ) -> Sheet {
        let margin = MARGIN * fonts.em;
        let width = self.panel.0 * self.columns as f32;
        let ink = fonts.ink(TITLE);
        let title = fonts.lines(self.title, ink, width - 2.0 * margin);
        let line = 1.3 * ink.size;
        let top = line * title.len() as f32 + margin;
        let entries = self.legend.clone();
        let legend = Legend::new(fonts, entries, width - 2.0 * margin);
        let heights = rows.iter().map(|row| {
            let outer = row.iter().map(|around| outer_height(fonts, around));
            self.panel.1 + outer.fold(0.0, f32::max)
        });
        let heights: Vec<f32> = heights.collect();
        let body: f32 = heights.iter().sum();
        let height = top + body + legend.height(fonts);
        let mut sheet = Sheet::new(width.round() as usize, height.round() as usize);
        for (index, text) in title.iter().enumerate() {
            let (text, ink) = fonts.fitted(text, ink, width - 2.0 * margin);
            let baseline = margin + line * index as f32 + 0.9 * ink.size;
            let at = Vec2::new(width / 2.0, baseline);
            sheet.text(fonts, &text, ink, at, Align::Center);
        }
        let (mut above, mut index) = (top, 0);
        for (row, height) in rows.iter().zip(heights) {
            for (column, around) in row.iter().enumerate() {
                let left = self.panel.0 * column as f32;
                let cell = Area {
                    left: left + margin / 2.0,
                    top: above,
                    right: left + self.panel.0,
                    bottom: above + height,
                };
                let chart = Chart::draw(&mut sheet, fonts, cell, around);
                paint(&mut sheet, index, &chart);
                index += 1;
            }
            above += height;
        }
        legend.draw(&mut sheet, fonts, top + body);
        sheet
    }
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
