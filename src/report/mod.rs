//! Tables, figures and the HTML report: pure functions of rows and images.
//!
//! [`write()`] reads a results folder and never renders. Rows and images that are missing leave gaps
//! that are stated as such; only an unreadable folder is an error. Equal folders give equal bytes.

mod against_first;
mod axis;
mod canvas;
mod chart;
mod claims;
mod components;
mod contact_sheet;
mod curves;
mod data;
mod escape;
mod estimate;
mod figure;
mod font;
mod frame_table;
mod html;
mod inset;
mod job_lines;
mod lacking;
mod legend;
mod light_map;
mod look;
mod name;
mod number;
mod overlay;
mod paper;
mod pictures;
mod pixels;
mod plot;
mod published;
mod ranking;
mod ratio;
mod references;
mod sheet;
mod shots;
mod side_by_side;
mod stage_table;
mod suite;
mod summary;
mod table;
mod table_kinds;
mod table_text;
mod timeline;
mod timeline_plot;
mod title;
mod viewer;

use std::path::{Path, PathBuf};

use data::Data;
use pixels::Shelf;

use crate::experiment::{Plan, Row};

pub use escape::xml_text;
pub use light_map::draw_lights;
pub use suite::write_suite;

/// What a report consists of.
#[derive(Clone, Debug, Default)]
pub struct Written {
    /// Tables and claims as plain text, for the terminal.
    pub summary: String,
    /// Everything that was written, in order.
    pub files: Vec<PathBuf>,
}

/// A report that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// Rows or images cannot be read, or the report's files not be written.
    #[error("cannot read or write the report: {0}")]
    Io(#[from] std::io::Error),
}

/// Writes tables, figures and `report.html` of a results folder from its rows and images. The page shows
/// what lies beside it.
///
/// What cannot be drawn (an image is missing or damaged, a figure has nothing to show) is a note in
/// the report. Fails when `plan.json` or `config.json` cannot be read or a file cannot be written.
pub fn write(folder: &Path) -> Result<Written, ReportError> {
    write_all(folder, Data::read(folder)?, false)
}

/// Does what [`write()`] does of a plan and its rows that need not be read again.
///
/// # Errors
/// Those of [`write()`].
pub fn write_known(folder: &Path, plan: Plan, rows: Vec<Row>) -> Result<Written, ReportError> {
    write_all(folder, Data::of(folder, plan, rows)?, false)
}

/// Does what [`write()`] does, but the page holds all its pictures and can be sent alone.
///
/// # Errors
/// Those of [`write()`].
pub fn write_single_file(folder: &Path) -> Result<Written, ReportError> {
    write_all(folder, Data::read(folder)?, true)
}

fn write_all(folder: &Path, data: Data, single_file: bool) -> Result<Written, ReportError> {
    let tables = table_kinds::all(&data);
    let claims = claims::judge_all(&data);
    let mut files = Vec::new();
    for table in &tables {
        for (extension, text) in [
            ("csv", table_text::csv(table)?),
            ("md", table_text::markdown(table)),
            ("tex", table_text::latex(table)),
        ] {
            let name = format!("tables/{}.{extension}", table.file);
            data.store.write(&name, &text)?;
            files.push(folder.join(name));
        }
    }
    let mut shelf = Shelf::new(&data.store, single_file);
    let drawn = figure::draw_all(&data, &mut shelf)?;
    files.extend(
        drawn
            .figures
            .iter()
            .flat_map(|f| f.files.iter().map(|name| folder.join(name))),
    );
    let page = html::page(&data, &tables, &claims, &drawn, shelf)?;
    data.store.write("report.html", &xml_text(&page))?;
    files.push(folder.join("report.html"));
    Ok(Written {
        summary: summary::text(&data, &tables, &claims, &drawn.notes),
        files,
    })
}
