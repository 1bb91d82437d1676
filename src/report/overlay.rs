//! Record positions over dimmed images, and discontinuity maps: panels side by side.

use super::canvas::{color_bar, disc, fitted_size, painted, shown};
use super::figure::{Drawing, Head, Shown};
use super::font::{Align, Fonts, Ink};
use super::number;
use super::pictures::Pictures;
use super::sheet::Sheet;
use super::side_by_side::bright_end;
use crate::image::{Image, Plane};

pub const MARGIN: usize = 16;
/// From the lower margin to the baseline of a legend.
pub const FOOT_LINE: f32 = 10.0;
const GAP: usize = 14;
const HEAD: usize = 40;
const FOOT: usize = 44;
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
    let image = (first.beauty.width, first.beauty.height);
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
    legend(&mut canvas, fonts);
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
fn panel_size(image: (usize, usize), records: u64) -> (usize, usize) {
    let pixels = (image.0 * image.1).max(1) as f64;
    let scale = (AREA_PER_RECORD * records as f64 / pixels).sqrt();
    let wanted = (image.0.max(image.1) as f64 * scale) as usize;
    let side = wanted.clamp(640, 1600);
    fitted_size(image, (side, side))
}

fn dotted(pictures: &Pictures, records: &Plane, size: (usize, usize)) -> Image {
    let mut panel =
        shown(&pictures.beauty, pictures.exposure, size).map(|p| p.map(|v| 0.5 + 0.5 * v));
    let (width, height) = (records.width, records.height);
    let (sx, sy) = (size.0 as f32 / width as f32, size.1 as f32 / height as f32);
    let share = (size.0 * size.1) as f32 / count(records, 0.5).max(1) as f32;
    let radius = (share.sqrt() * 0.22).clamp(0.7, 4.0);
    for (stage, color) in [(1.0, FIRST), (2.0, REFINED)] {
        for (index, _) in records
            .values
            .iter()
            .enumerate()
            .filter(|(_, v)| **v == stage)
        {
            let center = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
            disc(&mut panel, (center.0 * sx, center.1 * sy), radius, color);
        }
    }
    panel
}

fn legend(canvas: &mut Sheet, fonts: &Fonts) {
    let y = (canvas.height() - MARGIN) as f32 - FOOT_LINE;
    let ink = Ink::black(22.0);
    let mut x = MARGIN as f32;
    for (text, color) in [("first stage", FIRST), ("refinement", REFINED)] {
        canvas.disc((x + 7.0, y - 7.0), 6.0, color);
        canvas.text(fonts, (text, ink), (x + 22.0, y), Align::Left);
        x += 22.0 + fonts.width(text, ink.size_px) + 28.0;
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
    let size = fitted_size((first.beauty.width, first.beauty.height), (960, 960));
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
    let y = canvas.height() - MARGIN - 26;
    let ink = Ink::black(22.0);
    let baseline = (y + 17) as f32;
    canvas.text(fonts, ("0", ink), (MARGIN as f32, baseline), Align::Left);
    let left = MARGIN + 22;
    let width = 260.min(canvas.width().saturating_sub(left + 160)).max(40);
    canvas.put(&color_bar(width, 18), (left, y));
    let text = format!("{} and more", number::lone(f64::from(high)));
    canvas.text(
        fonts,
        (&text, ink),
        ((left + width + 10) as f32, baseline),
        Align::Left,
    );
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
    let width = (2 * MARGIN + columns * (cell + GAP) - GAP).max(480);
    let top = MARGIN + HEAD;
    let mut canvas = Sheet::new(
        width,
        top + lines * (HEAD + tallest + GAP) + FOOT + MARGIN - GAP,
    );
    let room = (width - 2 * MARGIN) as f32;
    let (title, ink) = fonts.fitted(head.title, Ink::black(28.0).bold(), room);
    canvas.text(
        fonts,
        (&title, ink),
        (MARGIN as f32, (MARGIN + 26) as f32),
        Align::Left,
    );
    for (index, (label, panel)) in panels.iter().enumerate() {
        let left = MARGIN + (index % columns) * (cell + GAP);
        let y = top + (index / columns) * (HEAD + tallest + GAP);
        let (label, ink) = fonts.fitted(label, Ink::black(24.0), cell as f32);
        canvas.text(
            fonts,
            (&label, ink),
            (left as f32, (y + HEAD - 11) as f32),
            Align::Left,
        );
        canvas.put(panel, (left, y + HEAD));
    }
    canvas
}
