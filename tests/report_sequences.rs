//! Reports of sequences made by hand: timelines, contact sheets, and the page that plays kept frames.

mod report_support;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use lightbench::experiment::{Sequence, Viewer};
use lightbench::image::{Attributes, Image, Layer, Plane, read, write_exr, write_png};
use lightbench::report::write;
use report_support::boxes::assert_legible;
use report_support::{Folder, Which, layers, picture, reference_attributes};

const KEY: &str = "00aa";
const FIGURES: &str = r#"
[sequence]
frames = 12
warm_up = 3
[[figure]]
name = "time"
title = "Over time"
kind = "timeline"
y = ["rmse", "rays"]
[[figure]]
name = "apart"
kind = "timeline"
x = "time"
y = ["flip", "rmse_cold"]
per_viewer = true
[[figure]]
name = "sheet"
kind = "frames"
[[figure]]
name = "compare"
kind = "side-by-side"
"#;

/// Twelve frames, the first three not measured, seen by two viewers; four are kept.
fn sequence() -> Sequence {
    let viewer = |name: &str| Viewer::Path {
        name: name.into(),
        eye: 0,
        turn_deg: 0.0,
    };
    Sequence {
        frames: (0..12).collect(),
        fps: 10.0,
        viewers: vec![viewer("<aisle>"), viewer("gallery")],
        warm_up: 3,
        measure_every: 1,
        first_of: None,
        measure_run: 1,
        kept: vec![0, 3, 7, 11],
        cold: false,
        skip_unmeasured: false,
    }
}

/// What `frames.csv` of a job says: the RMSE of frame n is n / 100, twice that for the second viewer.
fn frames_csv() -> String {
    let mut text =
        "frame,viewer,time_s,measured,rmse,flip_ldr,reference,rays,shadow_rays\n".to_owned();
    for frame in 0..12 {
        for viewer in 0..2 {
            let time = f64::from(frame) / 10.0;
            let rmse = f64::from(frame * (viewer + 1)) / 100.0;
            let measured = match frame < 3 {
                true => "false,,,".to_owned(),
                false => format!("true,{rmse},{},{KEY}", rmse / 2.0),
            };
            writeln!(
                text,
                "{frame},{viewer},{time},{measured},{},5",
                1000 + frame
            )
            .expect("text");
        }
    }
    text
}

/// The files that a job of a sequence leaves beside its image.
fn leave_frames(job: &Path, image: &Image) {
    fs::write(job.join("frames.csv"), frames_csv()).expect("csv");
    fs::write(job.join("animation-0.png"), b"animated").expect("preview");
    fs::create_dir(job.join("frames")).expect("folder");
    for frame in sequence().kept {
        for viewer in 0..2 {
            let path = |end: &str| job.join(format!("frames/{frame:06}-{viewer}.{end}"));
            write_png(&path("png"), image, 0.0).expect("png");
            let flip = Plane {
                width: image.width,
                height: image.height,
                values: vec![0.5; image.pixels.len()],
            };
            let layers = [
                Layer::color("beauty", image.clone()),
                Layer::color("error", image.clone()),
                Layer::gray("flip", flip),
            ];
            write_exr(&path("exr"), &layers, &Attributes::new()).expect("exr");
        }
    }
}

/// Two methods of a sequence in one scene.
fn sequences(labels: [&str; 2]) -> (tempfile::TempDir, Folder, Vec<String>) {
    let place = tempfile::tempdir().expect("folder");
    let mut folder = Folder::new(&place.path().join("sequences"), FIGURES);
    folder.sequence = Some(sequence());
    let mut jobs = Vec::new();
    for (label, error) in labels.into_iter().zip([0.3, 0.2]) {
        let which = Which {
            scene: "atrium",
            view: "<aisle> + gallery",
            label,
            seed: 1,
            caches: None,
        };
        let images = Some(layers(&picture(96, 54), error));
        let row = folder.job(which, (f64::from(error), 0.1), images);
        (row.frames, row.frames_measured, row.viewers) = (12, 9, 2);
        jobs.push(row.job.clone());
    }
    folder.write();
    for job in &jobs {
        leave_frames(&folder.path.join("jobs").join(job), &picture(96, 54));
    }
    let references = place.path().join("references");
    fs::create_dir(&references).expect("folder");
    let image = picture(96, 54);
    let layers = [
        Layer::color("mean", image.clone()),
        Layer::color("deviations", image),
    ];
    let path = references.join(format!("{KEY}.exr"));
    write_exr(&path, &layers, &reference_attributes()).expect("reference");
    (place, folder, jobs)
}

#[test]
fn timelines_show_means_over_viewers_from_the_warm_up_on() {
    let (_place, folder, _) = sequences(["IM", "VGC"]);
    let written = write(&folder.path).expect("report");
    assert_eq!(assert_legible(&folder.path), 4);
    let svg = folder.text("figures/time-atrium.svg");
    for text in ["Over time", "warm-up", "RMSE", "closest-hit rays", "VGC"] {
        assert!(svg.contains(text), "{text}");
    }
    // Two panels with a shade each, and one in the legend.
    assert_eq!(svg.matches("fill-opacity=\"0.08\"").count(), 3);
    // Nine measured frames of two methods, twelve frames with rays.
    let corners = |line: &str| {
        line.split("points=\"")
            .nth(1)
            .map(|p| p.split('"').next().map(|p| p.split_whitespace().count()))
    };
    let lines = svg.lines().filter(|l| l.starts_with("<polyline"));
    let long: Vec<usize> = lines
        .filter_map(corners)
        .flatten()
        .filter(|n| *n > 5)
        .collect();
    assert_eq!(long, [9, 9, 12, 12]);
    let apart = folder.text("figures/apart-atrium.svg");
    assert!(
        apart.contains("time, s") && apart.contains("gallery") && apart.contains("&lt;aisle&gt;")
    );
    assert!(
        written.summary.contains("no frame has `rmse_cold`"),
        "{}",
        written.summary
    );
    assert!(
        read(&folder.path.join("figures/time-atrium.png"))
            .expect("png")
            .width
            > 900
    );
}

