//! The cases of an experiment with the rows that are there: what tables, figures, claims and gates
//! ask.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::case::{Case, NamedPlace, Place, Swept, name_places, place_named};
use super::{Job, Row};

/// Rows by case, beside what is expected: a case of the plan without a finished row has no data, it is
/// not left out.
#[derive(Clone, Debug, Default)]
pub struct Cases {
    /// All that there are, failed ones included.
    pub rows: Vec<Row>,
    /// In the order of the plan.
    pub places: Vec<NamedPlace>,
    /// In the order of the plan.
    pub labels: Vec<String>,
    /// Combinations of swept values, in the order of the plan; one empty one without a sweep.
    pub points: Vec<Swept>,
    technique: String,
    /// For each seed that is expected the index of its row, if it finished.
    runs: HashMap<Case, BTreeMap<u64, Option<usize>>>,
}

/// A text that rows carry in their notes, and the runs that it belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowNote {
    /// A sentence.
    pub text: String,
    /// Scene and label of each run, once.
    pub runs: Vec<String>,
}

impl Cases {
    /// The cases of jobs, whether they have rows or not, and those of rows.
    pub fn new(jobs: &[Job], rows: Vec<Row>) -> Self {
        let all_of = |job| Case::all_of_job(job).map(move |case| (case, job.seed, &job.paper));
        let of_jobs = jobs.iter().flat_map(all_of);
        let of_rows = rows.iter().map(|r| (Case::of_row(r), r.seed, &r.paper));
        let expected: Vec<(Case, u64, &Option<String>)> = of_jobs.chain(of_rows).collect();
        let places = expected
            .iter()
            .map(|(c, _, p)| (c.place.clone(), (*p).clone()));
        let mut cases = Self {
            places: name_places(places),
            technique: expected
                .first()
                .map_or_else(String::new, |(case, ..)| case.technique.clone()),
            ..Self::default()
        };
        let (mut labels, mut points) = (HashSet::new(), HashSet::new());
        for (case, seed, _) in expected {
            if labels.insert(case.label.clone()) {
                cases.labels.push(case.label.clone());
            }
            if points.insert(case.swept.clone()) {
                cases.points.push(case.swept.clone());
            }
            cases.runs.entry(case).or_default().insert(seed, None);
        }
        if cases.points.is_empty() {
            cases.points.push(Swept::default());
        }
        let several = jobs.iter().filter(|job| !job.also_at.is_empty());
        let cases_of: HashMap<Case, &Job> = several.map(|job| (Case::of_job(job), job)).collect();
        for (index, row) in rows.iter().enumerate().filter(|(_, row)| row.ok()) {
            let own = Case::of_row(row);
            let others = cases_of.get(&own).into_iter();
            let others = others.flat_map(|job| Case::all_of_job(job).skip(1));
            for case in std::iter::once(own.clone()).chain(others) {
                let of_case = cases.runs.entry(case).or_default();
                of_case.entry(row.seed).or_default().get_or_insert(index);
            }
        }
        cases.rows = rows;
        cases
    }

    /// A contender at a place and a swept value.
    pub fn case(&self, place: &Place, label: &str, swept: &Swept) -> Case {
        Case {
            place: place.clone(),
            technique: self.technique.clone(),
            label: label.to_owned(),
            swept: swept.clone(),
        }
    }

    /// Whether any contender was to run at a place and a swept value.
    pub fn expects(&self, place: &Place, swept: &Swept) -> bool {
        let known = |label: &String| self.runs.contains_key(&self.case(place, label, swept));
        self.labels.iter().any(known)
    }

    /// The place that `LABEL@name` speaks of.
    pub fn place(&self, name: &str) -> Option<&NamedPlace> {
        place_named(&self.places, name)
    }

    /// What the place of a row is called.
    pub fn name_of(&self, row: &Row) -> String {
        let place = Case::of_row(row).place;
        let named = self.places.iter().find(|named| named.place == place);
        named.map_or(place.scene, |named| named.name.clone())
    }

    /// Finished rows of a case by their seeds.
    pub fn rows_of(&self, case: &Case) -> impl Iterator<Item = &Row> {
        let seeds = self.runs.get(case).into_iter().flatten();
        seeds.filter_map(|(_, index)| Some(&self.rows[(*index)?]))
    }

    /// Seeds that are expected of a case, whether they finished or not.
    pub fn seeds_of(&self, case: &Case) -> impl Iterator<Item = u64> {
        let seeds = self.runs.get(case).into_iter().flatten();
        seeds.map(|(seed, _)| *seed)
    }

    /// A column of a finished row; `None` where it is missing or not finite.
    pub fn value(&self, case: &Case, seed: u64, column: &str) -> Option<f64> {
        let index = (*self.runs.get(case)?.get(&seed)?)?;
        self.rows[index].number(column).filter(|v| v.is_finite())
    }

    /// Jobs without a row.
    pub fn missing<'a>(&self, jobs: &'a [Job]) -> Vec<&'a Job> {
        let there: HashSet<&str> = self.rows.iter().map(|r| r.job.as_str()).collect();
        let missing = |job: &&Job| !there.contains(job.id.as_str());
        jobs.iter().filter(missing).collect()
    }

    /// Rows of jobs that failed.
    pub fn failed(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| !row.ok())
    }

    /// The failed jobs with their reasons, a line each: `kitchen VGC seed 2: failed: …`.
    pub fn failures(&self) -> Vec<String> {
        let line = |row: &Row| {
            let budget = match self.points.len() > 1 {
                true => format!(" {}", row.budget),
                false => String::new(),
            };
            let (scene, label) = (self.name_of(row), &row.label);
            format!("{scene} {label}{budget} seed {}: {}", row.seed, row.status)
        };
        self.failed().map(line).collect()
    }

    /// What rows say was left out, replaced or fell short.
    pub fn notes(&self) -> Vec<RowNote> {
        let mut notes: Vec<RowNote> = Vec::new();
        let mut places: HashMap<&str, usize> = HashMap::new();
        let mut seen: HashSet<(usize, String)> = HashSet::new();
        for row in self.rows.iter().filter(|row| !row.notes.is_empty()) {
            let run = format!("{} {}", self.name_of(row), row.label);
            for text in &row.notes {
                let index = *places.entry(text).or_insert_with(|| {
                    notes.push(RowNote {
                        text: text.clone(),
                        runs: Vec::new(),
                    });
                    notes.len() - 1
                });
                if seen.insert((index, run.clone())) {
                    notes[index].runs.push(run.clone());
                }
            }
        }
        notes
    }
}
