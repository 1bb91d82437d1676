//! The hard cases: gaps, odd and damaged images, names of special characters, nothing at all.

use lightbench::image::Image;
use lightbench::report::{ReportError, write};

use super::report_support::{Folder, layers, picture};
use super::{EVERYTHING, METHODS, complete, which};

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
