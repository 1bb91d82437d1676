//! The comparison of the papers: one large image, and for every method insets, a FLIP map and
//! errors.

use glam::Vec2;

use super::canvas::{color_bar, fitted_size, painted, shown};
use super::estimate::{Estimate, Standing, standings};
use super::figure::{Drawing, Head, Shown};
use super::font::{Align, Fonts};
use super::name::{self, Name};
use super::number::{self, Style};
use super::pictures::Pictures;
use super::sheet::{Sheet, Stroke};
use super::title::Title;
use super::{inset, pictures};
use crate::experiment::Unit;
use crate::image::{Image, Plane, Rect, Size};

const MARGIN: usize = 16;
const GAP: usize = 10;
/// Width of a method's column.
const CELL: usize = 212;
/// Height of the names of methods, and of a line of errors, in sizes of common text.
const HEAD: f32 = 1.65;
const VALUE: f32 = 1.35;
/// Size of the names of methods.
const NAME: f32 = 1.1;
/// Frames that stay apart for the colour-blind: vermilion, blue, bluish green.
const FRAMES: [[f32; 3]; 3] = [[0.84, 0.37, 0.0], [0.0, 0.45, 0.9], [0.0, 0.62, 0.45]];
const ABSENT: [f32; 3] = [0.92; 3];

/// A linear image and how it is exposed.
#[derive(Clone, Copy)]
struct Exposed<'a> {
    image: &'a Image,
    /// Stops.
    exposure: f32,
}

/// Sizes of everything in a comparison.
#[derive(Clone, Copy)]
struct Layout {
    big: Size,
    /// Height of an inset.
    inset: usize,
    /// Size of a FLIP map.
    flip: Size,
    /// Top of the large image and of the first inset.
    top: usize,
    /// Left border of the first method's column.
    left: usize,
    /// Methods, and the reference, side by side.
    across: usize,
    /// Heights of the name of a method and of its errors.
    texts: (usize, usize),
    insets: usize,
}

impl Layout {
    /// The large image and the columns, `across` of them side by side, but for what depends on the text.
    fn new(image: Size, insets: usize, across: usize) -> Self {
        let big = fitted_size(image, Size::new(1000, 900));
        let flip = fitted_size(image, Size::new(CELL, 220));
        let room = big.height.saturating_sub(flip.height) / insets.max(1);
        Self {
            big,
            inset: room.saturating_sub(GAP).clamp(130, 300),
            flip,
            top: 0,
            left: MARGIN + big.width.max(CELL) + 2 * GAP,
            across,
            texts: (0, 0),
            insets,
        }
    }

    fn flip_top(&self) -> usize {
        self.top + self.insets * (self.inset + GAP)
    }

    /// Height of a line of methods.
    fn pitch(&self) -> usize {
        self.texts.0 + self.insets * (self.inset + GAP) + self.flip.height + self.texts.1
    }

    fn width(&self) -> usize {
        self.left + self.across * (CELL + GAP) - GAP + MARGIN
    }

    /// Of the whole figure with so many columns.
    fn height(&self, columns: usize) -> usize {
        let lines = columns.div_ceil(self.across);
        let grid = self.top - self.texts.0 + lines * self.pitch();
        grid.max(self.top + self.big.height + GAP) + MARGIN
    }

    /// The left border of a column, and the layout with the top of its line.
    fn column(&self, index: usize) -> (usize, Self) {
        let left = self.left + index % self.across * (CELL + GAP);
        let top = self.top + index / self.across * self.pitch();
        (left, Self { top, ..*self })
    }
}

