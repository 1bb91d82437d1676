//! Record positions over dimmed images, and discontinuity maps: panels side by side.

use glam::Vec2;

use super::canvas::{color_bar, disc, fitted_size, painted, shown};
use super::figure::{Drawing, Head, Shown};
use super::font::{Align, Fonts};
use super::name::{self, Name};
use super::number;
use super::pictures::Pictures;
use super::sheet::Sheet;
use super::side_by_side::bright_end;
use super::title::Title;
use crate::image::{Image, Plane, Size};

const MARGIN: usize = 16;
const GAP: usize = 14;
/// Height of the label of a panel, and of the line below all panels, in sizes of common text.
const HEAD: f32 = 1.65;
const FOOT: f32 = 1.8;
const FIRST: [f32; 3] = [0.0, 0.27, 0.85];
const REFINED: [f32; 3] = [0.88, 0.05, 0.05];
/// Pixels of a panel that a record should have for itself.
const AREA_PER_RECORD: f64 = 30.0;

/// The records of each method over its dimmed image.
pub fn records(fonts: &Fonts, methods: &[Shown], head: Head) -> Result<Drawing, String> {
    let there: Vec<(&str, &Pictures, &Plane)> = methods
        .iter()
        .filter_map(|(label, p)| p.and_then(|p| Some((*label, p, p.records.as_ref()?))))
        .collect();
    let Some((_, first, _)) = there.first() else {
        return Err("no record positions of these methods".into());
    };
    let image = first.beauty.size();
    let most = there
        .iter()
        .map(|(_, _, r)| count(r, 0.5))
        .max()
        .unwrap_or(0);
    let size = panel_size(image, most);
    let panels: Vec<(String, Image)> = there
        .iter()
        .map(|(label, pictures, records)| {
            let text = match count(records, 1.5) {
                0 => format!("{label}: {} records", number::count(count(records, 0.5))),
                refined => format!(
                    "{label}: {} + {} records",
                    number::count(count(records, 0.5) - refined),
                    number::count(refined)
                ),
            };
            (text, dotted(pictures, records, size))
        })
        .collect();
    let mut canvas = arrange(fonts, &panels, head);
    legend(
        &mut canvas,
        fonts,
        [("first stage", FIRST), ("refinement", REFINED)],
    );
    Ok(Drawing {
        sheet: canvas,
        caption: format!(
            "Pixels that hold a record, seed {}: first stage blue, refinement red.",
            first.row.seed
        ),
    })
}

fn count(records: &Plane, above: f32) -> u64 {
    records.values.iter().filter(|v| **v > above).count() as u64
}

/// Large enough to tell the records apart, within reason.
fn panel_size(image: Size, records: u64) -> Size {
    let pixels = (image.width * image.height).max(1) as f64;
    let scale = (AREA_PER_RECORD * records as f64 / pixels).sqrt();
    let wanted = (image.width.max(image.height) as f64 * scale) as usize;
    let side = wanted.clamp(640, 1600);
    fitted_size(image, Size::new(side, side))
}

fn dotted(pictures: &Pictures, records: &Plane, size: Size) -> Image {
    let mut panel =
        shown(&pictures.beauty, pictures.exposure, size).map(|p| p.map(|v| 0.5 + 0.5 * v));
    let (width, height) = (records.width, records.height);
    let sx = size.width as f32 / width as f32;
    let sy = size.height as f32 / height as f32;
    let share = (size.width * size.height) as f32 / count(records, 0.5).max(1) as f32;
    let radius = (share.sqrt() * 0.22).clamp(0.7, 4.0);
    for (stage, color) in [(1.0, FIRST), (2.0, REFINED)] {
        for (index, _) in records
            .values
            .iter()
            .enumerate()
            .filter(|(_, v)| **v == stage)
        {
            let (x, y) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
            disc(&mut panel, Vec2::new(x * sx, y * sy), radius, color);
        }
    }
    panel
}

