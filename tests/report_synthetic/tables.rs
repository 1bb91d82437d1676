//! Tables: means, intervals, ratios, ranks, and a paper's numbers.

use lightbench::report::write;

use super::report_support::{Folder, Which};
use super::{EVERYTHING, complete, which};

#[test]
fn tables_show_means_intervals_ranks_and_the_papers_numbers() {
    let (_place, folder) = complete(EVERYTHING);
    let summary = write(&folder.path).expect("report").summary;
    // 0.05 × (1.01, 1.02, 1.03): mean 0.051, half width 4.3027 × 0.0005 / √3.
    let markdown = folder.text("tables/errors.md");
    assert!(markdown.contains("**0.0510 ± 0.0012**"), "{markdown}");
    assert!(markdown.contains("| 0.0840 |"), "{markdown}");
    assert!(
        markdown.contains("Mean rank: RMSE") && markdown.contains("**1.00**"),
        "{markdown}"
    );
    let latex = folder.text("tables/errors.tex");
    assert!(latex.contains("\\toprule") && latex.contains("\\textbf{0.0510 $\\pm$ 0.0012}"));
    assert!(latex.contains("RMSE $\\downarrow$"));
    let csv = folder.text("tables/errors.csv");
    let line = csv
        .lines()
        .find(|l| l.starts_with("atrium,ATRIUM,,VGC,rmse,"))
        .expect("a line");
    let cells: Vec<&str> = line.split(',').collect();
    assert!((cells[5].parse::<f64>().expect("mean") - 0.0816).abs() < 1e-12);
    assert_eq!((cells[7], cells[8]), ("3", "0.084"));
    let stages = folder.text("tables/stages.md");
    for text in [
        "| CPU placement, s | 0.0400 |",
        "| CPU total, s | 0.8000 |",
        "processor seconds of all threads",
    ] {
        assert!(stages.contains(text), "`{text}` in {stages}");
    }
    assert!(
        folder
            .text("tables/stages.csv")
            .contains(",cpu_seconds_placement,0.04,")
    );
    for text in [
        "holds",
        "does not hold",
        "cannot be read",
        "no data",
        "Gates",
        "ELSEWHERE",
    ] {
        assert!(summary.contains(text), "{text} in {summary}");
    }
}

#[test]
fn a_sweep_has_a_block_per_scene_and_metric() {
    let place = tempfile::tempdir().expect("folder");
    let extra = r#"
[[table]]
name = "swept"
kind = "sweep"
metrics = ["rmse"]
[[table]]
name = "change"
kind = "change"
metrics = ["rmse"]
[[table]]
name = "equal-cost"
kind = "equal-cost"
cost = "shadow_rays"
metrics = ["rmse"]
[[table]]
name = "equal-error"
kind = "equal-error"
cost = "shadow_rays"
metrics = ["rmse"]
[[figure]]
name = "curve"
kind = "curves"
x = "caches"
[[claim]]
text = "Better everywhere"
where = "Fig. 7"
expect = "rmse(VGC) < rmse(IM)"
[[published]]
where = "Fig. 7"
scene = "STATUES"
method = "VGC"
at = { caches = 2000 }
values = { rmse = 0.033 }
"#;
    let mut folder = Folder::new(&place.path().join("s"), extra);
    for caches in [1000, 2000, 20_000] {
        for (label, error) in [("IM", 3.0), ("VGC", 2.0)] {
            let swept = Which {
                caches: Some(caches),
                ..which("statues", label, 1)
            };
            folder.job(swept, (error / (caches as f64).sqrt(), 0.1), None);
        }
    }
    folder.write();
    let written = write(&folder.path).expect("report");
    let markdown = folder.text("tables/swept.md");
    assert!(markdown.contains("caches: 20000"), "{markdown}");
    assert!(
        markdown.contains("| VGC (paper) | — | 0.0330 | — |"),
        "{markdown}"
    );
    // Errors are 3/√n and 2/√n.
    let change = folder.text("tables/change.md");
    assert!(change.contains("| IM | +0.0 |"), "{change}");
    assert!(change.contains("| VGC | **-33.3** |"), "{change}");
    let equal_cost = folder.text("tables/equal-cost.md");
    assert!(equal_cost.contains("| VGC | **-33.3** |"), "{equal_cost}");
    let equal_error = folder.text("tables/equal-error.md");
    assert!(
        equal_error.contains("| VGC | **0.44 (1 of 3)** |"),
        "{equal_error}"
    );
    assert!(
        written.summary.contains("statues caches=2000: holds"),
        "{}",
        written.summary
    );
    let svg = folder.text("figures/curve.svg");
    assert!(
        svg.contains("10k") && svg.contains("VGC"),
        "logarithmic axis with ticks"
    );
}

#[test]
fn two_views_of_a_scene_stand_side_by_side() {
    let place = tempfile::tempdir().expect("folder");
    let extra = r#"
[[table]]
name = "errors"
metrics = ["rmse"]
[[claim]]
text = "The top is easier"
where = "nowhere"
expect = "rmse(IM@statues (top)) < rmse(IM@statues (front))"
"#;
    let mut folder = Folder::new(&place.path().join("views"), extra);
    for (view, error) in [("front", 0.2), ("top", 0.1)] {
        let seen = Which {
            view,
            ..which("statues", "IM", 1)
        };
        folder.job(seen, (error, error), None);
    }
    folder.write();
    let summary = write(&folder.path).expect("report").summary;
    let markdown = folder.text("tables/errors.md");
    assert!(markdown.contains("statues (front)"), "{markdown}");
    assert!(markdown.contains("| 0.200 | 0.100 |"), "{markdown}");
    assert!(
        summary.contains("holds          The top is easier"),
        "{summary}"
    );
}

