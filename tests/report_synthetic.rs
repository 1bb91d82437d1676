//! Reports of results folders made by hand: every kind of table and figure, and the hard cases.

#[path = "report_synthetic/damage.rs"]
mod damage;
#[path = "report_synthetic/figures.rs"]
mod figures;
mod report_support;
#[path = "report_synthetic/tables.rs"]
mod tables;

use lightbench::image::read;
use lightbench::report::{write, write_single_file};
use report_support::{Folder, Which, layers, picture};

const METHODS: [(&str, f64); 4] = [("IM", 0.12), ("SD", 0.09), ("VGC", 0.08), ("VGC+DGS", 0.05)];

fn which<'a>(scene: &'a str, label: &'a str, seed: u64) -> Which<'a> {
    Which {
        scene,
        view: "main",
        label,
        seed,
        caches: None,
    }
}

/// Two scenes, four methods, three seeds; images of the first seed.
fn complete(extra: &str) -> (tempfile::TempDir, Folder) {
    let place = tempfile::tempdir().expect("folder");
    let mut folder = Folder::new(&place.path().join("synthetic"), extra);
    for scene in ["statues", "atrium"] {
        for (label, error) in METHODS {
            for seed in 1..=3 {
                let spread = 1.0 + 0.01 * seed as f64;
                let images = (seed == 1).then(|| layers(&picture(96, 54), error as f32 * 5.0));
                folder.job(
                    which(scene, label, seed),
                    (error * spread, error * 0.3 * spread),
                    images,
                );
            }
        }
    }
    folder.write();
    (place, folder)
}

const EVERYTHING: &str = r#"
repeats = 3
[[table]]
name = "errors"
title = "Errors"
metrics = ["rmse", "flip_ldr", "psnr"]
[[table]]
name = "stages"
kind = "stages"
[[table]]
name = "swept"
kind = "sweep"
[[figure]]
name = "compare"
title = "Comparison"
kind = "side-by-side"
[[figure]]
name = "asked"
kind = "side-by-side"
scenes = ["stat*"]
methods = ["IM", "VGC+DGS"]
insets = [[0.1, 0.1, 0.2, 0.2], [0.9, 0.9, 0.5, 0.5], [0.0, 0.0, 0.0, 0.0]]
[[figure]]
name = "dots"
kind = "records"
[[figure]]
name = "maps"
kind = "discontinuity"
methods = ["VGC+DGS"]
[[figure]]
name = "curve"
kind = "curves"
x = "seconds_total"
y = ["rmse", "flip"]
[[claim]]
text = "The full method is best"
where = "Fig. 6"
expect = "rmse(VGC+DGS) < min(rmse(IM), rmse(SD))"
[[claim]]
text = "Turned around"
where = "nowhere"
expect = "rmse(VGC+DGS) > rmse(IM)"
[[claim]]
text = "Broken"
where = "nowhere"
expect = "rmse(VGC+DGS) is small"
[[claim]]
text = "Elsewhere"
where = "nowhere"
expect = "rmse(VGC) < 1"
scenes = ["KITCHEN"]
[[gate]]
text = "Bounded"
expect = "rmse(VGC) < 0.5"
[[published]]
where = "Table 2"
scene = "ATRIUM"
method = "VGC"
values = { rmse = 0.0840, flip_ldr = 0.0245 }
[[published]]
where = "Table 9"
scene = "ELSEWHERE"
method = "VGC"
values = { rmse = 1.0 }
"#;