/// Names two colours in the line below all panels.
pub fn legend(canvas: &mut Sheet, fonts: &Fonts, entries: [(&str, [f32; 3]); 2]) {
    let em = fonts.em;
    let y = (canvas.height - MARGIN) as f32 - 0.4 * em;
    let room = (canvas.width - 2 * MARGIN) as f32 / 2.0 - 2.2 * em;
    let mut x = MARGIN as f32;
    for (text, color) in entries {
        let (text, ink) = fonts.fitted(text, fonts.ink(1.0), room);
        let dot = Vec2::new(x + 0.3 * em, y - 0.32 * em);
        canvas.disc(dot, 0.27 * em, color);
        canvas.text(fonts, &text, ink, Vec2::new(x + em, y), Align::Left);
        x += 2.2 * em + fonts.width(&text, ink.size);
    }
}

/// The maps that guided the refinements, on one scale.
pub fn discontinuity(fonts: &Fonts, methods: &[Shown], head: Head) -> Result<Drawing, String> {
    let there: Vec<(&str, &Pictures, &Plane)> = methods
        .iter()
        .filter_map(|(label, p)| p.and_then(|p| Some((*label, p, p.discontinuity.as_ref()?))))
        .collect();
    let Some((_, first, _)) = there.first() else {
        return Err("no discontinuity maps of these methods".into());
    };
    let planes: Vec<&Plane> = there.iter().map(|(_, _, plane)| *plane).collect();
    let high = bright_end(&planes);
    let size = fitted_size(first.beauty.size(), Size::new(960, 960));
    let panels: Vec<(String, Image)> = there
        .iter()
        .map(|(label, _, plane)| ((*label).to_owned(), painted(plane, high, size)))
        .collect();
    let mut canvas = arrange(fonts, &panels, head);
    scale(&mut canvas, fonts, high);
    Ok(Drawing {
        sheet: canvas,
        caption: format!(
            "The map that guides the refinement, seed {}; colours end at its 99.5 % quantile.",
            first.row.seed
        ),
    })
}

fn scale(canvas: &mut Sheet, fonts: &Fonts, high: f32) {
    let ink = fonts.ink(1.0);
    let baseline = (canvas.height - MARGIN) as f32 - 0.4 * fonts.em;
    let left = MARGIN + fonts.room(0.9);
    let bar = Size::new(fonts.room(10.0), fonts.room(0.75));
    let top = canvas.height - MARGIN - fonts.room(0.4) - bar.height;
    let at = Vec2::new(MARGIN as f32, baseline);
    canvas.text(fonts, "0", ink, at, Align::Left);
    canvas.put(&color_bar(bar.width, bar.height), left, top);
    let text = format!("{} and more", number::lone(f64::from(high)));
    let at = Vec2::new((left + bar.width) as f32 + 0.4 * fonts.em, baseline);
    canvas.text(fonts, &text, ink, at, Align::Left);
}

/// Panels of equal size with their labels above, at most three (two of large ones) in a row, a title
/// above and room for a legend below.
pub fn arrange(fonts: &Fonts, panels: &[(String, Image)], head: Head) -> Sheet {
    let widest = panels.iter().map(|(_, p)| p.width).max().unwrap_or(1);
    let tallest = panels.iter().map(|(_, p)| p.height).max().unwrap_or(1);
    let cell = widest.max(300);
    let across = match cell {
        0..=1000 if panels.len() != 4 => 3,
        _ => 2,
    };
    let columns = panels.len().clamp(1, head.columns.unwrap_or(across));
    let lines = panels.len().div_ceil(columns);
    let width = (2 * MARGIN + columns * (cell + GAP) - GAP).max(fonts.room(20.0));
    let labels = panels.iter().map(|(label, _)| label.as_str());
    let (ink, room) = (fonts.ink(1.0), cell as f32);
    let head_height = fonts.room(HEAD) + name::room_above(fonts, labels, ink, room);
    let title = Title::new(fonts, head.title, (width - 2 * MARGIN) as f32);
    let top = MARGIN + title.height(fonts);
    let pitch = head_height + tallest + GAP;
    let height = top + lines * pitch - GAP + fonts.room(FOOT) + MARGIN;
    let mut canvas = Sheet::new(width, height);
    title.draw(&mut canvas, fonts, MARGIN, MARGIN);
    for (index, (label, panel)) in panels.iter().enumerate() {
        let left = MARGIN + (index % columns) * (cell + GAP);
        let y = top + (index / columns) * pitch + head_height;
        let at = Vec2::new(left as f32, y as f32 - 0.45 * fonts.em);
        Name::new(fonts, label, ink, room).draw(&mut canvas, fonts, at, Align::Left);
        canvas.put(panel, left, y);
    }
    canvas
}
