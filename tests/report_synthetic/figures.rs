//! Figures: sizes for papers, texts that can be read, pictures pixel by pixel.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use lightbench::environment::LightKind;
use lightbench::experiment::{LIGHTS_FILE, LightFile, MAP_FILE};
use lightbench::image::{Image, Rect, read_coded, write_png_coded};
use lightbench::report::write;

use super::report_support::boxes::{assert_legible, texts};
use super::report_support::{Folder, Which, layers, picture};
use super::{EVERYTHING, complete, which};

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
fn a_curve_says_where_seeds_are_missing() {
    let place = tempfile::tempdir().expect("folder");
    let extra = "repeats = 3\n[[figure]]\nname = \"curve\"\nkind = \"curves\"\nx = \"caches\"\n";
    let mut folder = Folder::new(&place.path().join("lacking"), extra);
    for caches in [1000, 2000] {
        for (label, seed) in [("A", 1), ("A", 2), ("A", 3), ("B", 1), ("B", 2), ("B", 3)] {
            let swept = Which {
                caches: Some(caches),
                ..which("statues", label, seed)
            };
            if (label, caches, seed) == ("B", 2000, 2) {
                folder.plan(swept);
            } else {
                folder.job(swept, (0.1, 0.2), None);
            }
        }
    }
    folder.write();
    write(&folder.path).expect("report");
    let report = folder.text("report.html");
    let told = "Seeds failed or are missing: B in statues, caches=2000 (2 of 3). Their points";
    assert!(report.contains(told), "{report}");
    assert!(!report.contains("A in statues"));
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
        let same = figure.crop(Rect::new(number("x"), number("y"), own.size()));
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
