//! The headline numbers of the README, read from the published tables: `cargo run --example headline` prints them, and
//! `cargo test --test pages` compares the README with them. One more number is one more line of
//! `results/published/headlines.txt`.

use std::fs;
use std::path::Path;

/// The lines as the README has them.
///
/// # Errors
/// A sentence, where a file, a section or a cell is not there.
pub fn lines(published: &Path) -> Result<Vec<String>, String> {
    let list = read(published, "headlines.txt")?;
    let headlines = list.lines().filter(|line| !line.starts_with('#'));
    headlines.map(|line| headline(line, published)).collect()
}

fn read(folder: &Path, name: &str) -> Result<String, String> {
    fs::read_to_string(folder.join(name)).map_err(|error| format!("{name}: {error}"))
}

/// One headline with its numbers, its command and a link to its table.
fn headline(line: &str, published: &Path) -> Result<String, String> {
    let parts: Vec<&str> = line.splitn(3, " | ").map(str::trim).collect();
    let [place, command, text] = parts.as_slice() else {
        return Err(format!("expected FILE # SECTION | COMMAND | TEXT: {line}"));
    };
    let (file, section) = place.split_once('#').unwrap_or((place, ""));
    let (name, section) = (format!("{}.md", file.trim()), section.trim());
    let page = read(published, &name)?;
    let is_it = |heading: &&str| {
        heading
            .trim_start_matches('#')
            .trim_start()
            .starts_with(section)
    };
    // Without a section the whole page is looked through.
    let searched = match section.is_empty() {
        true => page.as_str(),
        false => (page.split("\n#").find(is_it))
            .ok_or_else(|| format!("{name}: no section `{section}`"))?,
    };
    let mut pieces = text.split('{');
    let mut told = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (asked, rest) = piece.split_once('}').unwrap_or((piece, ""));
        let (row, column) = asked.split_once("; ").unwrap_or((asked, ""));
        let found = cell(searched, row, column);
        let found = found.ok_or_else(|| format!("{name} {section}: no cell {asked}"))?;
        told = told + &found.replace('-', "−").replace(' ', "\u{a0}") + rest;
    }
    let link = format!("[table](results/published/{name})");
    Ok(format!(
        "{}\n  `lightbench {command}` ({link})",
        wrapped(&format!("- {told}:"))
    ))
}

/// A list item in lines of at most 118 columns.
fn wrapped(text: &str) -> String {
    let (mut out, mut column) = (String::new(), 0);
    for word in text.split(' ') {
        let width = word.chars().count();
        if column + 1 + width > 118 {
            out.push_str("\n  ");
            column = 2;
        } else if column > 0 {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column += width;
    }
    out
}

/// The cell of a line and a column in the first table that has both.
fn cell(text: &str, row: &str, column: &str) -> Option<String> {
    let (group, row) = row.rsplit_once('/').unwrap_or(("", row));
    let (mut place, mut within) = (None, "".to_owned());
    for line in text.lines() {
        let Some(line) = line.strip_prefix('|') else {
            (place, within) = (None, String::new());
            continue;
        };
        let cells: Vec<String> = line.trim_end_matches('|').split('|').map(plain).collect();
        if cells[0] == "Method" {
            place = cells.iter().position(|cell| cell == column);
        } else if cells[1..].iter().all(String::is_empty) {
            within.clone_from(&cells[0]);
        } else if let Some(place) = place.filter(|_| within == group && cells[0] == row) {
            return cells.get(place).cloned();
        }
    }
    None
}

/// A cell without bold and italic type and escapes.
fn plain(cell: &str) -> String {
    cell.trim().trim_matches('*').replace('\\', "")
}

#[allow(dead_code)] // The test of the pages includes this file for its lines.
fn main() -> Result<(), String> {
    let published = Path::new(env!("CARGO_MANIFEST_DIR")).join("results/published");
    for line in lines(&published)? {
        println!("{line}");
    }
    Ok(())
}
