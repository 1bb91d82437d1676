//! Reports of results folders made by hand: every kind of table and figure, and the hard cases.

mod report_support;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use lightbench::environment::LightKind;
use lightbench::experiment::{LIGHTS_FILE, LightFile, MAP_FILE};
use lightbench::image::{Image, read, read_coded, write_png_coded};
use lightbench::report::{ReportError, write, write_single_file};
use report_support::boxes::{assert_legible, texts};
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

/// Figures of every kind that still images give, at sizes for a paper.
fn for_paper(sizes: &str) -> String {
    let figure = |kind: &str, keys: &str| {
        format!(
            "[[figure]]\nname = \"{kind}\"\nkind = \"{kind}\"\ntitle = \"What a reader of a paper may call a figure when one line is not enough for all of it: {kind}\"\n{keys}\n{sizes}\n"
        )
    };
    [
        figure("side-by-side", "columns = 5"),
        figure("records", "columns = 4"),
        figure("discontinuity", "columns = 4"),
        figure("components", ""),
        figure("ranking", "columns = 1"),
        figure(
            "curves",
            "x = \"caches\"\ny = [\"rmse\", \"flip_ldr\"]\ncolumns = 1",
        ),
    ]
    .concat()
}

/// Twelve methods with long names in a sweep.
fn crowded(sizes: &str) -> (tempfile::TempDir, Folder) {
    let place = tempfile::tempdir().expect("folder");
    let mut folder = Folder::new(&place.path().join("crowded"), &for_paper(sizes));
    let labels = (1..=12).map(|i| format!("VGC+DGS at {i} times the angle"));
    for (index, label) in labels.enumerate() {
        for caches in [500, 1000, 20_000, 50_000] {
            let which = Which {
                caches: Some(caches),
                ..which("statues", &label, 1)
            };
            let error = 0.1 + 0.01 * index as f64;
            let images = layers(&picture(96, 54), error as f32);
            folder.job(which, (error, error / (caches as f64).sqrt()), Some(images));
        }
    }
    folder.write();
    (place, folder)
}

#[test]
fn no_text_is_cut_or_lies_on_another_one() {
    let (_place, folder) = complete(EVERYTHING);
    let summary = write(&folder.path).expect("report").summary;
    assert_eq!(assert_legible(&folder.path), 8);
    // By the outlines of letters.
    assert!(
        !summary.contains("lies on") && !summary.contains("leaves the"),
        "{summary}"
    );
    for sizes in ["", "width_mm = 85\nfont_pt = 8"] {
        let (_place, folder) = crowded(sizes);
        let summary = write(&folder.path).expect("report").summary;
        assert_eq!(assert_legible(&folder.path), 6, "{summary}");
        assert!(
            !summary.contains("lies on") && !summary.contains("leaves the"),
            "{summary}"
        );
    }
}

#[test]
fn long_names_of_methods_are_broken_and_not_cut() {
    let place = tempfile::tempdir().expect("folder");
    let mut folder = Folder::new(&place.path().join("long"), &for_paper(""));
    for rounds in ["two", "four"] {
        let label = format!("gradients and {rounds} rounds guided by errors");
        let images = layers(&picture(96, 54), 0.3);
        folder.job(which("statues", &label, 1), (0.1, 0.05), Some(images));
    }
    folder.write();
    write(&folder.path).expect("report");
    assert_legible(&folder.path);
    for name in ["side-by-side", "records", "discontinuity", "components"] {
        let svg = folder.text(&format!("figures/{name}-statues.svg"));
        let written: Vec<String> = texts(&svg).0.into_iter().map(|t| t.text).collect();
        let all = written.join(" ");
        assert!(!all.contains('…'), "{name}: {all}");
        assert!(all.contains("rounds guided by errors"), "{name}: {all}");
    }
}

/// What a job keeps of lights that it made of a map.
fn keep_lights(folder: &Folder, job: &str, lights: &LightFile) {
    let job = folder.path.join("jobs").join(job);
    let map = Image::new(64, 32).map(|_| [0.5; 3]);
    write_png_coded(&job.join(MAP_FILE), &map).expect("map");
    let text = serde_json::to_string(lights).expect("serializes");
    std::fs::write(job.join(LIGHTS_FILE), text).expect("lights");
}

