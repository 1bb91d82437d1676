//! The page in a real browser: keys flip images, exposure changes pixels, a table sorts, the slider moves, and nothing
//! goes wrong on the way. Skipped, and said so, where there is no Chromium (`LIGHTBENCH_CHROMIUM` names one).

mod report_support;

use std::path::{Path, PathBuf};
use std::process::Command;

use lightbench::experiment::{LIGHTS_FILE, MAP_FILE, Sequence, Viewer};
use lightbench::image::{Attributes, Layer, write_exr, write_png};
use lightbench::report::{write, write_single_file};
use report_support::{Folder, Which, layers, picture, reference_attributes};

/// What a person does, as a script.
const PERSON: &str = include_str!("report_support/browser.js");
/// Kept frames and viewers of the sequence, and the key of the reference of all of them.
const SHOTS: [(u32, u32); 4] = [(0, 0), (0, 1), (3, 0), (3, 1)];
const KEY: &str = "00aa";
const LABELS: [&str; 3] = ["IM", "SD", "VGC+DGS"];

fn which(label: &str) -> Which<'_> {
    Which {
        scene: "statues",
        view: "main",
        label,
        seed: 1,
        caches: None,
    }
}

/// The browser, if there is one.
fn chromium() -> Option<PathBuf> {
    if let Some(asked) = std::env::var_os("LIGHTBENCH_CHROMIUM") {
        return Some(asked.into());
    }
    let folders = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let mut all = std::env::split_paths(&folders).flat_map(|f| names.map(|name| f.join(name)));
    all.find(|path| path.is_file())
}

/// Opens the page of a folder as a file, does what a person does, and returns what came of it.
fn use_page(browser: &Path, folder: &Folder, width: u32) -> String {
    let page = folder.text("report.html");
    let page = page.replace("</body>", &format!("<script>{PERSON}</script></body>"));
    let path = folder.path.join("test.html");
    std::fs::write(&path, page).expect("written");
    let output = Command::new(browser)
        .args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--dump-dom",
        ])
        .arg("--virtual-time-budget=60000")
        .arg(format!("--window-size={width},1000"))
        .arg(format!(
            "--user-data-dir={}",
            folder.path.join("browser").display()
        ))
        .arg(format!("file://{}", path.display()))
        .output()
        .expect("a browser that starts");
    let page = String::from_utf8_lossy(&output.stdout).into_owned();
    let told = page.split("<pre id=\"self-test\">").nth(1);
    let told = told.and_then(|t| t.split("</pre>").next());
    told.unwrap_or_else(|| panic!("{}\n{page}", String::from_utf8_lossy(&output.stderr)))
        .to_owned()
}

fn all_fine(told: &str) {
    let bad = told
        .lines()
        .find(|line| !line.starts_with("ok ") && *line != "end");
    assert!(bad.is_none() && told.ends_with("end"), "{told}");
    assert!(told.lines().count() > 15, "{told}");
}

#[test]
fn stills_are_compared_beside_the_page_and_in_it() {
    let Some(browser) = chromium() else {
        eprintln!("skipped: no Chromium");
        return;
    };
    let place = tempfile::tempdir().expect("folder");
    let mut folder = Folder::new(&place.path().join("stills"), "");
    let mut jobs = Vec::new();
    for (label, strength) in LABELS.into_iter().zip([0.6, 0.4, 0.2]) {
        let images = layers(&picture(96, 54), strength);
        let row = folder.job(which(label), (f64::from(strength), 0.1), Some(images));
        jobs.push(row.job.clone());
    }
    folder.write();
    for job in jobs {
        let job = folder.path.join("jobs").join(job);
        write_png(&job.join(MAP_FILE), &picture(64, 32), 0.0).expect("map");
        let lights = r#"{"lights":[[[0.2,0.3],"direct"],[[0.7,0.6],"indirect"]],"emissive":[]}"#;
        std::fs::write(job.join(LIGHTS_FILE), lights).expect("lights");
    }
    write(&folder.path).expect("report");
    all_fine(&use_page(&browser, &folder, 1400));
    std::fs::remove_dir_all(folder.path.join("figures/viewer")).expect("there");
    write_single_file(&folder.path).expect("report");
    all_fine(&use_page(&browser, &folder, 500));
}

#[test]
fn sequences_are_stepped_through() {
    let Some(browser) = chromium() else {
        eprintln!("skipped: no Chromium");
        return;
    };
    let place = tempfile::tempdir().expect("folder");
    let mut folder = Folder::new(&place.path().join("frames"), "");
    let viewer = |name: &str| Viewer::Path {
        name: name.into(),
        eye: 0,
        turn_deg: 0.0,
    };
    folder.sequence = Some(Sequence {
        frames: (0..4).collect(),
        fps: 10.0,
        viewers: vec![viewer("left"), viewer("right")],
        warm_up: 0,
        measure_every: 1,
        first_of: None,
        measure_run: 1,
        kept: vec![0, 3],
        cold: false,
        skip_unmeasured: false,
    });
    let image = |strength: f32, frame: u32| layers(&picture(96, 54), strength + 0.1 * frame as f32);
    let mut jobs = Vec::new();
    for (label, strength) in LABELS.into_iter().zip([0.6, 0.4, 0.2]) {
        let images = image(strength, 0);
        let row = folder.job(which(label), (f64::from(strength), 0.1), Some(images));
        jobs.push((row.job.clone(), strength));
    }
    folder.write();
    for (job, strength) in jobs {
        let job = folder.path.join("jobs").join(job);
        let line = |(frame, eye)| format!("{frame},{eye},0,true,0.1,0.1,{KEY}\n");
        let lines: String = SHOTS.into_iter().map(line).collect();
        let head = "frame,viewer,time_s,measured,rmse,flip_ldr,reference\n";
        std::fs::write(job.join("frames.csv"), format!("{head}{lines}")).expect("csv");
        let frames = job.join("frames");
        std::fs::create_dir_all(&frames).expect("folder");
        for (frame, eye) in SHOTS {
            let images = image(strength, frame);
            let name = |kind: &str| frames.join(format!("{frame:06}-{eye}.{kind}"));
            write_exr(&name("exr"), &images, &Attributes::new()).expect("exr");
            write_png(&name("png"), &picture(96, 54), 0.0).expect("png");
        }
    }
    let references = place.path().join("references");
    std::fs::create_dir(&references).expect("folder");
    let truth = ["mean", "deviations"].map(|name| Layer::color(name, picture(96, 54)));
    let path = references.join(format!("{KEY}.exr"));
    write_exr(&path, &truth, &reference_attributes()).expect("reference");
    write(&folder.path).expect("report");
    all_fine(&use_page(&browser, &folder, 1400));
}
