//! The results folder: jobs written beside their place and renamed when complete.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::{Config, Plan, Row};

/// `results/<name>/`.
#[derive(Clone, Debug)]
pub struct Store {
    pub folder: PathBuf,
}

impl Store {
    /// Opens or creates the folder and removes what interrupted runs left unfinished.
    pub fn create(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder.join("jobs"))?;
        for entry in fs::read_dir(folder.join("jobs"))? {
            let entry = entry?;
            if entry
                .file_name()
                .to_string_lossy()
                .starts_with(".unfinished-")
            {
                fs::remove_dir_all(entry.path())?;
            }
        }
        Ok(Self {
            folder: folder.to_owned(),
        })
    }

    /// An existing folder, for reading.
    pub fn open(folder: &Path) -> io::Result<Self> {
        if !folder.join("plan.json").is_file() {
            return Err(io::Error::new(
                io::ErrorKind::NotFound,
                format!(
                    "{} holds no plan.json: expected a results folder written by `lightbench run`",
                    folder.display()
                ),
            ));
        }
        Ok(Self {
            folder: folder.to_owned(),
        })
    }

    pub fn job_folder(&self, id: &str) -> PathBuf {
        self.folder.join("jobs").join(id)
    }

    /// The row of a finished job.
    pub fn row(&self, id: &str) -> Option<Row> {
        let text = fs::read_to_string(self.job_folder(id).join("row.json")).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Writes a job through `fill`, which gets the unfinished folder, then puts it in place.
    pub fn write_job(
        &self,
        row: &Row,
        fill: impl FnOnce(&Path) -> io::Result<()>,
    ) -> io::Result<()> {
        let unfinished = self
            .folder
            .join("jobs")
            .join(format!(".unfinished-{}", row.job));
        if unfinished.exists() {
            fs::remove_dir_all(&unfinished)?;
        }
        fs::create_dir_all(&unfinished)?;
        fill(&unfinished)?;
        fs::write(
            unfinished.join("row.json"),
            serde_json::to_string_pretty(row)?,
        )?;
        let place = self.job_folder(&row.job);
        if place.exists() {
            fs::remove_dir_all(&place)?;
        }
        fs::rename(unfinished, place)
    }

    /// The frozen plan.
    pub fn plan(&self) -> io::Result<Plan> {
        let text = fs::read_to_string(self.folder.join("plan.json"))?;
        Ok(serde_json::from_str(&text)?)
    }

    /// The config that was run, overrides included.
    pub fn config(&self) -> io::Result<Config> {
        let text = fs::read_to_string(self.folder.join("config.json"))?;
        Ok(serde_json::from_str(&text)?)
    }

    /// Writes a file of the folder through a temporary name.
    pub fn write(&self, name: &str, contents: &str) -> io::Result<()> {
        let path = self.folder.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        let temporary = path.with_extension("unfinished");
        fs::write(&temporary, contents)?;
        fs::rename(temporary, path)
    }

    /// The rows of the plan's finished jobs, in the plan's order; a job that several labels share is
    /// repeated under each.
    pub fn rows(&self, plan: &Plan) -> Vec<Row> {
        plan.jobs
            .iter()
            .filter_map(|job| {
                let mut row = self.row(&job.id)?;
                row.describe(job, &plan.name);
                Some(row)
            })
            .collect()
    }

    /// Rewrites `rows.jsonl` and `rows.csv` from the finished jobs.
    pub fn write_rows(&self, rows: &[Row]) -> io::Result<()> {
        let mut lines = String::new();
        for row in rows {
            lines.push_str(&serde_json::to_string(row)?);
            lines.push('\n');
        }
        self.write("rows.jsonl", &lines)?;
        self.write("rows.csv", &super::row::to_csv(rows)?)
    }
}