#[test]
fn lights_and_classes_of_texels_are_drawn_on_the_map() {
    let place = tempfile::tempdir().expect("folder");
    let figures = "[[figure]]\nname = \"lights\"\nkind = \"lights\"\n[[figure]]\nname = \"classes\"\nkind = \"classification\"\n";
    let mut folder = Folder::new(&place.path().join("lights"), figures);
    let labels = ["decomposition", "median-cut", "mis"];
    let jobs = labels.map(|label| {
        let images = layers(&picture(96, 54), 0.3);
        let row = folder.job(which("statues", label, 1), (0.1, 0.05), Some(images));
        row.job.clone()
    });
    folder.write();
    let summary = write(&folder.path).expect("report").summary;
    assert!(
        summary.contains("these methods kept no lights"),
        "{summary}"
    );
    let of_kinds = |kinds: [LightKind; 3]| {
        let places = [[0.2, 0.3], [0.5, 0.5], [0.8, 0.7]];
        places.into_iter().zip(kinds).collect()
    };
    let direct = [LightKind::Direct, LightKind::Direct, LightKind::Indirect];
    let told_apart = LightFile {
        lights: of_kinds(direct),
        // The upper half of the map.
        emissive: vec![[0, 64 * 16]],
    };
    let global = LightFile {
        lights: of_kinds([LightKind::Global; 3]),
        emissive: Vec::new(),
    };
    keep_lights(&folder, &jobs[0], &told_apart);
    keep_lights(&folder, &jobs[1], &global);
    write(&folder.path).expect("report");
    assert_legible(&folder.path);
    let drawn = |name: &str| {
        let svg = folder.text(&format!("figures/{name}-statues.svg"));
        let written: Vec<String> = texts(&svg).0.into_iter().map(|t| t.text).collect();
        let file = folder.path.join(format!("figures/{name}-statues.png"));
        let (image, _) = read_coded(&file).expect("a picture");
        let count = |is: fn(&[f32; 3]) -> bool| image.pixels.iter().filter(|p| is(p)).count();
        let red = count(|[r, g, b]| *r > g + 0.3 && *r > b + 0.3);
        let blue = count(|[r, _, b]| *b > r + 0.2);
        (written.join("|"), red as f64, blue as f64)
    };
    let (text, red, blue) = drawn("lights");
    assert!(
        text.contains("decomposition: 2 direct + 1 indirect"),
        "{text}"
    );
    assert!(text.contains("median-cut: 3 lights"), "{text}");
    assert!(!text.contains("mis"), "{text}");
    // Five discs against one, and one of the legend each.
    assert!(red > 3.0 * blue && blue > 0.0, "{red} {blue}");
    let (text, red, blue) = drawn("classes");
    assert!(
        text.contains("decomposition") && !text.contains("median-cut"),
        "{text}"
    );
    assert!((red / blue - 1.0).abs() < 0.05, "{red} {blue}");
}

#[test]
fn figures_have_the_size_and_the_text_that_papers_ask_for() {
    let (_place, folder) = crowded("width_mm = 178\nfont_pt = 8");
    write(&folder.path).expect("report");
    for name in [
        "curves",
        "ranking",
        "records-statues",
        "side-by-side-statues",
    ] {
        let svg = folder.text(&format!("figures/{name}.svg"));
        assert!(svg.contains("width=\"178.0000mm\""), "{}", &svg[..200]);
        let (texts, (width, _)) = texts(&svg);
        let points = |units: f64| units * 178.0 / width / 25.4 * 72.0;
        let common = texts.iter().filter(|t| (points(t.size) - 8.0).abs() < 0.1);
        assert!(common.count() > 0, "{name}");
        let smallest = texts
            .iter()
            .map(|t| points(t.size))
            .fold(f64::MAX, f64::min);
        assert!(smallest > 5.2, "{name}: {smallest}");
        let pdf = std::fs::read(folder.path.join(format!("figures/{name}.pdf"))).expect("pdf");
        let pdf = String::from_utf8_lossy(&pdf);
        // 178 mm are 504.57 points.
        assert!(pdf.contains("/MediaBox [0 0 504.5"), "{name}");
        assert!(pdf.contains("/FontFile2"), "{name}");
        assert_eq!(
            pdf.contains("/Subtype /Image"),
            name.contains('-'),
            "{name}"
        );
    }
}

