//! A table as data: what CSV, Markdown, LaTeX, HTML and the terminal all show.

use serde::Serialize;

use super::estimate::{Estimate, Standing};

/// A finished table: numbers are text already, all of one quantity with the same decimals.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Table {
    /// File name without its extension.
    pub file: String,
    pub title: String,
    /// Heading of the first column.
    pub corner: String,
    pub groups: Vec<Group>,
    pub blocks: Vec<Block>,
    /// How to read it, and what it lacks; a sentence each.
    pub notes: Vec<String>,
    /// The same numbers in full, one a line.
    #[serde(skip)]
    pub records: Vec<Record>,
}

/// Neighbouring columns under one heading.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Group {
    pub heading: String,
    pub columns: Vec<String>,
}

/// Lines under one heading, which is empty when there is only one block.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Block {
    pub heading: String,
    pub lines: Vec<Line>,
}

/// One line; `cells` run over the columns of all groups.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Line {
    pub heading: String,
    pub cells: Vec<Cell>,
}

/// One number, `—` where there is none.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Cell {
    pub text: String,
    pub standing: Standing,
    /// The paper's number, not ours.
    pub published: bool,
}

/// One number in full with everything that it belongs to.
#[derive(Clone, Debug)]
pub struct Record {
    pub scene: String,
    pub paper_scene: Option<String>,
    pub sweep: String,
    pub method: String,
    pub metric: String,
    pub estimate: Option<Estimate>,
    pub published: Option<f64>,
    pub standing: Standing,
}

/// What stands where there is no number.
pub const NOTHING: &str = "—";

impl Cell {
    pub fn empty() -> Self {
        Self {
            text: NOTHING.into(),
            ..Self::default()
        }
    }
}

impl Table {
    /// The table split at group borders so that no part has more than `columns` columns of numbers,
    /// unless a single group has.
    pub fn parts(&self, columns: usize) -> Vec<Table> {
        if self.groups.is_empty() {
            return vec![self.clone()];
        }
        let mut parts: Vec<Table> = Vec::new();
        let mut first = 0;
        for group in &self.groups {
            let last = first + group.columns.len();
            let fits = parts
                .last()
                .is_some_and(|p| p.width() + group.columns.len() <= columns);
            if !fits {
                let mut part = Table {
                    groups: Vec::new(),
                    records: Vec::new(),
                    ..self.clone()
                };
                for line in part.blocks.iter_mut().flat_map(|b| &mut b.lines) {
                    line.cells.clear();
                }
                parts.push(part);
            }
            if let Some(part) = parts.last_mut() {
                part.groups.push(group.clone());
                let lines = part.blocks.iter_mut().flat_map(|b| &mut b.lines);
                let whole = self.blocks.iter().flat_map(|b| &b.lines);
                for (line, all) in lines.zip(whole) {
                    line.cells.extend_from_slice(&all.cells[first..last]);
                }
            }
            first = last;
        }
        parts
    }

    /// Number of columns of numbers.
    pub fn width(&self) -> usize {
        self.groups.iter().map(|g| g.columns.len()).sum()
    }
}