#[test]
fn a_job_without_its_frames_is_noted() {
    let (_place, folder, jobs) = sequences(["IM", "VGC"]);
    let of = |job: usize| folder.path.join("jobs").join(&jobs[job]);
    fs::remove_file(of(0).join("frames.csv")).expect("there");
    fs::write(of(1).join("frames.csv"), "frame,viewer\nx,0\n").expect("there");
    let summary = write(&folder.path).expect("report").summary;
    for text in [
        "atrium IM seed 1: frames.csv:",
        "atrium VGC seed 1: frames.csv: line 2 names no frame",
        "figure `time` of atrium: no finished job has the columns",
    ] {
        assert!(summary.contains(text), "{text} in {summary}");
    }
    assert!(folder.text("report.html").contains("frame 7 · 0.70 s"));
    fs::remove_dir_all(of(0).join("frames")).expect("there");
    fs::remove_dir_all(of(1).join("frames")).expect("there");
    let summary = write(&folder.path).expect("report").summary;
    assert!(summary.contains("no frame was kept"), "{summary}");
    let page = folder.text("report.html");
    assert!(!page.contains("frame 7 · 0.70 s"));
    assert!(page.contains("<h3>atrium, frame 7 of viewer &lt;aisle&gt;<"));
}

#[test]
fn the_page_plays_kept_frames_for_each_viewer() {
    let (_place, folder, jobs) = sequences(["IM", "VGC"]);
    write(&folder.path).expect("report");
    let page = folder.text("report.html");
    for text in [
        "&quot;frame 7 · 0.70 s&quot;,&quot;frame 11 · 1.10 s&quot;]".to_owned(),
        "&quot;start&quot;:2".into(),
        "&quot;gallery&quot;]".into(),
        format!("jobs/{}/animation-0.png", jobs[0]),
        "atrium-VGC_image-000011-1".into(),
        "atrium-_reference-000007-1".into(),
        "atrium-VGC_flip-000003-0".into(),
        // Frame 7 of the second viewer, and a frame of the warm-up.
        "RMSE 0.1400 · FLIP 0.07000".into(),
        "not measured".into(),
        "over all its measured frames".into(),
    ] {
        let escaped = text.replace('/', "&#x2f;");
        assert!(page.contains(&text) || page.contains(&escaped), "{text}");
    }
    assert!(
        folder
            .path
            .join("figures/viewer/atrium-_reference-000007-1.js")
            .is_file()
    );
    assert!(
        !folder
            .path
            .join("figures/viewer/atrium-_reference-000000-0.js")
            .exists()
    );
    let sheet = read(&folder.path.join("figures/sheet-atrium.png")).expect("png");
    assert!(sheet.width > 800 && sheet.height > 300);
}

#[test]
fn names_of_a_sequence_are_escaped() {
    let (_place, folder, _) = sequences(["</script><b>", "\"x\" onload='y'"]);
    write(&folder.path).expect("report");
    // In drawings a name is text, with its quotes.
    let page = folder.text("report.html");
    let mut outside = String::new();
    for part in page.split("<svg") {
        let (drawing, rest) = part.split_once("</svg>").unwrap_or(("", part));
        assert!(!drawing.contains("<b>") && !drawing.contains("<script"));
        outside.push_str(rest);
    }
    let page = outside;
    assert_eq!(page.matches("</script>").count(), 1);
    assert!(!page.contains("<aisle>") && !page.contains("<b>\"") && !page.contains("onload='"));
    assert!(page.contains("&lt;aisle&gt;"));
}

#[test]
fn swept_values_have_panels_of_their_own() {
    let place = tempfile::tempdir().expect("folder");
    let mut folder = Folder::new(&place.path().join("swept"), FIGURES);
    folder.sequence = Some(sequence());
    let mut jobs = Vec::new();
    for caches in [100, 200, 400] {
        let which = Which {
            scene: "atrium",
            view: "<aisle> + gallery",
            label: "IM",
            seed: 1,
            caches: Some(caches),
        };
        jobs.push(folder.job(which, (0.1, 0.1), None).job.clone());
    }
    folder.write();
    for job in &jobs {
        fs::write(
            folder.path.join("jobs").join(job).join("frames.csv"),
            frames_csv(),
        )
        .expect("csv");
    }
    write(&folder.path).expect("report");
    let svg = folder.text("figures/time-atrium.svg");
    for caches in [100, 200, 400] {
        assert_eq!(svg.matches(&format!("caches={caches}")).count(), 2);
    }
    assert_legible(&folder.path);
    // Two columns of frames.csv, each in two lines of two panels.
    let panel = |text: &str| {
        let start = svg.find(&format!(">{text}</text>"))?;
        let element = &svg[svg[..start].rfind("<text")?..start];
        let number = |key| {
            element
                .split(key)
                .nth(1)?
                .split('"')
                .next()?
                .parse::<f64>()
                .ok()
        };
        Some((number(" x=\"")?, number(" y=\"")?))
    };
    let places = ["caches=100", "caches=200", "caches=400"].map(|text| panel(text).expect("there"));
    assert!(places[0].1 == places[1].1 && places[0].0 < places[1].0);
    assert!(places[0].1 < places[2].1 && places[0].0 == places[2].0);
}