#[test]
fn pictures_come_through_pixel_by_pixel() {
    let (_place, folder) = complete(EVERYTHING);
    write(&folder.path).expect("report");
    let svg = folder.text("figures/compare-statues.svg");
    let document = roxmltree::Document::parse(&svg).expect("a drawing");
    let (figure, _) = read_coded(&folder.path.join("figures/compare-statues.png")).expect("png");
    let pictures = document
        .descendants()
        .filter(|node| node.has_tag_name("image"));
    let mut count = 0;
    for picture in pictures.filter(|picture| picture.attribute("width") != Some("1000")) {
        let number = |name| {
            picture
                .attribute(name)
                .and_then(|n| n.parse().ok())
                .expect("a number")
        };
        let code = picture
            .attribute("href")
            .and_then(|href| href.split(',').nth(1));
        let bytes = STANDARD.decode(code.expect("a picture")).expect("base64");
        let file = folder.path.join("picture.png");
        std::fs::write(&file, bytes).expect("written");
        let (own, _) = read_coded(&file).expect("png");
        let same = figure.crop((number("x"), number("y")), (own.width, own.height));
        // Frames cover the rims.
        let middle = (own.width / 2, own.height / 2);
        assert_eq!(own.at(middle.0, middle.1), same.at(middle.0, middle.1));
        let equal = own.pixels.iter().zip(&same.pixels).filter(|(a, b)| a == b);
        assert!(equal.count() * 10 > own.pixels.len() * 8);
        count += 1;
    }
    assert!(count > 10, "{count}");
}

