//! What the flip viewer shows of a sequence: the kept frames of every viewer and method, and animated previews.

use std::collections::HashMap;
use std::io;

use serde::Serialize;

use super::canvas::painted;
use super::data::{Data, SceneOf};
use super::escape;
use super::frame_table::FrameTable;
use super::number;
use super::pictures::Pictures;
use crate::experiment::{Row, Sequence};
use crate::image::{Image, Plane, Samples, luminance, read_layers, to_display, write_png_coded};

/// Of more images than this there are no FLIP and error maps.
const MAPPED: usize = 200;
/// Milliseconds that a frame is shown at least and at most while the viewer plays.
const SHOWN_MS: [f64; 2] = [80.0, 500.0];

/// The kept frames of a sequence.
#[derive(Clone, Debug, Serialize)]
pub struct Shots {
    /// What each kept frame is called.
    pub frames: Vec<String>,
    /// The same, as JSON.
    pub names: String,
    /// What each viewer is called.
    pub viewers: Vec<String>,
    /// Position of the frame that is shown first.
    pub start: usize,
    /// How long a frame is shown while the viewer plays.
    pub delay_ms: u32,
    /// Of each viewer, kept frame and image of the flip viewer, as JSON.
    pub cells: String,
}

/// One image of a frame; links are relative to the results folder.
#[derive(Clone, Debug, Default, Serialize)]
struct Cell {
    image: Option<String>,
    flip: Option<String>,
    error: Option<String>,
    values: String,
}

/// The animated previews of a viewer, by method.
#[derive(Clone, Debug, Serialize)]
pub struct Previews {
    pub viewer: String,
    /// Labels and links; no link where a job left none.
    pub methods: Vec<(String, Option<String>)>,
}

/// Where and how the images of a scene's viewer are written.
pub struct Frames<'a> {
    pub data: &'a Data,
    pub scene: &'a SceneOf,
    pub sequence: &'a Sequence,
    pub pictures: &'a [&'a Pictures<'a>],
    pub with_reference: bool,
    /// The error that the brightest colour of the error maps stands for.
    pub error_end: f32,
}

