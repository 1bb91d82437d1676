//! Where the time of each method went, as the papers' stage profiles.

use super::data::Data;
use super::table::{Block, Group, Line, Table};
use super::table_kinds::{column_of, notes, ours, start, style_of, theirs};
use crate::experiment::TableSpec;
use crate::experiment::{Column, Unit};

/// One line a stage, columns scene × method.
pub fn stages(data: &Data, spec: &TableSpec) -> Table {
    let mut keys: Vec<String> = stage_order(data)
        .iter()
        .map(|s| format!("seconds_{s}"))
        .collect();
    keys.push("seconds_total".into());
    let style = style_of(data, &keys, Unit::Seconds);
    let mut table = start(spec, "Stage");
    let heading = |key: &str| match key {
        "seconds_total" => format!("total, {}", style.unit),
        _ => format!("{}, {}", Column::of(key).heading, style.unit),
    };
    let mut lines: Vec<Line> = keys
        .iter()
        .map(|key| Line {
            heading: heading(key),
            cells: Vec::new(),
        })
        .collect();
    for scene in &data.scenes {
        for point in data.points() {
            let beside: Vec<bool> = data
                .labels()
                .iter()
                .map(|l| {
                    keys.iter()
                        .any(|k| data.published(scene, (l, point), k).is_some())
                })
                .collect();
            let mut group = Group {
                heading: [scene.title(), point.text()].join(" ").trim().to_owned(),
                columns: Vec::new(),
            };
            for (label, beside) in data.labels().iter().zip(&beside) {
                group.columns.push(label.clone());
                group.columns.extend(beside.then(|| "paper".to_owned()));
            }
            for (line, key) in lines.iter_mut().zip(&keys) {
                let column = Column {
                    lower_is_better: None,
                    ..Column::of(key)
                };
                let found = column_of(data, (scene, point), &column, &mut table.records);
                for ((label, beside), (estimate, standing)) in
                    data.labels().iter().zip(&beside).zip(found)
                {
                    line.cells.push(ours(estimate.as_ref(), standing, &style));
                    let value = data.published(scene, (label, point), key);
                    line.cells.extend(beside.then(|| theirs(value, &style)));
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