#[test]
fn pictures_stand_in_the_order_of_the_figures_methods() {
    let asked = |methods: &str| {
        let asked = r#"methods = ["IM", "VGC+DGS"]"#;
        let (_place, folder) = complete(&EVERYTHING.replace(asked, methods));
        write(&folder.path).expect("report");
        let svg = folder.text("figures/asked-statues.svg");
        let document = roxmltree::Document::parse(&svg).expect("a drawing");
        let texts = document.descendants().filter(|n| n.has_tag_name("text"));
        let mut labels: Vec<(f64, String)> = texts
            .filter(|text| matches!(text.text(), Some("IM" | "VGC+DGS")))
            .map(|text| {
                let x = text.attribute("x").and_then(|x| x.parse().ok());
                (x.expect("a place"), text.text().unwrap_or_default().into())
            })
            .collect();
        labels.sort_by(|a, b| a.0.total_cmp(&b.0));
        let labels: Vec<String> = labels.into_iter().map(|(_, label)| label).collect();
        labels.join(" ")
    };
    // The last one is shown large, before all of them.
    assert_eq!(
        asked(r#"methods = ["IM", "VGC+DGS"]"#),
        "VGC+DGS IM VGC+DGS"
    );
    assert_eq!(asked(r#"methods = ["VGC+DGS", "IM"]"#), "IM VGC+DGS IM");
}

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
    assert!(folder.text("tables/stages.md").contains("shading points"));
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
    assert!(equal_error.contains("| VGC | **0.44** |"), "{equal_error}");
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
    let half: f64 = cells[7].parse().expect("half width");
    assert!(
        (half - 50.0 * (1.1706f64.exp() - (-1.3706f64).exp())).abs() < 0.01,
        "{half}"
    );
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

#[test]
fn gaps_are_stated() {
    let place = tempfile::tempdir().expect("folder");
    let mut folder = Folder::new(&place.path().join("gaps"), EVERYTHING);
    folder.job(
        which("statues", "IM", 1),
        (0.1, 0.05),
        Some(layers(&picture(40, 30), 0.3)),
    );
    let failed = folder.job(which("statues", "SD", 1), (0.2, 0.1), None);
    failed.status = "failed: 7 non-finite values".into();
    failed.non_finite = 7;
    failed.notes = vec!["not finite: pixel 3,4 sample 0, …".into()];
    let undefined = folder.job(which("statues", "VGC", 1), (f64::NAN, f64::INFINITY), None);
    undefined.notes.push("40 records instead of 50".into());
    folder.plan(which("statues", "VGC+DGS", 1));
    folder.plan(which("atrium", "VGC+DGS", 1));
    folder.write();
    let summary = write(&folder.path).expect("report").summary;
    for text in [
        "failed: 7 non-finite values",
        "2 of 5 jobs have no result yet",
        "40 records instead of 50",
        "image.exr",
        "figure `maps` of atrium",
        "—",
    ] {
        assert!(summary.contains(text), "{text} in {summary}");
    }
    let page = folder.text("report.html");
    assert!(page.contains("7 non-finite values — not finite: pixel 3,4 sample 0"));
    assert!(page.contains("--pixel 3,4") && page.contains("Jobs without a result"));
    assert!(folder.path.join("figures/compare-statues.png").is_file());
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
fn texts_of_figures_are_texts_and_do_not_clash() {
    let (_place, folder) = complete(EVERYTHING);
    let written = write(&folder.path).expect("report");
    for text in ["leaves the sheet", "lies on"] {
        assert!(!written.summary.contains(text), "{}", written.summary);
    }
    for name in ["compare-statues", "dots-atrium", "maps-statues"] {
        let svg = folder.text(&format!("figures/{name}.svg"));
        let drawing = roxmltree::Document::parse(&svg).expect("a drawing");
        let texts = drawing.descendants().filter(|n| n.has_tag_name("text"));
        assert!(texts.count() > 1, "{name}");
        write(&folder.path).expect("report");
        assert_eq!(svg, folder.text(&format!("figures/{name}.svg")));
    }
}

#[test]
fn nothing_at_all_is_a_report_too() {
    let place = tempfile::tempdir().expect("folder");
    let folder = Folder::new(&place.path().join("empty"), EVERYTHING);
    folder.write();
    let written = write(&folder.path).expect("report");
    assert!(written.summary.contains("no data"), "{}", written.summary);
    let without_rows = place.path().join("planned");
    let mut planned = Folder::new(&without_rows, "");
    planned.plan(which("statues", "IM", 1));
    planned.write();
    assert!(
        write(&without_rows)
            .expect("report")
            .summary
            .contains("No finished job")
    );
}

#[test]
fn a_folder_without_results_is_an_error_that_says_so() {
    let place = tempfile::tempdir().expect("folder");
    let Err(ReportError::Io(error)) = write(place.path()) else {
        panic!("an error was expected");
    };
    assert!(error.to_string().contains("plan.json"));
    let (_place, folder) = complete("");
    std::fs::write(folder.path.join("config.json"), "{").expect("write");
    let message = write(&folder.path).expect_err("damaged").to_string();
    assert!(message.contains("config.json"), "{message}");
}

#[test]
fn odd_images_are_drawn() {
    for (width, height) in [(1, 1), (1, 700), (900, 1), (7, 5), (1500, 40)] {
        let place = tempfile::tempdir().expect("folder");
        let mut folder = Folder::new(&place.path().join("odd"), EVERYTHING);
        for (label, error) in METHODS {
            let mut image = picture(width, height);
            image.pixels[0] = [f32::NAN, f32::INFINITY, -1.0];
            folder.job(
                which("statues", label, 1),
                (error, error),
                Some(layers(&image, 0.4)),
            );
        }
        folder.write();
        let written = write(&folder.path).expect("report");
        for name in ["compare", "dots", "maps"] {
            let file = folder.path.join(format!("figures/{name}-statues.png"));
            assert!(
                file.is_file(),
                "{name} {width}×{height}: {}",
                written.summary
            );
        }
    }
}

#[test]
fn a_damaged_image_and_one_of_another_size_are_notes() {
    let (_place, folder) = complete(EVERYTHING);
    let jobs: Vec<_> = std::fs::read_dir(folder.path.join("jobs"))
        .expect("jobs")
        .map(|e| e.expect("entry").path().join("image.exr"))
        .filter(|p| p.is_file())
        .collect();
    std::fs::write(&jobs[0], b"v/1\x01 cut short").expect("write");
    let other = layers(&Image::new(3, 3), 0.0);
    lightbench::image::write_exr(&jobs[1], &other, &Default::default()).expect("exr");
    let summary = write(&folder.path).expect("report").summary;
    assert!(
        summary.contains("image.exr") && summary.contains("another size"),
        "{summary}"
    );
}

#[test]
fn special_characters_stay_text() {
    let place = tempfile::tempdir().expect("folder");
    let label = "A&B_<script>alert(1)</script> 100%|x*";
    let extra = EVERYTHING.replace("The full method is best", "<b>bold</b> & \\\"quoted\\\"");
    let mut folder = Folder::new(&place.path().join("special"), &extra);
    for seed in 1..=2 {
        let images = Some(layers(&picture(32, 20), 0.3));
        folder.job(which("sc/ene {1}", label, seed), (0.1, 0.2), images);
    }
    folder.write();
    write(&folder.path).expect("report");
    let page = folder.text("report.html");
    assert!(!page.contains("<script>alert") && !page.contains("<b>bold"));
    assert!(page.contains("&lt;script&gt;") || page.contains("&lt;script>"));
    assert!(
        folder
            .text("tables/errors.tex")
            .contains("A\\&B\\_\\textless{}script")
    );
    assert!(folder.text("tables/errors.md").contains("100%\\|x\\*"));
    for entry in std::fs::read_dir(folder.path.join("figures")).expect("figures") {
        let name = entry
            .expect("entry")
            .file_name()
            .into_string()
            .expect("text");
        assert!(!name.contains(['/', '<', ' ', '{']), "{name}");
    }
}