impl Frames<'_> {
    /// Writes references and maps of the kept frames; `None` where no method kept any. Jobs without a readable
    /// `frames.csv` show images without values, and become notes.
    pub fn write(&self, notes: &mut Vec<String>) -> io::Result<Option<Shots>> {
        let rows = self.pictures.iter().map(|p| p.row);
        let image = |row: &Row, frame: u32| self.file(row, (frame, 0), "png").is_some();
        let kept = |frame: &u32| rows.clone().any(|row| image(row, *frame));
        let kept: Vec<u32> = self.sequence.kept.iter().copied().filter(kept).collect();
        let (Some(first), Some(last)) = (kept.first(), kept.last()) else {
            return Ok(None);
        };
        let tables: Vec<FrameTable> = rows
            .map(|row| FrameTable::of(self.data, row).map_err(|reason| notes.push(reason)))
            .map(Result::unwrap_or_default)
            .collect();
        let viewers = self.sequence.viewer_names();
        let mapped = kept.len() * viewers.len() * self.pictures.len() <= MAPPED;
        if !mapped {
            let scene = &self.scene.name;
            notes.push(format!(
                "{scene}: more than {MAPPED} images are kept: the flip viewer has no maps of them"
            ));
        }
        let mut cells = Vec::new();
        for viewer in 0..viewers.len() {
            let of_viewer = kept
                .iter()
                .map(|frame| self.cells((*frame, viewer), &tables, mapped));
            cells.push(of_viewer.collect::<io::Result<Vec<_>>>()?);
        }
        let middle = self.sequence.representative();
        let start = (0..kept.len()).min_by_key(|at| kept[*at].abs_diff(middle));
        let span_s = self.sequence.time_s(*last) - self.sequence.time_s(*first);
        let delay_ms = 1000.0 * span_s / (kept.len() - 1).max(1) as f64;
        let named = |frame: &u32| format!("frame {frame} · {:.2} s", self.sequence.time_s(*frame));
        let frames: Vec<String> = kept.iter().map(named).collect();
        Ok(Some(Shots {
            names: serde_json::to_string(&frames)?,
            frames,
            viewers,
            start: start.unwrap_or(0),
            delay_ms: delay_ms.clamp(SHOWN_MS[0], SHOWN_MS[1]) as u32,
            cells: serde_json::to_string(&cells)?,
        }))
    }

    /// The reference and every method at a frame.
    fn cells(
        &self,
        (frame, viewer): (u32, usize),
        tables: &[FrameTable],
        mapped: bool,
    ) -> io::Result<Vec<Cell>> {
        let mut cells = Vec::new();
        if self.with_reference {
            let key = reference_key(tables, (frame, viewer));
            let reference = key.and_then(|key| self.data.references.mean(&key));
            let exposure = self.pictures.first().map_or(0.0, |p| p.exposure);
            let put = |image: Image| {
                let coded = to_display(&image, exposure);
                self.put(("_reference", frame, viewer), &coded)
            };
            cells.push(Cell {
                image: reference.map(put).transpose()?,
                ..Cell::default()
            });
        }
        for (pictures, table) in self.pictures.iter().zip(tables) {
            let row = pictures.row;
            let shot = (frame, viewer);
            let mut cell = Cell {
                image: self.file(row, shot, "png"),
                values: values(table, shot),
                ..Cell::default()
            };
            if mapped {
                (cell.flip, cell.error) = self.maps(row, shot)?;
            }
            cells.push(cell);
        }
        Ok(cells)
    }

    /// The link to a picture of a frame that a job kept.
    fn file(&self, row: &Row, (frame, viewer): (u32, usize), extension: &str) -> Option<String> {
        let file = frame_file(row, (frame, viewer), extension);
        let there = self.data.store.folder.join(&file).is_file();
        there.then(|| escape::link(&file))
    }

    /// FLIP map and error map of a frame.
    fn maps(&self, row: &Row, shot: (u32, usize)) -> io::Result<(Option<String>, Option<String>)> {
        let path = self.data.store.folder.join(frame_file(row, shot, "exr"));
        let Ok(file) = read_layers(&path) else {
            return Ok((None, None));
        };
        let mut maps = HashMap::new();
        for layer in file.layers {
            let (plane, end) = match (layer.name.as_str(), layer.samples) {
                ("flip", Samples::Gray(plane)) => (plane, 1.0),
                ("error", Samples::Color(image)) => (brightness(&image), self.error_end),
                _ => continue,
            };
            let name = format!("{}_{}", row.label, layer.name);
            let image = painted(&plane, end, (plane.width, plane.height));
            let link = self.put((&name, shot.0, shot.1), &image)?;
            maps.insert(layer.name, link);
        }
        Ok((maps.remove("flip"), maps.remove("error")))
    }

    fn put(&self, (name, frame, viewer): (&str, u32, usize), coded: &Image) -> io::Result<String> {
        let name = format!("{}-{name}-{frame:06}-{viewer}", self.scene.name);
        let file = format!("figures/viewer/{}.png", escape::file_name(&name));
        let path = self.data.store.folder.join(&file);
        write_png_coded(&path, coded).map_err(io::Error::other)?;
        Ok(escape::link(&file))
    }

    /// The animated previews that jobs left, for each viewer of which there is any.
    pub fn previews(&self) -> Vec<Previews> {
        let names = self.sequence.viewer_names().into_iter().enumerate();
        let of_viewer = |(viewer, name): (usize, String)| {
            let preview = |pictures: &&Pictures| {
                let row = pictures.row;
                let file = format!("jobs/{}/animation-{viewer}.png", row.job);
                let there = self.data.store.folder.join(&file).is_file();
                (row.label.clone(), there.then(|| escape::link(&file)))
            };
            let methods: Vec<_> = self.pictures.iter().map(preview).collect();
            let any = methods.iter().any(|(_, link)| link.is_some());
            any.then_some(Previews {
                viewer: name,
                methods,
            })
        };
        names.filter_map(of_viewer).collect()
    }
}

/// A picture of a frame and viewer that a job keeps, relative to the results folder.
pub fn frame_file(row: &Row, (frame, viewer): (u32, usize), extension: &str) -> String {
    format!("jobs/{}/frames/{frame:06}-{viewer}.{extension}", row.job)
}

/// The key of a frame's reference, which methods share.
pub fn reference_key(tables: &[FrameTable], (frame, viewer): (u32, usize)) -> Option<String> {
    let mut lines = tables.iter().filter_map(|table| table.find(frame, viewer));
    lines.find_map(|line| line.reference.clone())
}

/// `RMSE 0.0840 · FLIP 0.0245`; empty without a line of the frame.
pub fn values(table: &FrameTable, (frame, viewer): (u32, usize)) -> String {
    let Some(line) = table.find(frame, viewer) else {
        return String::new();
    };
    match ["rmse", "flip_ldr"].map(|column| table.number(line, column)) {
        [None, None] => "not measured".into(),
        [rmse, flip] => {
            let text = |value: Option<f64>| value.map_or_else(|| "—".into(), number::lone);
            format!("RMSE {} · FLIP {}", text(rmse), text(flip))
        }
    }
}

/// Absolute luminance.
fn brightness(error: &Image) -> Plane {
    Plane {
        width: error.width,
        height: error.height,
        values: error.pixels.iter().map(|p| luminance(*p).abs()).collect(),
    }
}
