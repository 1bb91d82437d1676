//! The comparison of the papers: one large image, and for every method insets, a FLIP map and
//! errors.

use super::canvas::{Rect, color_bar, fitted_size, painted, shown};
use super::estimate::{Estimate, Standing, standings};
use super::figure::{Drawing, Shown};
use super::font::{Align, Fonts, Ink};
use super::number::{self, Style};
use super::pictures::Pictures;
use super::sheet::Sheet;
use super::{inset, pictures};
use crate::experiment::Unit;
use crate::image::{Image, Plane};

const MARGIN: usize = 16;
const GAP: usize = 10;
/// Width of a method's column.
const CELL: usize = 212;
const TITLE: usize = 52;
const HEAD: usize = 38;
const VALUES: usize = 72;
/// Frames that stay apart for the colour-blind: vermilion, blue, bluish green.
const FRAMES: [[f32; 3]; 3] = [[0.84, 0.37, 0.0], [0.0, 0.45, 0.9], [0.0, 0.62, 0.45]];
const ABSENT: [f32; 3] = [0.92; 3];

/// Sizes of everything in a comparison.
struct Layout {
    big: (usize, usize),
    /// Height of an inset.
    inset: usize,
    /// Size of a FLIP map.
    flip: (usize, usize),
    /// Top of the large image and of the first inset.
    top: usize,
    /// Left border of the first method's column.
    left: usize,
}

impl Layout {
    fn new(image: (usize, usize), insets: usize) -> Self {
        let big = fitted_size(image, (1000, 900));
        let flip = fitted_size(image, (CELL, 220));
        let room = big.1.saturating_sub(flip.1) / insets.max(1);
        Self {
            big,
            inset: room.saturating_sub(GAP).clamp(130, 300),
            flip,
            top: MARGIN + TITLE + HEAD,
            left: MARGIN + big.0.max(CELL) + 2 * GAP,
        }
    }

    fn flip_top(&self, insets: usize) -> usize {
        self.top + insets * (self.inset + GAP)
    }

    fn size(&self, columns: usize, insets: usize) -> (usize, usize) {
        let grid = self.flip_top(insets) + self.flip.1 + VALUES;
        let width = self.left + columns * (CELL + GAP) - GAP + MARGIN;
        (width, grid.max(self.top + self.big.1 + GAP) + MARGIN)
    }
}

/// Draws the comparison: the last method large, then every method and the reference.
///
/// `insets` are fractions `[x, y, width, height]`; without any they are chosen.
pub fn draw(
    fonts: &Fonts,
    methods: &[Shown],
    (title, insets): (&str, &[[f64; 4]]),
) -> Result<Drawing, String> {
    let there: Vec<&Pictures> = methods.iter().filter_map(|(_, p)| *p).collect();
    let Some(main) = there.last() else {
        return Err("no images of these methods".into());
    };
    // Not every method keeps records.
    let records = there.iter().filter_map(|p| p.row.caches).max();
    let size = (main.beauty.width, main.beauty.height);
    let windows = windows(&there, size, insets);
    let layout = Layout::new(size, windows.len());
    let (width, height) = layout.size(methods.len() + 1, windows.len());
    let mut canvas = Sheet::new(width, height);
    let reference = there.iter().find_map(|p| p.reference.as_ref());
    draw_main(&mut canvas, fonts, (title, main), (&layout, &windows));
    let values = Values::new(methods);
    for (index, (label, pictures)) in methods.iter().enumerate() {
        let left = layout.left + index * (CELL + GAP);
        head(&mut canvas, fonts, label, (left, layout.top));
        let image = pictures.map(|p| (&p.beauty, p.exposure));
        draw_insets(&mut canvas, image, (&layout, &windows), left);
        let flip = pictures.and_then(|p| p.flip.as_ref());
        draw_flip(&mut canvas, flip, (&layout, windows.len()), left);
        values.draw(
            &mut canvas,
            fonts,
            index,
            (left, layout.flip_top(windows.len()) + layout.flip.1),
        );
    }
    let left = layout.left + methods.len() * (CELL + GAP);
    head(&mut canvas, fonts, "reference", (left, layout.top));
    draw_insets(
        &mut canvas,
        reference.map(|r| (r, main.exposure)),
        (&layout, &windows),
        left,
    );
    draw_scale(&mut canvas, fonts, (left, layout.flip_top(windows.len())));
    Ok(Drawing {
        sheet: canvas,
        caption: format!(
            "{} × {} pixels, {}, seed {}. Frames mark the insets; below them the FLIP map; errors are those of the run shown{}, the least underlined.",
            size.0,
            size.1,
            records.map_or_else(
                || main.row.budget.clone(),
                |n| format!("{} records", number::count(n))
            ),
            main.row.seed,
            if main.row.frames_measured > 1 {
                " over all its measured frames"
            } else {
                ""
            }
        ),
    })
}

