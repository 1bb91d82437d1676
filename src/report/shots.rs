//! What the viewer shows of a sequence: the kept frames of every viewer and method, and animated previews.

use std::io;

use serde::Serialize;

use super::data::{Data, SceneOf};
use super::frame_table::{FrameTable, Seen};
use super::number;
use super::pictures::Pictures;
use super::pixels::Shelf;
use super::viewer::{Album, Cell, any};
use crate::experiment::{Row, Sequence};
use crate::image::{Samples, read_layers};

/// Of more images than this there are pictures of eight bits only.
const MAPPED: usize = 200;
/// Milliseconds that a frame is shown at least and at most while the viewer plays.
const SHOWN_MS: [f64; 2] = [80.0, 500.0];

/// The animated previews of a viewer, by method.
#[derive(Clone, Debug, Serialize)]
pub struct Previews {
    pub viewer: String,
    /// Labels and files, relative to the results folder; none where a job left none.
    pub methods: Vec<(String, Option<String>)>,
}

/// Where and how the images of a scene's viewer are written.
pub struct Frames<'a> {
    pub data: &'a Data,
    pub scene: &'a SceneOf,
    pub sequence: &'a Sequence,
    pub pictures: &'a [&'a Pictures<'a>],
    pub with_reference: bool,
}

impl Frames<'_> {
    /// Adds the kept frames to an album; false where no method kept any. Jobs without a readable `frames.csv` show
    /// images without values, and become notes.
    pub fn write(
        &self,
        album: &mut Album,
        shelf: &mut Shelf,
        notes: &mut Vec<String>,
    ) -> io::Result<bool> {
        let rows = self.pictures.iter().map(|p| p.row);
        let kept = |&frame: &u32| {
            let seen = Seen { frame, viewer: 0 };
            rows.clone()
                .any(|row| self.file(row, seen, "png").is_some())
        };
        let kept: Vec<u32> = self.sequence.kept.iter().copied().filter(kept).collect();
        let (Some(first), Some(last)) = (kept.first(), kept.last()) else {
            return Ok(false);
        };
        let tables: Vec<FrameTable> = rows
            .map(|row| FrameTable::of(self.data, row).map_err(|reason| notes.push(reason)))
            .map(Result::unwrap_or_default)
            .collect();
        album.viewers = self.sequence.viewer_names();
        let mapped = kept.len() * album.viewers.len() * self.pictures.len() <= MAPPED;
        if !mapped {
            let scene = &self.scene.name;
            notes.push(format!(
                "{scene}: more than {MAPPED} images are kept: the viewer has pictures of eight bits, at one exposure and without maps"
            ));
        }
        for viewer in 0..album.viewers.len() {
            let mut of_viewer = Vec::new();
            for &frame in &kept {
                of_viewer.push(self.cells(Seen { frame, viewer }, &tables, mapped, shelf)?);
            }
            album.cells.push(of_viewer);
        }
        let middle = self.sequence.representative();
        let start = (0..kept.len()).min_by_key(|at| kept[*at].abs_diff(middle));
        let span_s = self.sequence.time_s(*last) - self.sequence.time_s(*first);
        let delay_ms = 1000.0 * span_s / (kept.len() - 1).max(1) as f64;
        let named = |frame: &u32| format!("frame {frame} · {:.2} s", self.sequence.time_s(*frame));
        album.frames = kept.iter().map(named).collect();
        album.start = start.unwrap_or(0);
        album.delay_ms = delay_ms.clamp(SHOWN_MS[0], SHOWN_MS[1]) as u32;
        Ok(true)
    }

    /// The reference and every method at a frame.
    fn cells(
        &self,
        seen: Seen,
        tables: &[FrameTable],
        mapped: bool,
        shelf: &mut Shelf,
    ) -> io::Result<Vec<Cell>> {
        let mut cells = Vec::new();
        if self.with_reference {
            let key = reference_key(tables, seen);
            let reference = key.and_then(|key| self.data.references.mean(&key));
            let name = self.name("_reference", seen);
            let image = reference.map(|image| shelf.picture(&name, &image));
            cells.push(Cell {
                image: image.transpose()?,
                ..Cell::default()
            });
        }
        for (pictures, table) in self.pictures.iter().zip(tables) {
            let row = pictures.row;
            let mut cell = match mapped {
                true => self.pixels(row, seen, shelf)?,
                false => Cell::default(),
            };
            if cell.image.is_none() {
                cell.picture = self
                    .file(row, seen, "png")
                    .map(|file| shelf.sources().of(&file));
            }
            cell.values = values(table, seen);
            cells.push(cell);
        }
        Ok(cells)
    }

    /// A picture of a frame that a job kept.
    fn file(&self, row: &Row, seen: Seen, extension: &str) -> Option<String> {
        let file = frame_file(row, seen, extension);
        let there = self.data.store.folder.join(&file).is_file();
        there.then_some(file)
    }

    /// Picture and maps of a frame; nothing where the job left no readable file of them.
    fn pixels(&self, row: &Row, seen: Seen, shelf: &mut Shelf) -> io::Result<Cell> {
        let path = self.data.store.folder.join(frame_file(row, seen, "exr"));
        let mut cell = Cell::default();
        let Ok(file) = read_layers(&path) else {
            return Ok(cell);
        };
        for layer in file.layers {
            let name = |what: &str| self.name(&format!("{}_{what}", row.label), seen);
            match (layer.name.as_str(), layer.samples) {
                ("", Samples::Color(image)) => {
                    cell.image = Some(shelf.picture(&name("image"), &image)?);
                }
                ("flip", Samples::Gray(plane)) => {
                    cell.flip = Some(shelf.map(&name("flip"), &plane)?);
                }
                ("records", Samples::Gray(plane)) => {
                    if let Some(plane) = any(&Some(plane)) {
                        cell.records = Some(shelf.map(&name("records"), &plane)?);
                    }
                }
                ("cells", Samples::Gray(plane)) => {
                    if let Some(plane) = any(&Some(plane)) {
                        cell.cells = Some(shelf.map(&name("cells"), &plane)?);
                    }
                }
                _ => {}
            }
        }
        Ok(cell)
    }

    fn name(&self, what: &str, seen: Seen) -> String {
        let Seen { frame, viewer } = seen;
        format!("{}-{what}-{frame:06}-{viewer}", self.scene.name)
    }

    /// The animated previews that jobs left, for each viewer of which there is any.
    pub fn previews(&self) -> Vec<Previews> {
        let names = self.sequence.viewer_names().into_iter().enumerate();
        let of_viewer = |(viewer, name): (usize, String)| {
            let preview = |pictures: &&Pictures| {
                let row = pictures.row;
                let file = format!("jobs/{}/animation-{viewer}.png", row.job);
                let there = self.data.store.folder.join(&file).is_file();
                (row.label.clone(), there.then_some(file))
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
pub fn frame_file(row: &Row, seen: Seen, extension: &str) -> String {
    let Seen { frame, viewer } = seen;
    format!("jobs/{}/frames/{frame:06}-{viewer}.{extension}", row.job)
}

/// The key of a frame's reference, which methods share.
pub fn reference_key(tables: &[FrameTable], seen: Seen) -> Option<String> {
    let mut lines = tables.iter().filter_map(|table| table.find(seen));
    lines.find_map(|line| line.reference.clone())
}

/// `RMSE 0.0840 · FLIP 0.0245`; empty without a line of the frame.
pub fn values(table: &FrameTable, seen: Seen) -> String {
    let Some(line) = table.find(seen) else {
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
