//! Kept frames of a sequence on one sheet: the reference and each method a row, the frames columns.

use super::canvas::{Rect, scaled};
use super::data::{Data, SceneOf};
use super::figure::{Drawing, Shown};
use super::font::{Align, Fonts, Ink};
use super::frame_table::FrameTable;
use super::pictures::Pictures;
use super::sheet::Sheet;
use super::shots::{frame_file, reference_key, values};
use crate::experiment::spread;
use crate::image::{Image, read_coded, to_display};

/// Columns at most.
const COLUMNS: usize = 8;
/// Width of the pictures together, about, pixels.
const WIDTH: usize = 1760;
const MARGIN: usize = 16;
const GAP: usize = 8;
const TITLE: usize = 52;
const HEAD: usize = 34;
/// Height of the errors under a picture.
const VALUES: usize = 28;
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

/// Draws up to eight kept frames of the first viewer, or of each with `per_viewer`.
pub fn draw(
    fonts: &Fonts,
    data: &Data,
    (scene, shown, title): (&SceneOf, &[Shown], &str),
    per_viewer: bool,
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
    let frames = spread(&kept, COLUMNS);
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
        sheet: films.draw(fonts, title, (first.beauty.width, first.beauty.height)),
        caption: format!(
            "{} frames{fewer}, {}, seed {}; errors are those of the frame.{who}",
            frames.len(),
            first.row.budget,
            first.row.seed
        ),
    })
}

impl Films {
    fn draw(&self, fonts: &Fonts, title: &str, image: (usize, usize)) -> Sheet {
        let columns = self.heads.len();
        let cell = cell_size(image, (WIDTH / columns).clamp(220, 480));
        let ink = Ink::black(23.0);
        let labels = self
            .rows
            .iter()
            .map(|row| fonts.width(&row.label, ink.size_px));
        let room = labels.fold(80.0, f32::max).min(240.0);
        let left = MARGIN + room as usize + 2 * GAP;
        let pitch = (cell.0.max(200) + GAP, cell.1 + VALUES + GAP);
        let top = MARGIN + TITLE + HEAD;
        let mut canvas = Sheet::new(
            left + columns * pitch.0 - GAP + MARGIN,
            top + self.rows.len() * pitch.1 + MARGIN,
        );
        let full = (canvas.width() - 2 * MARGIN) as f32;
        let (title, bold) = fonts.fitted(title, Ink::black(28.0).bold(), full);
        let at = (MARGIN as f32, (MARGIN + 28) as f32);
        canvas.text(fonts, (&title, bold), at, Align::Left);
        for (column, head) in self.heads.iter().enumerate() {
            let middle = (left + column * pitch.0 + cell.0 / 2) as f32;
            let at = (middle, (top - 10) as f32);
            canvas.text(fonts, (head, ink), at, Align::Center);
        }
        for (index, row) in self.rows.iter().enumerate() {
            let y = top + index * pitch.1;
            let (label, fitted) = fonts.fitted(&row.label, ink, room);
            let at = (MARGIN as f32, (y + cell.1 / 2 + 8) as f32);
            canvas.text(fonts, (&label, fitted), at, Align::Left);
            for (column, (image, text)) in row.cells.iter().enumerate() {
                let corner = (left + column * pitch.0, y);
                match image {
                    Some(image) => canvas.put(&scaled(image, cell), corner),
                    None => canvas.fill(rect(corner, cell), ABSENT),
                }
                canvas.frame(rect(corner, cell), 1, RIM);
                let room = (pitch.0 - 2 * GAP) as f32;
                let (text, small) = fonts.fitted(text, Ink::black(18.0), room);
                let at = (
                    (corner.0 + cell.0 / 2) as f32,
                    (y + cell.1 + VALUES - 9) as f32,
                );
                canvas.text(fonts, (&text, small), at, Align::Center);
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