/// The insets in pixels: as asked for, or where the methods differ most.
fn windows(there: &[&Pictures], size: (usize, usize), asked: &[[f64; 4]]) -> Vec<Rect> {
    if asked.is_empty() {
        let errors: Vec<Plane> = there
            .iter()
            .filter_map(|p| p.flip.clone().or_else(|| p.error()))
            .collect();
        let errors: Vec<&Plane> = errors.iter().collect();
        let count = if size.1 > size.0 { 3 } else { 2 };
        let cell = Layout::new(size, count).inset;
        let zoom = (CELL as f64 / (0.13 * size.0.max(size.1) as f64))
            .round()
            .clamp(2.0, 12.0) as usize;
        return inset::choose(&errors, size, (CELL / zoom, cell / zoom), count);
    }
    asked
        .iter()
        .take(FRAMES.len())
        .map(|[x, y, width, height]| {
            let pixel = |fraction: f64, side: usize| {
                (fraction.clamp(0.0, 1.0) * side as f64).round() as usize
            };
            let (x, y) = (
                pixel(*x, size.0).min(size.0 - 1),
                pixel(*y, size.1).min(size.1 - 1),
            );
            Rect {
                x,
                y,
                width: pixel(*width, size.0).clamp(1, size.0 - x),
                height: pixel(*height, size.1).clamp(1, size.1 - y),
            }
        })
        .collect()
}

fn draw_main(
    canvas: &mut Sheet,
    fonts: &Fonts,
    (title, main): (&str, &Pictures),
    (layout, windows): (&Layout, &[Rect]),
) {
    let room = (canvas.width() - 2 * MARGIN) as f32;
    let (title, ink) = fonts.fitted(title, Ink::black(32.0).bold(), room);
    canvas.text(
        fonts,
        (&title, ink),
        (MARGIN as f32, (MARGIN + 30) as f32),
        Align::Left,
    );
    let width = layout.left - MARGIN - 2 * GAP;
    let (label, ink) = fonts.fitted(&main.row.label, Ink::black(27.0).bold(), width as f32);
    canvas.text(
        fonts,
        (&label, ink),
        (MARGIN as f32, (layout.top - 11) as f32),
        Align::Left,
    );
    canvas.put(
        &shown(&main.beauty, main.exposure, layout.big),
        (MARGIN, layout.top),
    );
    let scale = |at: usize, big: usize, side: usize| {
        (at as f64 * big as f64 / side as f64).round() as usize
    };
    for (window, color) in windows.iter().zip(FRAMES) {
        let x = scale(window.x, layout.big.0, main.beauty.width);
        let y = scale(window.y, layout.big.1, main.beauty.height);
        let rect = Rect {
            x: MARGIN + x,
            y: layout.top + y,
            width: scale(window.x + window.width, layout.big.0, main.beauty.width) - x,
            height: scale(window.y + window.height, layout.big.1, main.beauty.height) - y,
        };
        canvas.frame(rect, 4, color);
    }
}

fn head(canvas: &mut Sheet, fonts: &Fonts, label: &str, (left, top): (usize, usize)) {
    let (label, ink) = fonts.fitted(label, Ink::black(27.0).bold(), CELL as f32);
    let at = (left as f32 + CELL as f32 / 2.0, (top - 11) as f32);
    canvas.text(fonts, (&label, ink), at, Align::Center);
}

