//! The report as plain text for the terminal.

use super::claims::Claim;
use super::data::Data;
use super::table::Table;
use super::table_text;

/// Tables, claims, and what is missing or fell short.
pub fn text(data: &Data, tables: &[Table], claims: &[Claim], notes: &[String]) -> String {
    let mut out = String::new();
    for table in tables {
        out.push_str(&format!("\n{}", table_text::plain(table)));
    }
    for (heading, gates) in [("Claims", false), ("Gates", true)] {
        let here: Vec<&Claim> = claims.iter().filter(|c| c.gate == gates).collect();
        if !here.is_empty() {
            out.push_str(&format!("\n{heading}\n"));
        }
        here.iter().for_each(|c| claim(&mut out, c));
    }
    let mut lines = shortfalls(data);
    lines.extend(notes.iter().cloned());
    if !lines.is_empty() {
        out.push_str("\nNotes\n");
    }
    for line in lines {
        out.push_str(&format!("  {line}\n"));
    }
    out
}

fn claim(out: &mut String, claim: &Claim) {
    let place = if claim.place.is_empty() {
        String::new()
    } else {
        format!(" ({})", claim.place)
    };
    out.push_str(&format!("  {:14} {}{place}\n", claim.verdict, claim.text));
    if !claim.error.is_empty() {
        out.push_str(&format!("  {:14} {}\n", "", claim.error));
    }
    for case in &claim.cases {
        let place = [case.scene.as_str(), case.at.as_str()].join(" ");
        let mut line = format!("  {:14}   {}: {}", "", place.trim(), case.verdict);
        if case.ours.is_empty() && !case.margin.is_empty() {
            line.push_str(&format!(", {}", case.margin));
        }
        if !case.ours.is_empty() {
            line.push_str(&format!(", {}; by {}", case.ours, case.margin));
        }
        if !case.paper.is_empty() {
            line.push_str(&format!("; paper {}", case.paper));
        }
        out.push_str(&format!("{line}\n"));
    }
}

/// Stand-ins, failed and missing jobs, and the rows' own notes, a sentence each.
pub fn shortfalls(data: &Data) -> Vec<String> {
    let mut lines = data.plan.told();
    lines.extend(data.cases.failures());
    let missing = data.missing().len();
    if missing > 0 {
        lines.push(format!(
            "{missing} of {} jobs have no result yet; `lightbench run` with the same config resumes",
            data.plan.jobs.len()
        ));
    }
    for note in data.cases.notes() {
        let shown = note
            .runs
            .iter()
            .take(4)
            .cloned()
            .collect::<Vec<_>>()
            .join(", ");
        let more = match note.runs.len() {
            0..=4 => String::new(),
            n => format!(" and {} more", n - 4),
        };
        lines.push(format!("{shown}{more}: {}", note.text));
    }
    lines.extend(data.unplaced());
    lines
}
