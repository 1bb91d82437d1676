//! `docs/columns.md`.

use super::{COLUMNS, Cells, ColumnEntry, FOUND, Unit};

/// The text of `docs/columns.md`.
fn page() -> String {
    let mut page = String::from(
        "# Columns\n\nOne line of `rows.csv` and `rows.jsonl` is the result of one job. Tables, plots and claims \
         name the numbers among these columns, the numbers that methods find on the way, parameters that \
         a method sets and swept keys.\n\nThis page is made from `src/experiment/columns.rs`; after a change there \
         `LIGHTBENCH_BLESS=1 cargo test --lib columns` writes it again.\n\n",
    );
    page.push_str("| column | heading | unit | better | meaning |\n|---|---|---|---|---|\n");
    COLUMNS.iter().for_each(|e| line(&mut page, e));
    page.push_str(
        "\n## Found by methods\n\nIn `params` of the rows that have them.\n\n\
         | column | heading | unit | better | meaning |\n|---|---|---|---|---|\n",
    );
    FOUND.iter().for_each(|e| line(&mut page, e));
    page
}

fn line(page: &mut String, entry: &ColumnEntry) {
    let unit = match entry.unit {
        Unit::None => "",
        Unit::Decibel => "dB",
        Unit::Seconds => "s",
        Unit::Bytes => "bytes",
        Unit::Count => "count",
    };
    let better = match entry.lower_is_better {
        Some(true) => "lower",
        Some(false) => "higher",
        None => "",
    };
    let (key, heading, meaning) = match entry.cells {
        Cells::Text(_) => (
            entry.key.to_owned(),
            "text".to_owned(),
            entry.meaning.to_owned(),
        ),
        Cells::Stages(_) => (
            format!("{}_<stage>", entry.key),
            format!("{}the stage", entry.heading),
            entry.meaning.to_owned(),
        ),
        Cells::Derived(_) => (
            entry.key.to_owned(),
            entry.heading.to_owned(),
            format!("{} (not in `rows.csv`)", entry.meaning),
        ),
        _ => (
            entry.key.to_owned(),
            entry.heading.to_owned(),
            entry.meaning.to_owned(),
        ),
    };
    page.push_str(&format!(
        "| `{key}` | {heading} | {unit} | {better} | {meaning} |\n"
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_that_of_the_table() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/columns.md");
        if std::env::var_os("LIGHTBENCH_BLESS").is_some() {
            std::fs::write(file, page()).expect("written");
        }
        let there = std::fs::read_to_string(file).unwrap_or_default();
        assert!(
            there == page(),
            "docs/columns.md is not that of the table: LIGHTBENCH_BLESS=1 cargo test --lib columns"
        );
    }
}
