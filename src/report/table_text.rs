//! Tables as CSV, Markdown, LaTeX and aligned plain text.

use std::io;

use super::escape;
use super::estimate::Standing;
use super::table::{Cell, Table};

/// Tidy CSV, one number a line, in full precision.
pub fn csv(table: &Table) -> io::Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "scene",
        "paper_scene",
        "sweep",
        "method",
        "metric",
        "mean",
        "half_width_95",
        "repeats",
        "published",
        "standing",
        "low_95",
        "high_95",
        "seeds",
        "budgets",
    ])?;
    let optional = |v: Option<f64>| v.map(|v| v.to_string()).unwrap_or_default();
    for record in &table.records {
        let estimate = record.estimate.as_ref();
        writer.write_record([
            record.scene.as_str(),
            record.paper_scene.as_deref().unwrap_or_default(),
            &record.sweep,
            &record.method,
            &record.metric,
            &optional(estimate.map(|e| e.mean)),
            &optional(estimate.and_then(|e| e.half_width)),
            &estimate.map_or(0, |e| e.repeats()).to_string(),
            &optional(record.published),
            match record.standing {
                Standing::Best => "best",
                Standing::Tied => "tied",
                Standing::Plain => "",
            },
            &optional(record.interval().map(|[low, _]| low)),
            &optional(record.interval().map(|[_, high]| high)),
            &estimate.map_or(0, |e| e.expected).to_string(),
            &record.budgets.map(|n| n.to_string()).unwrap_or_default(),
        ])?;
    }
    let bytes = writer.into_inner().map_err(|e| e.into_error())?;
    String::from_utf8(bytes).map_err(io::Error::other)
}

/// GitHub's Markdown; tables of more than twelve columns are split at their groups.
pub fn markdown(table: &Table) -> String {
    let text = |s: &str| escape::markdown(s);
    let mut out = format!("# {}\n", text(&table.title));
    for part in table.parts(12) {
        let mut heads = vec![text(&part.corner)];
        for group in &part.groups {
            let prefix = if group.heading.is_empty() {
                String::new()
            } else {
                format!("{}: ", group.heading)
            };
            heads.extend(group.columns.iter().map(|c| text(&format!("{prefix}{c}"))));
        }
        out.push_str(&format!(
            "\n| {} |\n|:--{}|\n",
            heads.join(" | "),
            "|--:".repeat(part.width())
        ));
        for block in &part.blocks {
            if !block.heading.is_empty() {
                out.push_str(&format!(
                    "| **{}** |{}\n",
                    text(&block.heading),
                    " |".repeat(part.width())
                ));
            }
            for line in &block.lines {
                let cells: Vec<String> = line.cells.iter().map(markdown_cell).collect();
                out.push_str(&format!(
                    "| {} | {} |\n",
                    text(&line.heading),
                    cells.join(" | ")
                ));
            }
        }
    }
    for note in &table.notes {
        out.push_str(&format!("\n{}\n", text(note)));
    }
    out
}

fn markdown_cell(cell: &Cell) -> String {
    let text = escape::markdown(&cell.text);
    match cell.standing {
        Standing::Best => format!("**{text}**"),
        Standing::Tied => format!("*{text}*"),
        Standing::Plain => text,
    }
}