/// Two scenes whose ratios of B to A are given for each seed; B has none of the last in `hard`.
fn ratios(kind: &str, of_easy: &[f64], of_hard: &[f64]) -> (tempfile::TempDir, Folder) {
    let place = tempfile::tempdir().expect("folder");
    let extra = format!("[[table]]\nname = \"t\"\nkind = \"{kind}\"\nmetrics = [\"rmse\"]\n");
    let mut folder = Folder::new(&place.path().join("ratios"), &extra);
    for (scene, ratios) in [("easy", of_easy), ("hard", of_hard)] {
        for (seed, ratio) in (1..).zip(ratios) {
            let error = 0.1 * seed as f64;
            folder.job(which(scene, "A", seed), (error, 0.1), None);
            match ratio.is_finite() {
                true => drop(folder.job(which(scene, "B", seed), (error * ratio, 0.1), None)),
                false => {
                    let failed = folder.job(which(scene, "B", seed), (0.0, 0.0), None);
                    failed.status = "failed: crashed".into();
                }
            }
        }
    }
    folder.write();
    write(&folder.path).expect("report");
    (place, folder)
}

#[test]
fn ratios_are_formed_by_seed_and_have_an_interval() {
    // Logarithms −0.2 and 0: mean −0.1, half width 12.706 × 0.1 = 1.2706. Errors differ threefold by seed.
    let (_place, folder) = ratios("change", &[(-0.2f64).exp(), 1.0], &[0.5, 0.5]);
    let markdown = folder.text("tables/t.md");
    let easy = "| B | **-9.5 \\[-74.6, +222.4\\]** | **-50.0** |";
    assert!(markdown.contains(easy), "{markdown}");
    assert!(markdown.contains("| A | *+0.0* | +0.0 |"), "{markdown}");
    assert!(
        markdown.contains("interval of the ratio over 2 seeds"),
        "{markdown}"
    );
    let csv = folder.text("tables/t.csv");
    let line = csv.lines().find(|l| l.starts_with("easy,EASY,,B,"));
    let cells: Vec<&str> = line.expect("a line").split(',').collect();
    // The name of the metric has a comma.
    assert_eq!(cells[7], "", "no half width: the interval is not even");
    for (cell, logarithm) in [(11, -1.3706f64), (12, 1.1706)] {
        let end: f64 = cells[cell].parse().expect("an end of the interval");
        assert!((end - 100.0 * logarithm.exp_m1()).abs() < 0.01, "{end}");
    }
}

#[test]
fn curves_that_lie_beside_the_first_are_told_and_nothing_is_best() {
    let place = tempfile::tempdir().expect("folder");
    let extra = "[[table]]\nname = \"t\"\nkind = \"equal-error\"\ncost = \"shadow_rays\"\nmetrics = [\"rmse\"]\n";
    let mut folder = Folder::new(&place.path().join("beside"), extra);
    for caches in [1000, 2000, 20_000] {
        for (label, error) in [("A", 3.0), ("B", 2.0), ("C", 0.1), ("D", 90.0)] {
            let swept = Which {
                caches: Some(caches),
                ..which("statues", label, 1)
            };
            folder.job(swept, (error / (caches as f64).sqrt(), 0.1), None);
        }
    }
    folder.write();
    write(&folder.path).expect("report");
    let table = folder.text("tables/t.md");
    for text in [
        "| A | 1.00 |",
        "| B | 0.44 (1 of 3) |",
        "| C | below all |",
        "| D | above all |",
        "each budget errs less, or more, than all those of A",
        "how many budgets of A the curve reaches",
    ] {
        assert!(table.contains(text), "`{text}` in {table}");
    }
    let csv = folder.text("tables/t.csv");
    let line = csv.lines().find(|l| l.contains(",B,"));
    assert!(line.expect("a line").ends_with(",1,1"), "{csv}");
}

#[test]
fn a_failed_seed_is_no_data_in_any_mean() {
    let failed = || [0.5, f64::NAN];
    let (_place, folder) = ratios("change", &failed(), &[0.5, 0.4]);
    let change = folder.text("tables/t.md");
    assert!(
        change.contains("| B | -50.0 (1 of 2 seeds) | **"),
        "{change}"
    );
    let line = change.lines().find(|line| line.starts_with("| B |"));
    assert!(line.expect("a line").ends_with("| — |"), "{change}");
    assert!(change.contains("(n of m seeds)"), "{change}");
    let (_place, folder) = ratios("averages", &failed(), &[0.5, 0.4]);
    let averages = folder.text("tables/t.md");
    assert!(averages.contains("| A | 0.1500 ± "), "{averages}");
    assert!(averages.contains("| B | — | — |"), "{averages}");
    let (_place, folder) = ratios("methods", &failed(), &[0.5, 0.4]);
    let methods = folder.text("tables/t.md");
    assert!(
        methods.contains("| B | 0.0500 (1 of 2 seeds) |"),
        "{methods}"
    );
    let csv = folder.text("tables/t.csv");
    let line = csv.lines().find(|l| l.starts_with("easy,EASY,,B,rmse,"));
    assert!(line.expect("a line").ends_with(",2,"), "{csv}");
}

#[test]
fn a_failed_scene_is_no_data_in_any_mean() {
    let (_place, folder) = ratios("change", &[0.5], &[f64::NAN]);
    let change = folder.text("tables/t.md");
    assert!(change.contains("| B | **-50.0** | — | — |"), "{change}");
    let (_place, folder) = ratios("averages", &[0.5], &[f64::NAN]);
    let averages = folder.text("tables/t.md");
    assert!(averages.contains("| A | 0.1000 | 1.00 |"), "{averages}");
    assert!(averages.contains("| B | — | — |"), "{averages}");
}
