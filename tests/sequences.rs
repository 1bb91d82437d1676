//! Sequences: a still camera gives its still again, viewers do not know of each other, frames do not depend on
//! threads, and an interrupted sequence goes on to the same bits.

use std::path::Path;
use std::time::Duration;

use lightbench::experiment::{Config, Plan, Row, RunOptions, Source, Store, plan, run};
use lightbench::technique::Terms;

/// A room with a block that turns, a lamp that moves and fades, and a sky that turns, seen from five paths.
const SCENE: &str = r#"
metres_per_unit = 1
ao_distance = 1
[[view]]
origin = [0, 1, 4]
target = [0, 0.5, 0]
fov_deg = 50
[[shape]]
kind = "rectangle"
name = "floor"
scale = 4
rotate = [1, 0, 0, -90]
[[shape]]
kind = "cube"
name = "block"
scale = 0.5
translate = [0, 0.5, 0]
[[shape]]
kind = "sphere"
name = "lamp"
centre = [1, 2, 1]
radius = 0.3
emission = 4
[[light]]
kind = "point"
name = "bulb"
position = [-1, 2, 1]
intensity = 3
[environment]
kind = "sky"
sun = false
[[motion]]
shape = "block"
keys = [{ time = 0, rotate_deg = 0 }, { time = 1, rotate_deg = 90, translate = [0.5, 0, 0] }]
[[motion]]
shape = "lamp"
keys = [{ time = 0, translate = [0, 0, 0], emission = 1 }, { time = 1, translate = [-1, 0, 0], emission = 2 }]
[[motion]]
light = "bulb"
keys = [{ time = 0, on = true }, { time = 0.3, on = false }]
[[motion]]
environment = true
keys = [{ time = 0, rotate_deg = 0 }, { time = 1, rotate_deg = 180 }]
"#;

const PATHS: &str = r#"
[[path]]
name = "a"
keys = [{ time = 0, view = "main" }, { time = 1, view = "main", move = [1, 0.5, 1] }]
[[path]]
name = "b"
keys = [{ time = 0, view = "main", move = [-1, 0, 0] }, { time = 1, view = "main" }]
[[path]]
name = "c"
keys = [{ time = 0, origin = [3, 1, 0], target = [0, 0.5, 0], fov_deg = 60 }, { time = 1, origin = [3, 2, -2], target = [0, 0, 0] }]
[[path]]
name = "d"
keys = [{ time = 0, view = "main", move = [0, 1, 0], target = [0, 0.5, 0] }]
"#;

/// What each technique is run with, its contenders without memory.
const TECHNIQUES: [(&str, &str); 7] = [
    (
        "ambient-occlusion",
        "caches = 30\nparameters = { side = 8 }\n[[method]]\nid = 'SD'\n[[method]]\nid = 'VGC+DGS'\n[[method]]\nid = 'per-sample'\n",
    ),
    (
        "irradiance-caching",
        "caches = 20\nparameters = { side = 8, reference_passes = 4 }\n[[method]]\nid = 'IM'\n[[method]]\nid = 'VGC+AS'\n[[method]]\nid = 'on-demand'\n",
    ),
    (
        "importance-caching",
        "caches = 20\nparameters = { lights = 64 }\n[[method]]\nid = 'VGC+DGS'\n",
    ),
    (
        "environment-lighting",
        "lights = 4\nparameters = { reference_samples = 16, reference_passes = 2 }\n[[method]]\nid = 'decomposition'\n[[method]]\nid = 'product-ratio'\n[[method]]\nid = 'mis'\n",
    ),
    (
        "direct-lighting",
        "samples = 1\nparameters = { reference_passes = 4 }\n[[method]]\nid = 'paths'\n[[method]]\nid = 'rt'\n",
    ),
    (
        "radiance",
        "samples = 1\nparameters = { reference_passes = 4 }\n[[method]]\nid = 'paths'\n[[method]]\nid = 'filtered-paths'\n",
    ),
    (
        "path-tracing",
        "samples = 1\nparameters = { reference_passes = 4 }\n[[method]]\nid = 'paths'\n",
    ),
];

/// Contenders of which each frame is made of other samples.
const RANDOM: [&str; 3] = ["paths", "rt", "filtered-paths"];