/// LaTeX for the booktabs package: one `tabular` for every eight columns, split at their groups.
pub fn latex(table: &Table) -> String {
    let text = |s: &str| escape::latex(s);
    let mut out = String::from("% Needs \\usepackage{booktabs}\n");
    for part in table.parts(8) {
        out.push_str(&format!(
            "\\begin{{tabular}}{{l{}}}\n\\toprule\n",
            "r".repeat(part.width())
        ));
        let mut heads = String::new();
        let mut rules = String::new();
        let mut first = 2;
        for group in &part.groups {
            let last = first + group.columns.len() - 1;
            heads.push_str(&format!(
                " & \\multicolumn{{{}}}{{c}}{{{}}}",
                group.columns.len(),
                text(&group.heading)
            ));
            rules.push_str(&format!("\\cmidrule(lr){{{first}-{last}}}"));
            first = last + 1;
        }
        out.push_str(&format!("{heads} \\\\\n{rules}\n{}", text(&part.corner)));
        for column in part.groups.iter().flat_map(|g| &g.columns) {
            out.push_str(&format!(" & {}", text(column)));
        }
        out.push_str(" \\\\\n");
        for block in &part.blocks {
            out.push_str("\\midrule\n");
            if !block.heading.is_empty() {
                let span = part.width() + 1;
                out.push_str(&format!(
                    "\\multicolumn{{{span}}}{{l}}{{{}}} \\\\\n",
                    text(&block.heading)
                ));
            }
            for line in &block.lines {
                let cells: Vec<String> = line.cells.iter().map(latex_cell).collect();
                out.push_str(&format!(
                    "{} & {} \\\\\n",
                    text(&line.heading),
                    cells.join(" & ")
                ));
            }
        }
        out.push_str("\\bottomrule\n\\end{tabular}\n");
    }
    for note in &table.notes {
        out.push_str(&format!("% {note}\n"));
    }
    out
}

fn latex_cell(cell: &Cell) -> String {
    let text = escape::latex(&cell.text);
    match cell.standing {
        Standing::Best => format!("\\textbf{{{text}}}"),
        Standing::Tied => format!("\\textit{{{text}}}"),
        Standing::Plain => text,
    }
}

/// Aligned columns for a terminal of about 100 characters: `*` marks the best, `~` those tied with
/// it.
pub fn plain(table: &Table) -> String {
    let mut out = format!("{}\n", table.title);
    for part in table.parts(columns_that_fit(table)) {
        out.push_str(&plain_part(&part));
    }
    for note in &table.notes {
        let note = note.replace("Bold:", "*:").replace("italic:", "~:");
        out.push_str(&format!("  {note}\n"));
    }
    out
}

fn columns_that_fit(table: &Table) -> usize {
    let lines = table.blocks.iter().flat_map(|b| &b.lines);
    let widest = lines
        .flat_map(|l| &l.cells)
        .map(|c| c.text.chars().count() + 3)
        .max();
    80 / widest.unwrap_or(1).max(1)
}

fn plain_part(table: &Table) -> String {
    let marked = |cell: &Cell| {
        let mark = match cell.standing {
            Standing::Best => '*',
            Standing::Tied => '~',
            Standing::Plain => ' ',
        };
        format!("{}{mark}", cell.text)
    };
    let lines = || table.blocks.iter().flat_map(|b| &b.lines);
    let length = |s: &str| s.chars().count();
    let first = lines()
        .map(|l| length(&l.heading))
        .max()
        .unwrap_or(0)
        .max(length(&table.corner));
    let columns: Vec<&String> = table.groups.iter().flat_map(|g| &g.columns).collect();
    let mut widths: Vec<usize> = columns.iter().map(|c| length(c) + 1).collect();
    for line in lines() {
        for (width, cell) in widths.iter_mut().zip(&line.cells) {
            *width = (*width).max(length(&marked(cell)));
        }
    }
    let mut next = 0;
    let mut heads = String::new();
    for group in &table.groups {
        let here = &mut widths[next..next + group.columns.len()];
        let total = here.iter().sum::<usize>() + 2 * (here.len() - 1);
        // A long heading widens its last column.
        if let Some(last) = here.last_mut() {
            *last += length(&group.heading).saturating_sub(total);
        }
        let total = total.max(length(&group.heading));
        heads.push_str(&format!("  {:^total$}", group.heading));
        next += group.columns.len();
    }
    let mut out = format!("  {:first$}{}\n", "", heads.trim_end());
    out.push_str(&format!("  {:first$}", table.corner));
    for (column, width) in columns.iter().zip(&widths) {
        out.push_str(&format!("  {:>width$} ", column, width = width - 1));
    }
    out.push('\n');
    for block in &table.blocks {
        if !block.heading.is_empty() {
            out.push_str(&format!("  [{}]\n", block.heading));
        }
        for line in &block.lines {
            let mut text = format!("  {:first$}", line.heading);
            for (cell, width) in line.cells.iter().zip(&widths) {
                text.push_str(&format!("  {:>width$}", marked(cell)));
            }
            out.push_str(&format!("{}\n", text.trim_end()));
        }
    }
    out
}
