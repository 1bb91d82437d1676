//! The frames of a job, as its `frames.csv` tells them.

use std::path::Path;

use super::data::Data;
use crate::experiment::Row;

/// The lines of a `frames.csv`.
#[derive(Clone, Debug, Default)]
pub struct FrameTable {
    columns: Vec<String>,
    /// Frame by frame, each viewer by viewer.
    pub lines: Vec<FrameLine>,
}

/// One frame as one viewer saw it.
#[derive(Clone, Debug)]
pub struct FrameLine {
    pub frame: u32,
    pub viewer: u16,
    /// Key of the reference image; `None` where the frame is not measured.
    pub reference: Option<String>,
    /// By column; NaN where a cell holds no number.
    numbers: Vec<f64>,
}

/// A frame of a sequence as one of its viewers sees it.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    pub frame: u32,
    pub viewer: usize,
}

impl FrameTable {
    /// The frames of a finished job; why there are none where the file is missing or damaged.
    pub fn of(data: &Data, row: &Row) -> Result<Self, String> {
        let path = data.store.job_folder(&row.job).join("frames.csv");
        Self::read(&path).map_err(|reason| {
            let name = data.cases.name_of(row);
            let seed = row.seed;
            format!("{name} {} seed {seed}: frames.csv: {reason}", row.label)
        })
    }

    fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|e| e.to_string())?;
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers().map_err(|e| e.to_string())?;
        let mut table = Self {
            columns: header.iter().map(str::to_owned).collect(),
            lines: Vec::new(),
        };
        for record in reader.records() {
            let record = record.map_err(|e| e.to_string())?;
            let line = table.line(&record);
            let number = table.lines.len() + 2;
            let line = line.ok_or_else(|| format!("line {number} names no frame"))?;
            table.lines.push(line);
        }
        Ok(table)
    }

    fn line(&self, record: &csv::StringRecord) -> Option<FrameLine> {
        let cell = |key: &str| record.get(self.column(key)?);
        let reference = cell("reference").filter(|key| !key.is_empty());
        Some(FrameLine {
            frame: cell("frame")?.parse().ok()?,
            viewer: cell("viewer")?.parse().ok()?,
            reference: reference.map(str::to_owned),
            numbers: record
                .iter()
                .map(|cell| cell.parse().unwrap_or(f64::NAN))
                .collect(),
        })
    }

    fn column(&self, key: &str) -> Option<usize> {
        let key = match key {
            "flip" => "flip_ldr",
            _ => key,
        };
        self.columns.iter().position(|column| column == key)
    }

    /// A number of a line; `None` where it is missing or not finite.
    pub fn number(&self, line: &FrameLine, key: &str) -> Option<f64> {
        if key == "all_rays" {
            return Some(self.number(line, "rays")? + self.number(line, "shadow_rays")?);
        }
        let value = line.numbers.get(self.column(key)?);
        value.copied().filter(|value| value.is_finite())
    }

    /// The line of a frame and viewer.
    pub fn find(&self, seen: Seen) -> Option<&FrameLine> {
        let Seen { frame, viewer } = seen;
        let here = |line: &&FrameLine| line.frame == frame && usize::from(line.viewer) == viewer;
        self.lines.iter().find(here)
    }
}