#[test]
fn every_technique_is_played() {
    for entry in lightbench::registry::TECHNIQUES {
        let id = entry.about.id;
        assert!(TECHNIQUES.iter().any(|(played, _)| *played == id), "{id}");
    }
}

/// An experiment on the scene, in a folder of its own.
struct Experiment<'a> {
    place: &'a Path,
    name: &'a str,
    technique: &'a str,
    /// Methods and budget.
    settings: &'a str,
    sequence: &'a str,
}

/// A line of `frames.csv`, its names and cells.
type Line = Vec<(String, String)>;

impl Experiment<'_> {
    fn run(&self) -> Vec<(Row, Vec<Line>)> {
        self.run_with(Duration::MAX)
    }

    fn planned(&self) -> (Config, Plan) {
        std::fs::write(self.place.join("room.toml"), SCENE).expect("writable");
        let head = self.settings.split("[[method]]").next().unwrap_or("");
        let methods = &self.settings[head.len()..];
        let text = format!(
            "name = '{}'\ntechnique = '{}'\nsize = [24, 16]\n{head}\n{}\n{PATHS}\n[[scene]]\nname = '{}'\n{methods}",
            self.name,
            self.technique,
            self.sequence,
            self.place.join("room.toml").display(),
        );
        let source = Source {
            file: self.place.join("config.toml"),
            text,
        };
        plan(&source, &[]).unwrap_or_else(|e| panic!("{e}"))
    }

    fn run_with(&self, checkpoint_every: Duration) -> Vec<(Row, Vec<Line>)> {
        let (config, plan) = self.planned();
        let options = RunOptions {
            folder: self.place.join(self.name),
            references: self.place.join("references"),
            fail_fast: false,
            quiet: true,
            checkpoint_every,
        };
        run(&plan, &config, &options).expect("runs");
        let store = Store::open(&options.folder).expect("results");
        let rows = store.rows(&plan);
        assert_eq!(rows.len(), plan.jobs.len());
        rows.into_iter()
            .map(|row| {
                assert!(row.ok(), "{} {}: {}", row.technique, row.label, row.status);
                let frames = store.job_folder(&row.job).join("frames.csv");
                let lines = if frames.exists() {
                    lines(&frames)
                } else {
                    Vec::new()
                };
                (row, lines)
            })
            .collect()
    }
}

/// Runs a technique with its settings over a sequence, in a folder for several such runs.
fn run_in(
    place: &Path,
    name: &str,
    (technique, settings): (&str, &str),
    sequence: &str,
) -> Vec<(Row, Vec<Line>)> {
    let experiment = Experiment {
        place,
        name,
        technique,
        settings,
        sequence,
    };
    experiment.run()
}

/// The lines of a file but for what differs from run to run: times, and memory as the allocator sees it.
fn lines(file: &Path) -> Vec<Line> {
    let mut reader = csv::Reader::from_path(file).expect("frames.csv");
    let names = reader.headers().expect("names").clone();
    let measured = |name: &str| name.contains("seconds") || name == "bytes_work";
    let line = |record: csv::StringRecord| {
        let cells = names.iter().zip(&record);
        cells
            .filter(|(name, _)| !measured(name))
            .map(|(name, cell)| (name.to_owned(), cell.to_owned()))
            .collect()
    };
    reader.records().map(|r| line(r.expect("a line"))).collect()
}

fn without(line: &Line, names: &[&str]) -> Line {
    let kept = line
        .iter()
        .filter(|(name, _)| !names.contains(&name.as_str()));
    kept.cloned().collect()
}

fn errors(row: &Row) -> String {
    format!(
        "{:?}",
        [
            row.rmse,
            row.relmse,
            row.psnr,
            row.ssim,
            row.flip_ldr,
            row.flip_hdr,
            row.reference_floor
        ]
    )
}

