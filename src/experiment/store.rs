//! The results folder: jobs written beside their place and renamed when complete.

use std::collections::HashSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::lock::OwnFolder;
use super::{Config, Job, Plan, Row};
use crate::files::at;

/// `results/<name>/`.
#[derive(Clone, Debug)]
pub struct Store {
    pub folder: PathBuf,
    /// Keeps other programs from writing into the folder while this one does.
    _own: Option<Arc<OwnFolder>>,
}

impl Store {
    /// Opens or creates the folder for writing and removes what interrupted runs left unfinished.
    ///
    /// # Errors
    /// The folder cannot be made, or another program writes into it.
    pub fn create(folder: &Path) -> io::Result<Self> {
        let jobs = folder.join("jobs");
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

    /// Copies a job of another folder into its place here.
    pub fn adopt(&self, other: &Store, id: &str) -> io::Result<()> {
        self.put(id, |unfinished| {
            let theirs = other.job_folder(id);
            for entry in fs::read_dir(&theirs).map_err(at(&theirs))? {
                let entry = entry.map_err(at(&theirs))?;
                let file = entry.path();
                fs::copy(&file, unfinished.join(entry.file_name())).map_err(at(&file))?;
            }
            Ok(())
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
        let kept: HashSet<_> = united.jobs.iter().map(Job::place).collect();
        let gone = earlier
            .jobs
            .iter()
            .filter(|job| !kept.contains(&job.place()));
        (united, gone.count())
    }

    /// The frozen plan.
    pub fn plan(&self) -> io::Result<Plan> {
        self.read("plan.json")
    }

    /// The config that was run, overrides included.
    pub fn config(&self) -> io::Result<Config> {
        self.read("config.json")
    }

    fn read<T: serde::de::DeserializeOwned>(&self, name: &str) -> io::Result<T> {
        let file = self.folder.join(name);
        let text = fs::read_to_string(&file).map_err(at(&file))?;
        serde_json::from_str(&text).map_err(|error| at(&file)(error.into()))
    }

    /// Writes a file of the folder, whole or not at all.
    pub fn write(&self, name: &str, contents: &str) -> io::Result<()> {
        crate::files::write(&self.folder.join(name), contents)
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
