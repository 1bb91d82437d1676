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
    /// Of an interval that is not even: its ends.
    pub ends: Option<[f64; 2]>,
    /// Of a ratio of curves: how many budgets of the first method it rests on.
    pub budgets: Option<usize>,
    pub published: Option<f64>,
    pub standing: Standing,
}

/// Room between columns.
const LETTERS_BETWEEN: usize = 2;

/// What stands where there is no number.
pub const NOTHING: &str = "—";

impl Record {
    /// The ends of its 95 % interval, if it has one.
    pub fn interval(&self) -> Option<[f64; 2]> {
        let even = || {
            let estimate = self.estimate.as_ref()?;
            let half = estimate.half_width?;
            Some([estimate.mean - half, estimate.mean + half])
        };
        self.ends.or_else(even)
    }
}

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
        self.split(columns, |group, _| group.columns.len())
    }

    /// The table split at group borders so that no part has more letters side by side, unless a single group has.
    pub fn parts_within(&self, letters: usize) -> Vec<Table> {
        let lines = || self.blocks.iter().flat_map(|block| &block.lines);
        let length = |text: &str| text.chars().count();
        let names = lines().map(|line| length(&line.heading));
        let names = names.chain([length(&self.corner)]).max().unwrap_or(0);
        let column = |heading: &str, at: usize| {
            let cells = lines().filter_map(|line| line.cells.get(at));
            let widest = cells.map(|cell| length(&cell.text)).max().unwrap_or(0);
            widest.max(length(heading)) + LETTERS_BETWEEN
        };
        let room = letters.saturating_sub(names + LETTERS_BETWEEN);
        self.split(room, |group, first| {
            let columns = group.columns.iter().enumerate();
            let columns: usize = columns.map(|(i, heading)| column(heading, first + i)).sum();
            columns.max(length(&group.heading) + LETTERS_BETWEEN)
        })
    }

    /// The table split at group borders so that no part is larger than `most`, unless a single group is; `size` is
    /// that of a group, whose first column is given.
    fn split(&self, most: usize, size: impl Fn(&Group, usize) -> usize) -> Vec<Table> {
        if self.groups.is_empty() {
            return vec![self.clone()];
        }
        let mut parts: Vec<Table> = Vec::new();
        let (mut first, mut used) = (0, 0);
        for group in &self.groups {
            let last = first + group.columns.len();
            let own = size(group, first);
            used += own;
            if parts.is_empty() || used > most {
                used = own;
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

#[cfg(test)]
mod tests {
    use super::*;

    fn table(headings: &[&str]) -> Table {
        let group = |heading: &&str| Group {
            heading: (*heading).to_owned(),
            columns: vec!["a".into(), "b".into()],
        };
        let cells = (0..2 * headings.len()).map(|i| Cell {
            text: format!("0.{i:04}"),
            ..Cell::default()
        });
        let line = Line {
            heading: "VGC".into(),
            cells: cells.collect(),
        };
        Table {
            corner: "Method".into(),
            groups: headings.iter().map(group).collect(),
            blocks: vec![Block {
                lines: vec![line],
                ..Block::default()
            }],
            ..Table::default()
        }
    }

    #[test]
    fn parts_are_as_wide_as_their_letters() {
        // The names take 8 letters, a group of two numbers 16.
        let narrow = table(&["x", "y", "z"]);
        let count = |letters| narrow.parts_within(letters).len();
        assert_eq!([56, 55, 40, 39, 1].map(count), [1, 2, 2, 3, 3]);
        let cells = |part: &Table| part.blocks[0].lines[0].cells.len();
        assert_eq!(
            narrow
                .parts_within(40)
                .iter()
                .map(cells)
                .collect::<Vec<_>>(),
            [4, 2]
        );
        // A heading may be wider than its numbers.
        let wide = table(&["a name of thirty letters, say …", "y"]);
        assert_eq!(wide.parts_within(56).len(), 2);
        assert_eq!(narrow.parts(4).len(), 2);
    }
}