#[test]
fn a_static_camera_gives_its_still_ten_times_but_for_random_paths() {
    for (technique, settings) in TECHNIQUES {
        let place = tempfile::tempdir().expect("a folder");
        let of = |name, sequence| run_in(place.path(), name, (technique, settings), sequence);
        let still = of("still", "");
        // Frames so close in time that nothing has moved.
        let frames = of("frames", "[sequence]\nframes = 10\nfps = 1e300");
        for ((still, none), (row, lines)) in still.iter().zip(&frames) {
            let label = format!("{technique} {}", still.label);
            assert!(none.is_empty(), "a still has no frames.csv");
            assert_eq!(lines.len(), 10, "{label}");
            assert_eq!((row.frames, row.viewers), (10, 1));
            // Paths are others in each frame: their noise flickers as a renderer's does.
            let random = RANDOM.contains(&still.label.as_str());
            for line in lines {
                // Of a scene that moves, keys of references tell the time.
                let changes = ["frame", "time_s", "error_change", "reference"];
                let first = without(&lines[0], &changes);
                let alike = first == without(line, &changes);
                assert_eq!(alike, !random || line[0].1 == "0", "{label}: {line:?}");
            }
            let cell = |name: &str| {
                lines[if random { 0 } else { 9 }]
                    .iter()
                    .find(|(n, _)| n == name)
                    .expect(name)
                    .1
                    .clone()
            };
            assert_eq!(
                cell("rmse"),
                format!("{:?}", still.rmse.expect("measured")),
                "{label}"
            );
            assert_eq!(cell("rays"), still.rays.to_string(), "{label}");
            assert_eq!(row.flicker == Some(0.0), !random, "{label}");
            if !random {
                assert_eq!(row.rays, 10 * still.rays, "{label}");
            }
        }
    }
}

/// What a technique is run with, every contender of the registry that starts with its usual settings among its methods,
/// those that remember too.
fn with_every_method(technique: &str, settings: &str) -> String {
    let entry = lightbench::registry::technique(technique).expect("registered");
    let built = (entry.build)(&toml::Table::new()).expect("usual settings");
    let starts = |id: &str| {
        let started = built.start(id, &toml::Table::new(), Terms::default());
        started.is_ok()
    };
    let mut all = settings.split("[[method]]").next().unwrap_or("").to_owned();
    for listed in (entry.contenders)().iter().filter(|l| starts(&l.id)) {
        all += &format!("[[method]]\nid = '{}'\n", listed.id);
    }
    all
}

/// Stages of all are on the page of charges.
#[test]
fn a_sequence_of_one_frame_is_a_still_to_the_bit_with_memory_and_without() {
    let page = std::fs::read_to_string("docs/fairness.md").expect("a page");
    for (technique, settings) in TECHNIQUES {
        let place = tempfile::tempdir().expect("a folder");
        let settings = &with_every_method(technique, settings);
        let of = |name, sequence| Experiment {
            place: place.path(),
            name,
            technique,
            settings,
            sequence,
        };
        let still = of("still", "").run();
        let one = of("one", "[sequence]\nframes = 1").planned().1.jobs;
        let along = of("along", "[sequence]\nframes = 1\npath = 'a'").run();
        assert_eq!((one.len(), along.len()), (still.len(), still.len()));
        for ((still, _), (one, (along, _))) in still.iter().zip(one.iter().zip(&along)) {
            assert_eq!(still.job, one.id, "{technique}: the same job");
            for stage in still.seconds.keys() {
                let name = format!("`{stage}`");
                assert!(page.contains(&name), "{technique} {}: {name}", still.label);
            }
            // The path begins at the view.
            assert_eq!(errors(still), errors(along), "{technique} {}", still.label);
            assert_eq!(
                (still.rays, still.shadow_rays),
                (along.rays, along.shadow_rays)
            );
        }
    }
}

#[test]
fn four_viewers_are_four_single_runs_with_any_number_of_threads() {
    const FRAMES: &str = "[sequence]\nframes = 3\nfps = 2\n";
    for (technique, settings) in TECHNIQUES {
        let place = tempfile::tempdir().expect("a folder");
        let run = |name: &str, sequence: &str| {
            run_in(place.path(), name, (technique, settings), sequence)
        };
        let together = run("all", &format!("{FRAMES}viewers = ['a', 'b', 'c', 'd']"));
        let single_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let single_thread = single_thread.expect("a pool");
        for (viewer, name) in ["a", "b", "c", "d"].iter().enumerate() {
            let alone = single_thread.install(|| run(name, &format!("{FRAMES}path = '{name}'")));
            for ((row, all), (_, one)) in together.iter().zip(&alone) {
                assert_eq!(all.len(), 12);
                let viewer = viewer.to_string();
                let of_viewer =
                    |line: &&Line| line.iter().any(|(n, v)| n == "viewer" && *v == viewer);
                let all: Vec<Line> = all
                    .iter()
                    .filter(of_viewer)
                    .map(|line| without(line, &["viewer"]))
                    .collect();
                let one: Vec<Line> = one.iter().map(|line| without(line, &["viewer"])).collect();
                assert_eq!(all, one, "{technique} {} of viewer {name}", row.label);
            }
        }
    }
}