/// Draws the comparison: the last method large, then every method and the reference.
///
/// `insets` are fractions `[x, y, width, height]`; without any they are chosen.
pub fn draw(
    fonts: &Fonts,
    methods: &[Shown],
    head: Head,
    insets: &[[f64; 4]],
) -> Result<Drawing, String> {
    let there: Vec<&Pictures> = methods.iter().filter_map(|(_, p)| *p).collect();
    let Some(main) = there.last() else {
        return Err("no images of these methods".into());
    };
    // Not every method keeps records.
    let records = there.iter().filter_map(|p| p.row.caches).max();
    let size = main.beauty.size();
    let windows = windows(&there, size, insets);
    let columns = methods.len() + 1;
    let across = columns.min(head.columns.unwrap_or(columns));
    let mut layout = Layout::new(size, windows.len(), across);
    let title = Title::new(fonts, head.title, (layout.width() - 2 * MARGIN) as f32);
    let labels = methods.iter().map(|(label, _)| *label);
    let above = name::room_above(fonts, labels, fonts.ink(NAME).bold(), CELL as f32);
    let head_height = fonts.room(HEAD) + above;
    layout.texts = (head_height, fonts.room(2.0 * VALUE + 0.4));
    layout.top = MARGIN + title.height(fonts) + layout.texts.0;
    let mut canvas = Sheet::new(layout.width(), layout.height(columns));
    title.draw(&mut canvas, fonts, MARGIN, MARGIN);
    let reference = there.iter().find_map(|p| p.reference.as_ref());
    draw_main(&mut canvas, fonts, main, &layout, &windows);
    let values = Values::new(methods);
    for (index, (label, pictures)) in methods.iter().enumerate() {
        let (left, layout) = layout.column(index);
        draw_name(&mut canvas, fonts, label, left, layout.top);
        let image = pictures.map(|p| Exposed {
            image: &p.beauty,
            exposure: p.exposure,
        });
        draw_insets(&mut canvas, image, &layout, &windows, left);
        let flip = pictures.and_then(|p| p.flip.as_ref());
        draw_flip(&mut canvas, flip, &layout, left);
        let top = layout.flip_top() + layout.flip.height;
        values.draw(&mut canvas, fonts, index, left, top);
    }
    let (left, layout) = layout.column(methods.len());
    draw_name(&mut canvas, fonts, "reference", left, layout.top);
    let reference = reference.map(|image| Exposed {
        image,
        exposure: main.exposure,
    });
    draw_insets(&mut canvas, reference, &layout, &windows, left);
    draw_scale(&mut canvas, fonts, left, layout.flip_top());
    Ok(Drawing {
        sheet: canvas,
        caption: format!(
            "{} × {} pixels, {}, seed {}. Frames mark the insets; below them the FLIP map; errors are those of the run shown{}, the least underlined.",
            size.width,
            size.height,
            records.map_or_else(
                || number::budget(&main.row.budget),
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
fn windows(there: &[&Pictures], size: Size, asked: &[[f64; 4]]) -> Vec<Rect> {
    if asked.is_empty() {
        let errors: Vec<Plane> = there
            .iter()
            .filter_map(|p| p.flip.clone().or_else(|| p.error()))
            .collect();
        let errors: Vec<&Plane> = errors.iter().collect();
        let count = if size.height > size.width { 3 } else { 2 };
        let cell = Layout::new(size, count, 1).inset;
        let zoom = (CELL as f64 / (0.13 * size.width.max(size.height) as f64))
            .round()
            .clamp(2.0, 12.0) as usize;
        let window = Size::new(CELL / zoom, cell / zoom);
        return inset::choose(&errors, size, window, count);
    }
    asked
        .iter()
        .take(FRAMES.len())
        .map(|[x, y, width, height]| {
            let pixel = |fraction: f64, side: usize| {
                (fraction.clamp(0.0, 1.0) * side as f64).round() as usize
            };
            let (x, y) = (
                pixel(*x, size.width).min(size.width - 1),
                pixel(*y, size.height).min(size.height - 1),
            );
            Rect {
                x,
                y,
                width: pixel(*width, size.width).clamp(1, size.width - x),
                height: pixel(*height, size.height).clamp(1, size.height - y),
            }
        })
        .collect()
}

fn draw_main(
    canvas: &mut Sheet,
    fonts: &Fonts,
    main: &Pictures,
    layout: &Layout,
    windows: &[Rect],
) {
    let width = (layout.left - MARGIN - 2 * GAP) as f32;
    let at = Vec2::new(MARGIN as f32, layout.top as f32 - 0.45 * fonts.em);
    let label = Name::new(fonts, &main.row.label, fonts.ink(NAME).bold(), width);
    label.draw(canvas, fonts, at, Align::Left);
    canvas.put(
        &shown(&main.beauty, main.exposure, layout.big),
        MARGIN,
        layout.top,
    );
    let scale = |at: usize, big: usize, side: usize| {
        (at as f64 * big as f64 / side as f64).round() as usize
    };
    for (window, color) in windows.iter().zip(FRAMES) {
        let x = scale(window.x, layout.big.width, main.beauty.width);
        let y = scale(window.y, layout.big.height, main.beauty.height);
        let rect = Rect {
            x: MARGIN + x,
            y: layout.top + y,
            width: scale(window.x + window.width, layout.big.width, main.beauty.width) - x,
            height: scale(
                window.y + window.height,
                layout.big.height,
                main.beauty.height,
            ) - y,
        };
        canvas.frame(rect, 4, color);
    }
}

/// The name of a method above its column.
fn draw_name(canvas: &mut Sheet, fonts: &Fonts, label: &str, left: usize, top: usize) {
    let at = Vec2::new(
        left as f32 + CELL as f32 / 2.0,
        top as f32 - 0.45 * fonts.em,
    );
    let label = Name::new(fonts, label, fonts.ink(NAME).bold(), CELL as f32);
    label.draw(canvas, fonts, at, Align::Center);
}

fn draw_insets(
    canvas: &mut Sheet,
    image: Option<Exposed>,
    layout: &Layout,
    windows: &[Rect],
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
        if let Some(Exposed { image, exposure }) = image {
            let crop = image.crop(*window);
            let size = enlarged(crop.size(), Size::new(cell.width, cell.height));
            let x = cell.x + (cell.width - size.width) / 2;
            let y = cell.y + (cell.height - size.height) / 2;
            canvas.put(&shown(&crop, exposure, size), x, y);
        }
        canvas.frame(cell, 5, color);
    }
}

/// Fills the cell in one direction and keeps the aspect.
fn enlarged(crop: Size, cell: Size) -> Size {
    let across = cell.width as f64 / crop.width.max(1) as f64;
    let down = cell.height as f64 / crop.height.max(1) as f64;
    let scale = across.min(down);
    let side = |n: usize, most: usize| ((n as f64 * scale).round() as usize).clamp(1, most);
    Size::new(side(crop.width, cell.width), side(crop.height, cell.height))
}

fn draw_flip(canvas: &mut Sheet, flip: Option<&Plane>, layout: &Layout, left: usize) {
    let cell = Rect {
        x: left + (CELL - layout.flip.width) / 2,
        y: layout.flip_top(),
        width: layout.flip.width,
        height: layout.flip.height,
    };
    match flip {
        Some(flip) => canvas.put(&painted(flip, 1.0, layout.flip), cell.x, cell.y),
        None => canvas.fill(cell, ABSENT),
    }
}

/// What the colours of the FLIP maps mean, in the reference's column.
fn draw_scale(canvas: &mut Sheet, fonts: &Fonts, left: usize, top: usize) {
    let ink = fonts.ink(1.0);
    let at = |x: usize, y: f32| Vec2::new((left + x) as f32, top as f32 + y * fonts.em);
    let small = fonts.shrunk("FLIP map", ink, CELL as f32);
    canvas.text(fonts, "FLIP map", small, at(CELL / 2, 1.0), Align::Center);
    let bar = color_bar(CELL - 20, fonts.room(0.7));
    canvas.put(&bar, left + 10, top + fonts.room(1.5));
    canvas.text(fonts, "0", ink, at(10, 3.2), Align::Left);
    canvas.text(fonts, "1", ink, at(CELL - 10, 3.2), Align::Right);
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

    fn draw(&self, canvas: &mut Sheet, fonts: &Fonts, index: usize, left: usize, top: usize) {
        for (line, values) in self.lines.iter().enumerate() {
            let (text, standing) = &values[index];
            let ink = fonts.shrunk(text, fonts.ink(1.0), CELL as f32);
            let x = left as f32 + CELL as f32 / 2.0;
            let y = top as f32 + (1.15 + VALUE * line as f32) * fonts.em;
            canvas.text(fonts, text, ink, Vec2::new(x, y), Align::Center);
            if *standing == Standing::Best {
                let half = fonts.width(text, ink.size) / 2.0;
                let below = y + 0.2 * fonts.em;
                let rule = Stroke::solid(ink.color, 0.08 * fonts.em);
                let ends = [x - half, x + half].map(|x| Vec2::new(x, below));
                canvas.line(&ends, rule);
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
