//! Kept frames of a sequence on one sheet: the reference and each method a row, the frames columns.

use super::canvas::{Rect, scaled};
use super::data::{Data, SceneOf};
use super::figure::{Drawing, Head, Shown};
use super::font::{Align, Fonts};
use super::frame_table::FrameTable;
use super::name::Name;
use super::number;
use super::pictures::Pictures;
use super::sheet::Sheet;
use super::shots::{frame_file, reference_key, values};
use super::title::Title;
use crate::experiment::spread;
use crate::image::{Image, read_coded, to_display};

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
    (scene, shown): (&SceneOf, &[Shown]),
    (head, per_viewer): (Head, bool),
) -> Result<Drawing, String> {
    let sequence = data.sequence(scene, &data.points()[0]);
    let sequence = sequence.ok_or("no job has frames")?;
    let there: Vec<&Pictures> = shown.iter().filter_map(|(_, p)| *p).collect();
    let first = there.first().ok_or("no images of these methods")?;
    let file = |p: &Pictures, shot| data.store.folder.join(frame_file(p.row, shot, "png"));
    let kept = |frame: &u32| there.iter().any(|p| file(p, (*frame, 0)).is_file());
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
        let reference = |frame: &u32| {
            let key = reference_key(&tables, (*frame, viewer))?;
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
            let cell = |frame: &u32| {
                let read = read_coded(&file(pictures, (*frame, viewer)));
                (
                    read.ok().map(|(image, _)| image),
                    values(table, (*frame, viewer)),
                )
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
        sheet: films.draw(fonts, head.title, (first.beauty.width, first.beauty.height)),
        caption: format!(
            "{} frames{fewer}, {}, seed {}; errors are those of the frame.{who}",
            frames.len(),
            number::budget(&first.row.budget),
            first.row.seed
        ),
    })
}

impl Films {
    fn draw(&self, fonts: &Fonts, title: &str, image: (usize, usize)) -> Sheet {
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
        let pitch = (
            cell.0.max(widest).max(fonts.room(5.0)) + GAP,
            cell.1 + values + GAP,
        );
        let width = left + columns * pitch.0 - GAP + MARGIN;
        let title = Title::new(fonts, title, (width - 2 * MARGIN) as f32);
        let top = MARGIN + title.height(fonts) + fonts.room(HEAD);
        let height = top + self.rows.len() * pitch.1 - GAP + MARGIN;
        let mut canvas = Sheet::new(width, height);
        title.draw(&mut canvas, fonts, (MARGIN, MARGIN));
        for (column, head) in self.heads.iter().enumerate() {
            let middle = (left + column * pitch.0 + cell.0 / 2) as f32;
            let at = (middle, top as f32 - 0.4 * fonts.em);
            canvas.text(fonts, (head, ink), at, Align::Center);
        }
        for (index, row) in self.rows.iter().enumerate() {
            let y = top + index * pitch.1;
            let at = (MARGIN as f32, (y + cell.1 / 2) as f32 + 0.35 * fonts.em);
            let label = Name::new(fonts, &row.label, (ink, room));
            label.draw_around(&mut canvas, fonts, at, Align::Left);
            for (column, (image, text)) in row.cells.iter().enumerate() {
                let corner = (left + column * pitch.0, y);
                match image {
                    Some(image) => canvas.put(&scaled(image, cell), corner),
                    None => canvas.fill(rect(corner, cell), ABSENT),
                }
                canvas.frame(rect(corner, cell), 1, RIM);
                let middle = (corner.0 + cell.0 / 2) as f32;
                let at = (middle, (y + cell.1) as f32 + fonts.em);
                canvas.text(fonts, (text, ink), at, Align::Center);
            }
        }
        canvas
    }
}

/// The aspect of the images, at this longer side.
fn cell_size((width, height): (usize, usize), longest: usize) -> (usize, usize) {
    let scale = longest as f64 / width.max(height).max(1) as f64;
    let side = |n: usize| ((n as f64 * scale).round() as usize).max(1);
    (side(width), side(height))
}

fn rect((x, y): (usize, usize), (width, height): (usize, usize)) -> Rect {
    Rect {
        x,
        y,
        width,
        height,
    }
}