#[test]
fn a_complete_folder_gets_every_file() {
    let (_place, folder) = complete(EVERYTHING);
    let written = write(&folder.path).expect("report");
    for file in &written.files {
        assert!(file.is_file(), "{}", file.display());
    }
    for name in [
        "figures/compare-statues.png",
        "figures/compare-atrium.png",
        "figures/asked-statues.png",
        "figures/dots-atrium.png",
        "figures/maps-statues.png",
        "figures/curve.svg",
        "figures/curve.png",
        "figures/curve.pdf",
        "figures/compare-atrium.pdf",
        "tables/errors.csv",
        "tables/errors.md",
        "tables/errors.tex",
        "tables/stages.md",
        "tables/swept.tex",
        "report.html",
    ] {
        assert!(written.files.contains(&folder.path.join(name)), "{name}");
    }
    assert!(!folder.path.join("figures/asked-atrium.png").exists());
    let figure = read(&folder.path.join("figures/compare-statues.png")).expect("png");
    assert!(figure.width > 1500 && figure.height > 400);
    let again = write(&folder.path).expect("report");
    assert_eq!(again.summary, written.summary);
}

#[test]
fn equal_folders_give_equal_bytes() {
    let (_a, first) = complete(EVERYTHING);
    let (_b, second) = complete(EVERYTHING);
    let files = write(&first.path).expect("report").files;
    write(&second.path).expect("report");
    for file in files {
        let name = file.strip_prefix(&first.path).expect("inside");
        let bytes = |folder: &Folder| std::fs::read(folder.path.join(name)).expect("file");
        assert!(bytes(&first) == bytes(&second), "{}", name.display());
    }
}

#[test]
fn a_single_file_holds_its_pictures() {
    let (_place, folder) = complete(EVERYTHING);
    write_single_file(&folder.path).expect("report");
    let page = folder.text("report.html");
    assert!(!folder.path.join("figures/viewer").exists());
    assert!(page.contains("id=\"pixels-statues-VGC_image\""));
    assert!(page.contains("data:image") && !page.contains("src=\"figures"));
    write(&folder.path).expect("report");
    assert!(!folder.text("report.html").contains("id=\"pixels-statues"));
    assert!(
        folder
            .path
            .join("figures/viewer/statues-VGC_image.js")
            .is_file()
    );
}

#[test]
fn each_job_has_its_commands_and_each_point_its_row() {
    let (_place, folder) = complete(EVERYTHING);
    write(&folder.path).expect("report");
    let page = folder.text("report.html").replace("&#x2f;", "/");
    for text in [
        "lightbench run configs/synthetic.toml scale=1/4 --scene statues --method VGC+DGS --out results/synthetic",
        "lightbench replay results/synthetic/jobs/",
        "<th>inefficiency</th>",
    ] {
        assert!(page.contains(text), "{text}");
    }
    let svg = folder.text("figures/curve.svg");
    assert!(svg.contains("<title>VGC, ") && page.contains("<title>VGC, "));
    roxmltree::Document::parse(&svg).expect("a drawing");
}

#[test]
fn costs_rank_cpu_seconds_and_never_wall_seconds() {
    const BOTH: &str = "metrics = ['seconds_total', 'cpu_seconds_total']";
    let table = |name, kind| format!("[[table]]\nname = '{name}'\nkind = '{kind}'\n{BOTH}\n");
    let tables = table("times", "methods") + &table("changes", "change");
    let extra = format!("repeats = 3\n{tables}");
    let place = tempfile::tempdir().expect("folder");
    let mut folder = Folder::new(&place.path().join("synthetic"), &extra);
    for (label, seconds) in METHODS {
        for seed in 1..=3 {
            let row = folder.job(which("statues", label, seed), (0.1, 0.1), None);
            (row.seconds_total, row.cpu_seconds_total) = (seconds, 1.0 / seconds);
        }
    }
    folder.write();
    write(&folder.path).expect("report");
    let page = folder.text("report.html");
    let costs = page.split("id=\"costs\"").nth(1).expect("costs");
    let costs = costs.split("<h2").next().unwrap_or_default();
    assert!(
        costs.contains("CPU time") && !costs.contains("wall time"),
        "{costs}"
    );
    let times = folder.text("tables/times.md");
    assert!(
        times.contains("wall time") && times.contains("CPU time, "),
        "{times}"
    );
    for text in [times, folder.text("tables/changes.md")] {
        assert_eq!(text.matches("**").count(), 2, "one best: {text}");
    }
}