fn draw_insets(
    canvas: &mut Sheet,
    image: Option<(&Image, f32)>,
    (layout, windows): (&Layout, &[Rect]),
    left: usize,
) {
    for (index, (window, color)) in windows.iter().zip(FRAMES).enumerate() {
        let cell = Rect {
            x: left,
            y: layout.top + index * (layout.inset + GAP),
            width: CELL,
            height: layout.inset,
        };
        canvas.fill(cell, ABSENT);
        if let Some((image, exposure)) = image {
            let crop = image.crop((window.x, window.y), (window.width, window.height));
            let size = enlarged((crop.width, crop.height), (cell.width, cell.height));
            let corner = (
                cell.x + (cell.width - size.0) / 2,
                cell.y + (cell.height - size.1) / 2,
            );
            canvas.put(&shown(&crop, exposure, size), corner);
        }
        canvas.frame(cell, 5, color);
    }
}

/// Fills the cell in one direction and keeps the aspect.
fn enlarged(crop: (usize, usize), cell: (usize, usize)) -> (usize, usize) {
    let scale = (cell.0 as f64 / crop.0.max(1) as f64).min(cell.1 as f64 / crop.1.max(1) as f64);
    let side = |n: usize, most: usize| ((n as f64 * scale).round() as usize).clamp(1, most);
    (side(crop.0, cell.0), side(crop.1, cell.1))
}

fn draw_flip(
    canvas: &mut Sheet,
    flip: Option<&Plane>,
    (layout, insets): (&Layout, usize),
    left: usize,
) {
    let cell = Rect {
        x: left + (CELL - layout.flip.0) / 2,
        y: layout.flip_top(insets),
        width: layout.flip.0,
        height: layout.flip.1,
    };
    match flip {
        Some(flip) => canvas.put(&painted(flip, 1.0, layout.flip), (cell.x, cell.y)),
        None => canvas.fill(cell, ABSENT),
    }
}

/// What the colours of the FLIP maps mean, in the reference's column.
fn draw_scale(canvas: &mut Sheet, fonts: &Fonts, (left, top): (usize, usize)) {
    let ink = Ink::black(22.0);
    let at = |x: usize, y: usize| ((left + x) as f32, (top + y) as f32);
    canvas.text(fonts, ("FLIP map", ink), at(CELL / 2, 24), Align::Center);
    canvas.put(&color_bar(CELL - 20, 16), (left + 10, top + 36));
    canvas.text(fonts, ("0", ink), at(10, 74), Align::Left);
    canvas.text(fonts, ("1", ink), at(CELL - 10, 74), Align::Right);
}

/// RMSE and FLIP under each column.
struct Values {
    lines: Vec<Vec<(String, Standing)>>,
}

impl Values {
    fn new(methods: &[Shown]) -> Self {
        let line = |name: &str, column: &str| {
            let number = |p: &Pictures| p.row.number(column).and_then(Estimate::exact);
            let values: Vec<Option<Estimate>> =
                methods.iter().map(|(_, p)| p.and_then(number)).collect();
            let style = Style::of(Unit::None, values.iter().flatten().map(|e| e.mean));
            let rivals: Vec<Option<&Estimate>> = values.iter().map(Option::as_ref).collect();
            let marks = standings(&rivals, true);
            let text = |v: &Option<Estimate>| match v {
                Some(e) => format!("{name} {}", style.number(e.mean)),
                None => format!("{name} —"),
            };
            values.iter().map(text).zip(marks).collect()
        };
        Self {
            lines: vec![line("RMSE", "rmse"), line("FLIP", "flip_ldr")],
        }
    }

    fn draw(&self, canvas: &mut Sheet, fonts: &Fonts, index: usize, (left, top): (usize, usize)) {
        for (line, values) in self.lines.iter().enumerate() {
            let (text, standing) = &values[index];
            let (text, ink) = fonts.fitted(text, Ink::black(24.0), CELL as f32);
            let (x, y) = (
                left as f32 + CELL as f32 / 2.0,
                (top + 28 + line * 32) as f32,
            );
            canvas.text(fonts, (&text, ink), (x, y), Align::Center);
            if *standing == Standing::Best {
                let width = fonts.width(&text, ink.size_px);
                let rule = Rect {
                    x: (x - width / 2.0) as usize,
                    y: y as usize + 4,
                    width: width as usize,
                    height: 2,
                };
                canvas.fill(rule, ink.color);
            }
        }
    }
}

/// A panel's largest value that is worth showing: nearly all of it lies below.
pub fn bright_end(planes: &[&Plane]) -> f32 {
    match pictures::quantile(planes, 0.995) {
        high if high > 0.0 => high,
        _ => pictures::quantile(planes, 1.0),
    }
}
