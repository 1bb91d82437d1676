//! Kept frames of a sequence on one sheet: the reference and each method a row, the frames columns.

use glam::Vec2;

use super::canvas::scaled;
use super::data::{Data, SceneOf};
use super::figure::{Drawing, Head, Shown};
use super::font::{Align, Fonts};
use super::frame_table::{FrameTable, Seen};
use super::name::Name;
use super::number;
use super::pictures::Pictures;
use super::sheet::Sheet;
use super::shots::{frame_file, reference_key, values};
use super::title::Title;
use crate::experiment::spread;
use crate::image::{Image, Rect, Size, read_coded, to_display};

/// Columns at most, if the config does not say it.
const COLUMNS: usize = 8;
/// Width of the pictures together, about, pixels.
const WIDTH: usize = 1760;
const MARGIN: usize = 16;
const GAP: usize = 8;
/// Height of the numbers of frames, and of the errors under a picture, in sizes of common text.
const HEAD: f32 = 1.4;
const VALUES: f32 = 1.4;
const ABSENT: [f32; 3] = [0.92; 3];
const RIM: [f32; 3] = [0.75; 3];

/// What is drawn, by columns and rows.
struct Films {
    heads: Vec<String>,
    rows: Vec<Row>,
}

/// A line of pictures.
struct Row {
    label: String,
    /// The picture of each frame, if it is there, and the text under it.
    cells: Vec<(Option<Image>, String)>,
}

/// Draws some of the kept frames of the first viewer, or of each with `per_viewer`.
pub fn draw(
    fonts: &Fonts,
    data: &Data,
    scene: &SceneOf,
    shown: &[Shown],
    head: Head,
    per_viewer: bool,
) -> Result<Drawing, String> {
    let sequence = data.sequence(scene, &data.points()[0]);
    let sequence = sequence.ok_or("no job has frames")?;
    let there: Vec<&Pictures> = shown.iter().filter_map(|(_, p)| *p).collect();
    let first = there.first().ok_or("no images of these methods")?;
    let file = |p: &Pictures, seen| data.store.folder.join(frame_file(p.row, seen, "png"));
    let kept = |&frame: &u32| {
        let seen = Seen { frame, viewer: 0 };
        there.iter().any(|p| file(p, seen).is_file())
    };
    let kept: Vec<u32> = sequence.kept.iter().copied().filter(kept).collect();
    if kept.is_empty() {
        return Err("no frame was kept".into());
    }
    let frames = spread(&kept, head.columns.unwrap_or(COLUMNS));
    let tables = there.iter().map(|p| FrameTable::of(data, p.row));
    let tables: Vec<FrameTable> = tables.map(Result::unwrap_or_default).collect();
    let names = sequence.viewer_names();
    let viewers = if per_viewer { names.len() } else { 1 };
    let named = |label: &str, viewer: usize| match viewers {
        1 => label.to_owned(),
        _ => format!("{label}, {}", names[viewer]),
    };
    let mut rows = Vec::new();
    for viewer in 0..viewers {
        let reference = |&frame: &u32| {
            let key = reference_key(&tables, Seen { frame, viewer })?;
            Some(to_display(&data.references.mean(&key)?, first.exposure))
        };
        rows.push(Row {
            label: named("reference", viewer),
            cells: frames
                .iter()
                .map(|f| (reference(f), String::new()))
                .collect(),
        });
        for (pictures, table) in there.iter().zip(&tables) {
            let cell = |&frame: &u32| {
                let seen = Seen { frame, viewer };
                let read = read_coded(&file(pictures, seen));
                (read.ok().map(|(image, _)| image), values(table, seen))
            };
            rows.push(Row {
                label: named(&pictures.row.label, viewer),
                cells: frames.iter().map(cell).collect(),
            });
        }
    }
    let films = Films {
        heads: frames
            .iter()
            .map(|frame| format!("frame {frame}"))
            .collect(),
        rows,
    };
    let who = match (names.len(), viewers) {
        (1, _) => String::new(),
        (_, 1) => format!(" Viewer {}.", names[0]),
        (count, _) => format!(" {count} viewers."),
    };
    let fewer = match frames.len() < kept.len() {
        true => format!(" of {} that were kept", kept.len()),
        false => String::new(),
    };
    Ok(Drawing {
        sheet: films.draw(fonts, head.title, first.beauty.size()),
        caption: format!(
            "{} frames{fewer}, {}, seed {}; errors are those of the frame.{who}",
            frames.len(),
            number::budget(&first.row.budget),
            first.row.seed
        ),
    })
}

impl Films {
    fn draw(&self, fonts: &Fonts, title: &str, image: Size) -> Sheet {
        let columns = self.heads.len();
        let ink = fonts.ink(1.0);
        let labels = self.rows.iter();
        let labels = labels.map(|row| fonts.width(&row.label, ink.size));
        let room = labels.fold(80.0, f32::max).min(10.0 * fonts.em);
        let left = MARGIN + room as usize + 2 * GAP;
        let texts = self.rows.iter().flat_map(|row| &row.cells);
        let texts = texts.map(|(_, text)| fonts.width(text, ink.size));
        let widest = texts.fold(0.0, f32::max) as usize;
        let cell = cell_size(image, (WIDTH / columns).clamp(220, 480));
        let values = fonts.room(VALUES);
        let pitch = Size {
            width: cell.width.max(widest).max(fonts.room(5.0)) + GAP,
            height: cell.height + values + GAP,
        };
        let width = left + columns * pitch.width - GAP + MARGIN;
        let title = Title::new(fonts, title, (width - 2 * MARGIN) as f32);
        let top = MARGIN + title.height(fonts) + fonts.room(HEAD);
        let height = top + self.rows.len() * pitch.height - GAP + MARGIN;
        let mut canvas = Sheet::new(width, height);
        title.draw(&mut canvas, fonts, MARGIN, MARGIN);
        for (column, head) in self.heads.iter().enumerate() {
            let middle = (left + column * pitch.width + cell.width / 2) as f32;
            let at = Vec2::new(middle, top as f32 - 0.4 * fonts.em);
            canvas.text(fonts, head, ink, at, Align::Center);
        }
        for (index, row) in self.rows.iter().enumerate() {
            let y = top + index * pitch.height;
            let baseline = (y + cell.height / 2) as f32 + 0.35 * fonts.em;
            let at = Vec2::new(MARGIN as f32, baseline);
            let label = Name::new(fonts, &row.label, ink, room);
            label.draw_around(&mut canvas, fonts, at, Align::Left);
            for (column, (image, text)) in row.cells.iter().enumerate() {
                let place = Rect::new(left + column * pitch.width, y, cell);
                match image {
                    Some(image) => canvas.put(&scaled(image, cell), place.x, y),
                    None => canvas.fill(place, ABSENT),
                }
                canvas.frame(place, 1, RIM);
                let middle = (place.x + cell.width / 2) as f32;
                let at = Vec2::new(middle, (y + cell.height) as f32 + fonts.em);
                canvas.text(fonts, text, ink, at, Align::Center);
            }
        }
        canvas
    }
}

/// The aspect of the images, at this longer side.
fn cell_size(image: Size, longest: usize) -> Size {
    let scale = longest as f64 / image.width.max(image.height).max(1) as f64;
    let side = |n: usize| ((n as f64 * scale).round() as usize).max(1);
    Size::new(side(image.width), side(image.height))
}
