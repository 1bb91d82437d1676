//! The index page of a suite: every claim of every experiment, with links to their reports.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::json;

use super::claims::{self, Claim};
use super::data::Data;
use super::{ReportError, escape, html};

const TEMPLATE: &str = include_str!("page/suite.html");

/// An experiment on the page.
#[derive(Serialize)]
struct Part {
    title: String,
    link: String,
    jobs: usize,
    finished: usize,
    time: String,
    claims: Vec<Claim>,
}

/// Writes `report.html` of a suite whose experiments lie in folders of these names.
///
/// # Errors
/// Folders without results, and pages that cannot be written.
pub fn write_suite(
    folder: &Path,
    title: &str,
    experiments: &[String],
) -> Result<PathBuf, ReportError> {
    let mut parts = Vec::new();
    for name in experiments {
        let data = Data::read(&folder.join(name))?;
        let seconds: f64 = data.cases.rows.iter().map(|r| r.seconds_total).sum();
        parts.push(Part {
            title: data.title().to_owned(),
            link: escape::link(&format!("{name}/report.html")),
            jobs: data.plan.jobs.len(),
            finished: data.cases.rows.iter().filter(|r| r.ok()).count(),
            time: match seconds < 100.0 {
                true => format!("{seconds:.0} s"),
                false => format!("{:.1} minutes", seconds / 60.0),
            },
            claims: claims::judge_all(&data),
        });
    }
    let count = |class: &str| {
        let all = parts.iter().flat_map(|p| &p.claims);
        all.filter(|c| !c.gate && c.class == class).count()
    };
    let page = json!({
        "title": title,
        "tally": {
            "holds": count("holds"), "fails": count("fails"), "open": count("open"),
            "other": count("none") + count("error"),
        },
        "parts": parts,
    });
    let file = folder.join("report.html");
    crate::files::write(
        &file,
        super::xml_text(&html::fill("suite.html", TEMPLATE, page)?).as_bytes(),
    )?;
    Ok(file)
}