#[test]
fn frames_see_what_moves() {
    let place = tempfile::tempdir().expect("a folder");
    for (technique, settings) in [TECHNIQUES[0], TECHNIQUES[3], TECHNIQUES[4]] {
        let experiment = Experiment {
            place: place.path(),
            name: technique,
            technique,
            settings,
            sequence: "[sequence]\nframes = 5\nfps = 4\nwarm_up = 1\nmeasure_every = 2\nkeep = 'all'",
        };
        for (row, lines) in experiment.run() {
            let cells = |name: &str| -> Vec<String> {
                let cell =
                    |line: &Line| line.iter().find(|(n, _)| n == name).expect(name).1.clone();
                lines.iter().map(cell).collect()
            };
            assert_eq!(
                cells("measured"),
                ["false", "true", "false", "true", "false"]
            );
            let references = cells("reference");
            assert!(references[0].is_empty() && references[1] != references[3]);
            let errors = cells("rmse");
            assert!(
                errors[1] != errors[3],
                "{technique} {}: {errors:?}",
                row.label
            );
            // Neighbours were not measured.
            assert_eq!(row.flicker, None);
            assert_eq!((row.frames_measured, row.frame), (2, 3));
        }
    }
}

#[test]
fn checkpoints_change_nothing_and_memory_helps() {
    let place = tempfile::tempdir().expect("a folder");
    let experiment = |name| Experiment {
        place: place.path(),
        name,
        technique: "path-tracing",
        settings: "samples = 1\nparameters = { reference_passes = 4 }\n[[method]]\nid = 'running-mean'\n",
        sequence: "[sequence]\nframes = 8\nfps = 80\nviewers = ['a', 'c']\ncold = true",
    };
    let whole = experiment("whole").run();
    let saved = experiment("saved").run_with(Duration::ZERO);
    assert_eq!(whole[0].1, saved[0].1);
    assert!(whole[0].0.rmse_cold > whole[0].0.rmse, "memory helps");
}

#[test]
fn frames_that_nobody_looks_at_may_be_left_out_by_contenders_without_memory() {
    let place = tempfile::tempdir().expect("a folder");
    let settings = "samples = 1\nparameters = { reference_passes = 4 }\n[[method]]\nid = 'paths'\n[[method]]\nid = 'running-mean'\n";
    let sequence = "[sequence]\nframes = 9\nfps = 80\nviewers = ['a', 'c']\nwarm_up = 2\nmeasure_every = 3\nkeep = [0, 5]";
    let technique = ("path-tracing", settings);
    let played = run_in(place.path(), "played", technique, sequence);
    let skipping = format!("{sequence}\nskip_unmeasured = true");
    let skipped = run_in(place.path(), "skipped", technique, &skipping);
    let [(all, all_lines), (remembering, remembered)] = &played[..] else {
        panic!("two rows");
    };
    let (some, some_lines) = &skipped[0];
    assert_eq!(errors(all), errors(some));
    assert_eq!((all.flicker, some.flicker), (None, None));
    assert_eq!((all.frames, some.frames, some.frames_measured), (9, 4, 3));
    let costs = [all, some].map(|row| row.number("rays_per_image").expect("a cost"));
    assert!((costs[0] / costs[1] - 1.0).abs() < 0.1, "{costs:?}");
    assert!(
        some.notes[0].starts_with("4 of 9 frames"),
        "{:?}",
        some.notes
    );
    let frame = |line: &Line| {
        line.iter()
            .find(|(name, _)| name == "frame")
            .expect("named")
            .1
            .clone()
    };
    let kept: Vec<Line> = all_lines
        .iter()
        .filter(|line| ["0", "2", "5", "8"].contains(&frame(line).as_str()))
        .cloned()
        .collect();
    assert_eq!(&kept, some_lines);
    assert_eq!(remembered, &skipped[1].1, "what remembers sees every frame");
    assert_eq!(remembering.notes, skipped[1].0.notes);
}
