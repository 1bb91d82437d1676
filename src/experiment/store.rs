//! The results folder: jobs written beside their place and renamed when complete.

use std::collections::HashSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use super::lock::OwnFolder;
use super::{Config, Job, Plan, ReferenceStore, Row};
use crate::files::at;

/// `results/<name>/`.
#[derive(Clone, Debug)]
pub struct Store {
    /// Holds the plan, rows, jobs, tables and figures.
    pub folder: PathBuf,
    /// Keeps other programs from writing into the folder while this one does.
    _own: Option<Arc<OwnFolder>>,
}

/// A file of a folder without results that has the name of one of ours.
fn foreign_file(folder: &Path) -> Option<&'static str> {
    let has_results = folder.join("jobs").is_dir() || Store::at(folder).plan().is_ok();
    let names = [
        "config.json",
        "plan.json",
        "provenance.json",
        "rows.csv",
        "rows.jsonl",
        "report.html",
    ];
    let is_there = |name: &&str| folder.join(name).exists();
    names
        .into_iter()
        .find(|name| !has_results && is_there(name))
}

impl Store {
    /// Opens or creates the folder for writing and removes what interrupted runs left unfinished.
    ///
    /// # Errors
    /// The folder cannot be made, is that of the references, holds files of others that would be replaced, or another
    /// program writes into it.
    pub fn create(folder: &Path) -> io::Result<Self> {
        if ReferenceStore::beside(folder).folder == folder {
            let message = format!(
                "{} is the folder of the references of all experiments beside it; choose another one with --out",
                folder.display()
            );
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        let jobs = folder.join("jobs");
        if let Some(file) = foreign_file(folder) {
            let message = format!(
                "{} holds a `{file}` and no results: it would be replaced; choose another folder with --out",
                folder.display()
            );
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        fs::create_dir_all(&jobs).map_err(at(&jobs))?;
        let own = OwnFolder::take(folder)?;
        for entry in fs::read_dir(&jobs).map_err(at(&jobs))? {
            let entry = entry.map_err(at(&jobs))?;
            if entry
                .file_name()
                .to_string_lossy()
                .starts_with(".unfinished-")
            {
                fs::remove_dir_all(entry.path()).map_err(at(&entry.path()))?;
            }
        }
        Ok(Self {
            folder: folder.to_owned(),
            _own: Some(Arc::new(own)),
        })
    }

    /// A folder that may be there, for reading.
    pub fn at(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            _own: None,
        }
    }

    /// An existing folder, for reading.
    pub fn open(folder: &Path) -> io::Result<Self> {
        if !folder.join("plan.json").is_file() {
            return Err(io::Error::new(
                io::ErrorKind::NotFound,
                format!(
                    "{} holds no plan.json: expected a results folder written by `lightbench run`, or its name \
                     below results/",
                    folder.display()
                ),
            ));
        }
        Ok(Self::at(folder))
    }

    /// Where the images and frames of a job lie: `jobs/<id>`.
    pub fn job_folder(&self, id: &str) -> PathBuf {
        self.folder.join("jobs").join(id)
    }

    /// The row of a finished job.
    pub fn row(&self, id: &str) -> Option<Row> {
        let text = fs::read_to_string(self.job_folder(id).join("row.json")).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Keys of the references that a finished job was measured against.
    pub fn references_of(&self, id: &str) -> Vec<String> {
        let frames = self.job_folder(id).join("frames.csv");
        let Ok(mut lines) = csv::Reader::from_path(&frames) else {
            let row = self.row(id);
            return row.map(|row| row.reference).into_iter().collect();
        };
        let headers = lines.headers().cloned().unwrap_or_default();
        let column = headers.iter().position(|name| name == "reference");
        let lines = lines.records().flatten();
        let keys = lines.filter_map(|line| line.get(column?).map(str::to_owned));
        keys.filter(|key| !key.is_empty()).collect()
    }

    /// The folder in which a job's files are put until it is complete. What an interrupted run left there stays, for
    /// the job to go on.
    pub fn begin(&self, id: &str) -> io::Result<PathBuf> {
        let begun = self.folder.join("jobs").join(format!(".begun-{id}"));
        fs::create_dir_all(&begun).map_err(at(&begun))?;
        Ok(begun)
    }

    /// Completes the folder of a job, through `fill`, and puts it in place. Of a job that failed only its row is
    /// kept.
    pub fn write_job(
        &self,
        row: &Row,
        fill: impl FnOnce(&Path) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut begun = self.begin(&row.job)?;
        if !row.ok() {
            fs::remove_dir_all(&begun).map_err(at(&begun))?;
            begun = self.begin(&row.job)?;
        }
        fill(&begun)?;
        let row_file = begun.join("row.json");
        fs::write(&row_file, serde_json::to_string_pretty(row)?).map_err(at(&row_file))?;
        self.place(&begun, &row.job)
    }

    fn place(&self, folder: &Path, id: &str) -> io::Result<()> {
        let place = self.job_folder(id);
        if place.exists() {
            fs::remove_dir_all(&place).map_err(at(&place))?;
        }
        fs::rename(folder, &place).map_err(at(&place))
    }

    /// Puts a job of another folder into its place here. Files of finished jobs are replaced and never changed, so both
    /// folders share them where the file system has hard links; elsewhere they are copied.
    pub fn adopt(&self, other: &Store, id: &str) -> io::Result<()> {
        self.put(id, |unfinished| {
            share_all(&other.job_folder(id), unfinished)
        })
    }

    /// Puts a job in its place once `fill` has completed its folder.
    fn put(&self, id: &str, fill: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
        let unfinished = self.folder.join("jobs").join(format!(".unfinished-{id}"));
        if unfinished.exists() {
            fs::remove_dir_all(&unfinished).map_err(at(&unfinished))?;
        }
        fs::create_dir_all(&unfinished).map_err(at(&unfinished))?;
        fill(&unfinished)?;
        self.place(&unfinished, id)
    }

    /// A plan with those jobs of the folder's own plan that its configs still have, though they are
    /// not selected now; and how many jobs of the folder's plan they no longer have.
    pub fn united(&self, plan: &Plan) -> (Plan, usize) {
        let mut united = plan.clone();
        united.selected_of = plan.sharded.is_none().then_some(plan.all.len());
        let Ok(earlier) = self.plan() else {
            return (united, 0);
        };
        let wanted: HashSet<_> = plan
            .jobs
            .iter()
            .chain(&earlier.jobs)
            .map(Job::place)
            .collect();
        let all = plan.all.iter().filter(|job| wanted.contains(&job.place()));
        united.jobs = all.cloned().collect();
        united.sharded = plan
            .sharded
            .max(earlier.sharded.filter(|_| plan.sharded.is_some()));
        let kept: HashSet<_> = united.jobs.iter().map(Job::place).collect();
        let gone = earlier
            .jobs
            .iter()
            .filter(|job| !kept.contains(&job.place()))
            .count();
        (united, gone)
    }

    /// The frozen plan.
    ///
    /// # Errors
    /// A file that cannot be read or is damaged, with what to do.
    pub fn plan(&self) -> io::Result<Plan> {
        self.read("plan.json")
    }

    /// The config that was run, overrides included.
    ///
    /// # Errors
    /// A file that cannot be read or is damaged, with what to do.
    pub fn config(&self) -> io::Result<Config> {
        self.read("config.json")
    }

    /// The same as text, as it is in its file.
    ///
    /// # Errors
    /// As [`Store::config`].
    pub fn config_text(&self) -> io::Result<String> {
        let file = self.folder.join("config.json");
        let text = fs::read_to_string(&file).map_err(at(&file))?;
        parsed::<Config>(&file, &text)?;
        Ok(text)
    }

    fn read<T: serde::de::DeserializeOwned>(&self, name: &str) -> io::Result<T> {
        let file = self.folder.join(name);
        let text = fs::read_to_string(&file).map_err(at(&file))?;
        parsed(&file, &text)
    }

    /// Writes a file of the folder, whole or not at all.
    pub fn write(&self, name: &str, contents: &str) -> io::Result<()> {
        crate::files::write(&self.folder.join(name), contents)
    }

    /// The rows of the plan's finished jobs, in the plan's order; a job that several labels share is
    /// repeated under each.
    pub fn rows(&self, plan: &Plan) -> Vec<Row> {
        described(plan, |id| self.row(id))
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

/// Rows of the plan's jobs in the plan's order, of those that `row` has, under the names of the plan.
pub fn described(plan: &Plan, row: impl Fn(&str) -> Option<Row> + Sync) -> Vec<Row> {
    let named = |job: &Job| {
        let mut row = row(&job.id)?;
        row.describe(job, &plan.name);
        Some(row)
    };
    plan.jobs.par_iter().filter_map(named).collect()
}

/// What a file of a results folder says.
fn parsed<T: serde::de::DeserializeOwned>(file: &Path, text: &str) -> io::Result<T> {
    serde_json::from_str(text).map_err(|error| {
        let message = format!(
            "{}: damaged, or of another version ({error}); run the config again into this folder, which writes it anew \
             and keeps finished jobs",
            file.display()
        );
        io::Error::new(io::ErrorKind::InvalidData, message)
    })
}

/// Copies what a folder holds, the folders in it included, into another one.
fn share_all(from: &Path, to: &Path) -> io::Result<()> {
    for entry in fs::read_dir(from).map_err(at(from))? {
        let entry = entry.map_err(at(from))?;
        let (theirs, ours) = (entry.path(), to.join(entry.file_name()));
        if entry.file_type().map_err(at(&theirs))?.is_dir() {
            fs::create_dir(&ours).map_err(at(&ours))?;
            share_all(&theirs, &ours)?;
        } else if fs::hard_link(&theirs, &ours).is_err() {
            fs::copy(&theirs, &ours).map_err(at(&theirs))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_is_adopted_with_the_folders_in_it() {
        let place = tempfile::tempdir().expect("a folder");
        let there = Store::create(&place.path().join("a")).expect("a store");
        let frames = there.job_folder("x").join("frames");
        fs::create_dir_all(&frames).expect("writable");
        fs::write(frames.join("000001-0.png"), "frame").expect("writable");
        fs::write(there.job_folder("x").join("row.json"), "row").expect("writable");
        let here = Store::create(&place.path().join("b")).expect("a store");
        here.adopt(&there, "x").expect("adopts");
        let read = |name: &str| fs::read_to_string(here.job_folder("x").join(name)).ok();
        assert_eq!(read("frames/000001-0.png").as_deref(), Some("frame"));
        assert_eq!(read("row.json").as_deref(), Some("row"));
    }

    #[test]
    fn the_folder_of_references_is_no_results_folder() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = place.path().join("references");
        let error = Store::create(&folder).expect_err("refused").to_string();
        assert!(error.contains("--out"), "{error}");
        assert!(!folder.exists());
    }
}
