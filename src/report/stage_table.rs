//! Where the processor time of each method went, as the papers' stage profiles.

use super::data::{Asked, Data};
use super::table::{Block, Group, Line, Table};
use super::table_kinds::{asked, column_of, notes, ours, start, style_of, theirs};
use crate::experiment::{Column, SEARCH_STAGE, TableSpec, Unit};

/// The columns of a stage: ours, and what papers print of it.
struct Stage {
    /// Processor seconds of all threads.
    cpu: String,
    /// Seconds.
    wall: String,
}

impl Stage {
    fn of(name: &str) -> Self {
        Self {
            cpu: format!("cpu_seconds_{name}"),
            wall: format!("seconds_{name}"),
        }
    }

    fn is_search(&self) -> bool {
        self.wall.strip_prefix("seconds_") == Some(SEARCH_STAGE)
    }

    fn published(&self, data: &Data, asked: Asked) -> Option<f64> {
        data.published(asked, &self.wall)
    }
}

/// One line a stage, columns scene × method.
pub fn stages(data: &Data, spec: &TableSpec) -> Table {
    let mut stages: Vec<Stage> = stage_order(data).iter().map(|s| Stage::of(s)).collect();
    stages.push(Stage::of("total"));
    let keys = stages.iter().flat_map(|s| [s.cpu.clone(), s.wall.clone()]);
    let style = style_of(data, &keys.collect::<Vec<_>>(), Unit::Seconds);
    let mut table = start(spec, "Stage");
    let heading = |stage: &Stage| match stage.wall.as_str() {
        "seconds_total" => format!("CPU total, {}", style.unit),
        _ => format!("{}, {}", Column::of(&stage.cpu).heading, style.unit),
    };
    let mut lines: Vec<Line> = stages
        .iter()
        .map(|stage| Line {
            heading: heading(stage),
            cells: Vec::new(),
        })
        .collect();
    for scene in &data.scenes {
        for point in data.points() {
            let printed = |label: &String, stage: &Stage| {
                let value = stage.published(data, asked(scene, label, point));
                value.is_some()
            };
            let beside: Vec<bool> = data
                .labels()
                .iter()
                .map(|label| stages.iter().any(|stage| printed(label, stage)))
                .collect();
            let mut group = Group {
                heading: [scene.title(), point.text()].join(" ").trim().to_owned(),
                columns: Vec::new(),
            };
            for (label, beside) in data.labels().iter().zip(&beside) {
                group.columns.push(label.clone());
                group.columns.extend(beside.then(|| "paper".to_owned()));
            }
            for (line, stage) in lines.iter_mut().zip(&stages) {
                let column = Column {
                    lower_is_better: None,
                    ..Column::of(&stage.cpu)
                };
                let first = table.records.len();
                let found = column_of(data, scene, point, &column, &mut table.records);
                let records = table.records[first..].iter_mut();
                for (((label, beside), (estimate, standing)), record) in
                    data.labels().iter().zip(&beside).zip(found).zip(records)
                {
                    line.cells.push(ours(estimate.as_ref(), standing, &style));
                    record.published = stage.published(data, asked(scene, label, point));
                    line.cells
                        .extend(beside.then(|| theirs(record.published, &style)));
                }
            }
            table.groups.push(group);
        }
    }
    table.blocks.push(Block {
        heading: String::new(),
        lines,
    });
    notes(data, &mut table);
    let is_printed = table.records.iter().any(|r| r.published.is_some());
    table.notes.push(format!(
        "CPU: processor seconds of all threads{}.",
        if is_printed {
            "; of a paper the seconds that it prints"
        } else {
            ""
        }
    ));
    if stages.iter().any(|stage| stage.is_search()) {
        let note = "CPU search settings: a search for settings, in no total.";
        table.notes.push(note.into());
    }
    table
}

/// The stages of all rows; one that only some rows have stands after its predecessor there.
fn stage_order(data: &Data) -> Vec<String> {
    let mut order: Vec<String> = Vec::new();
    for row in data.cases.rows.iter().filter(|r| r.ok()) {
        let mut next = 0;
        for stage in row.seconds.keys() {
            match order.iter().position(|s| s == stage) {
                Some(at) => next = at + 1,
                None => {
                    order.insert(next, stage.clone());
                    next += 1;
                }
            }
        }
    }
    order
}
