//! Golden tables: tiny experiments of every technique with every contender, against the numbers they gave before.
//!
//! `LIGHTBENCH_BLESS=1 cargo test --test golden` prints what differs and takes it over.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use lightbench::cache::interpolation::INTERPOLATIONS;
use lightbench::experiment::{
    COLUMNS, Cells, EXACT, FOUND, Job, Loaded, Row, RunOptions, Source, Store, Unit,
    build_technique, exact, kernel, plan, plan_image, run,
};
use lightbench::registry::TECHNIQUES;
use lightbench::technique::{TechniqueEntry, Terms};

const BLESS: &str = "LIGHTBENCH_BLESS";
/// Counts that the allocator has a say in.
const MEASURED: [&str; 2] = ["bytes_scene", "bytes_work"];
/// Columns that say what was run, not what came of it.
const GIVEN: [&str; 9] = [
    "frame",
    "frames",
    "frames_measured",
    "viewers",
    "rmse_worst",
    "seed",
    "width",
    "height",
    "spp",
];

/// A number of a row, by its technique, method and column.
type Numbers = BTreeMap<[String; 3], f64>;

/// What is small of an experiment on a technique; the methods are those of the registry.
fn experiment(technique: &str) -> &'static str {
    match technique {
        "ambient-occlusion" => {
            "parameters = { side = 8 }\ncaches = 40\n[[scene]]\nname = 'hard-cases'"
        }
        "irradiance-caching" => {
            "parameters = { side = 8, reference_passes = 8 }\ncaches = 40\n\
             [[scene]]\nname = 'cornell-curved'"
        }
        "importance-caching" => {
            "parameters = { lights = 64 }\ncaches = 40\n[[scene]]\nname = 'cornell-curved'"
        }
        "environment-lighting" => {
            "parameters = { reference_samples = 32, reference_passes = 4 }\nlights = 4\n\
             [[scene]]\nname = 'still-puzzle'\nenvironment = 'living-room'"
        }
        "path-tracing" => {
            "parameters = { reference_passes = 8 }\nsamples = 2\n\
             [[scene]]\nname = 'cornell-curved'"
        }
        "direct-lighting" | "radiance" => {
            "parameters = { reference_passes = 8 }\nsamples = 2\n\
             [[scene]]\nname = 'cornell-curved'"
        }
        other => panic!("no small experiment on {other}: add one"),
    }
}

/// The experiment with these methods.
fn source(entry: &TechniqueEntry, methods: &str) -> Source {
    let id = entry.about.id;
    let small = experiment(id);
    Source {
        file: format!("{id}.toml").into(),
        text: format!("name = '{id}'\ntechnique = '{id}'\nsize = [32, 24]\n{small}\n{methods}"),
    }
}

/// Every contender of a technique.
fn methods(entry: &TechniqueEntry) -> String {
    let config: toml::Table = source(entry, "").text.parse().expect("toml");
    let parameters = config["parameters"].as_table().expect("a table");
    let technique = (entry.build)(parameters).expect("parameters");
    let mut text = String::new();
    for listed in (entry.contenders)() {
        let _ = writeln!(text, "[[method]]\nid = '{}'", listed.id);
        let started = technique.start(&listed.id, &toml::Table::new(), Terms::default());
        if let Err(error) = started {
            // Gradients are no use to importance caching, and it says so.
            assert_eq!(error.key, "interpolation", "{error}");
            text.push_str("interpolation = 'inverse-distance'\n");
        }
    }
    text
}

/// The rows of all experiments, run once.
fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder");
        TECHNIQUES
            .iter()
            .flat_map(|entry| run_all(entry, folder.path()))
            .collect()
    })
}

fn run_all(entry: &TechniqueEntry, folder: &Path) -> Vec<Row> {
    let (config, plan) = plan(&source(entry, &methods(entry)), &[]).expect("plans");
    let options = RunOptions {
        folder: folder.join(&config.name),
        references: folder.join("references"),
        fail_fast: false,
        quiet: true,
        checkpoint_every: std::time::Duration::MAX,
    };
    run(&plan, &config, &options).expect("runs");
    let rows = Store::open(&options.folder).expect("results").rows(&plan);
    assert_eq!(rows.len(), plan.jobs.len());
    for row in &rows {
        assert!(row.ok(), "{} {}: {}", row.technique, row.label, row.status);
    }
    rows
}

/// Counts, metrics and what methods found.
fn numbers_of_row(row: &Row, numbers: &mut Numbers) {
    let mut put = |column: &str, value: Option<f64>| {
        let key = [&row.technique, &row.label, column].map(str::to_owned);
        value.map(|value| numbers.insert(key, value));
    };
    for column in COLUMNS {
        match column.cells {
            _ if MEASURED.contains(&column.key) || GIVEN.contains(&column.key) => {}
            Cells::Count(get) => put(column.key, get(row).map(|n| n as f64)),
            Cells::Number(get) if column.unit != Unit::Seconds => put(column.key, get(row)),
            _ => {}
        }
    }
    for (key, value) in &row.params {
        put(&format!("params.{key}"), value.as_f64());
    }
}

/// Rays and mean of the exact function.
fn numbers_of_truth(entry: &TechniqueEntry, numbers: &mut Numbers) {
    let text = source(entry, &format!("[[method]]\nid = '{EXACT}'"));
    let job: Job = plan_image(&text.parse().expect("a config")).expect("plans");
    let technique = build_technique(&job).expect("parameters");
    let mut loaded = Loaded::new(&job, technique.as_ref()).expect("loads");
    let views = loaded.views(&job, 0).expect("a view");
    let shot = loaded.shot(&job, 0, &views[0], technique.as_ref());
    let rendered = exact(technique.as_ref(), &shot);
    let values = rendered.image.pixels.as_flattened();
    let sum: f64 = values.iter().map(|&value| f64::from(value)).sum();
    for (column, value) in [
        ("rays", rendered.rays.closest as f64),
        ("shadow_rays", rendered.rays.shadow as f64),
        ("non_finite", rendered.non_finite as f64),
        ("mean", sum / values.len() as f64),
    ] {
        let key = [entry.about.id, EXACT, column].map(str::to_owned);
        numbers.insert(key, value);
    }
}

/// How far a number may be from the golden one, of its magnitude.
fn tolerance(column: &str) -> f64 {
    let counted = COLUMNS
        .iter()
        .any(|c| c.key == column && matches!(c.cells, Cells::Count(_)));
    if counted { 0.0 } else { 1e-4 }
}

fn golden_file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/rows.csv")
}

fn read(file: &Path) -> Numbers {
    let Ok(text) = std::fs::read_to_string(file) else {
        return Numbers::new();
    };
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let records = reader.records().map(|record| {
        let record = record.expect("four cells");
        let key = [&record[0], &record[1], &record[2]].map(str::to_owned);
        (key, record[3].parse().expect("a number"))
    });
    records.collect()
}

fn write(file: &Path, numbers: &Numbers) {
    let mut writer = csv::Writer::from_path(file).expect("writable");
    let header = ["technique", "label", "column", "value"];
    writer.write_record(header).expect("writes");
    for (key, value) in numbers {
        let [technique, label, column] = key;
        let cells = [technique, label, column, &value.to_string()];
        writer.write_record(cells).expect("writes");
    }
    writer.flush().expect("writes");
}

/// A line for each number that is not as the golden table has it.
fn differences(golden: &Numbers, now: &Numbers) -> Vec<String> {
    let keys: std::collections::BTreeSet<_> = golden.keys().chain(now.keys()).collect();
    let text = |value: Option<&f64>| value.map_or("nothing".to_owned(), f64::to_string);
    let differs = |key: &[String; 3]| match (golden.get(key), now.get(key)) {
        (Some(a), Some(b)) => (a - b).abs() > tolerance(&key[2]) * a.abs().max(b.abs()),
        _ => true,
    };
    keys.into_iter()
        .filter(|key| differs(key))
        .map(|key| {
            let (before, after) = (text(golden.get(key)), text(now.get(key)));
            format!("{}: {before} → {after}", key.join(" "))
        })
        .collect()
}

/// The wide kernels answer alike. Others decide otherwise about rays near edges, which moves records and changes
/// every number after them: they are not compared.
#[test]
fn every_contender_gives_its_golden_numbers() {
    if !kernel().starts_with("wide") {
        println!("not compared: the golden numbers are those of the wide kernels");
        return;
    }
    let mut now = Numbers::new();
    rows().iter().for_each(|row| numbers_of_row(row, &mut now));
    TECHNIQUES
        .iter()
        .for_each(|entry| numbers_of_truth(entry, &mut now));
    let golden = read(&golden_file());
    let differences = differences(&golden, &now);
    let told = differences.join("\n");
    if std::env::var_os(BLESS).is_some() {
        println!("{} numbers differ\n{told}", differences.len());
        write(&golden_file(), &now);
        return;
    }
    assert!(
        differences.is_empty(),
        "{} numbers are not the golden ones; {BLESS}=1 cargo test --test golden takes them over\n{told}",
        differences.len()
    );
}

/// What stands in `params` is a parameter of the technique's contenders, or found and then declared.
#[test]
fn what_contenders_find_is_declared() {
    let found: Vec<&str> = FOUND.iter().map(|column| column.key).collect();
    let mut seen = 0;
    for row in rows() {
        let entry = lightbench::registry::technique(&row.technique).expect("listed");
        let parts = (entry.contenders)().into_iter().flat_map(|c| c.parts);
        let interpolations = INTERPOLATIONS.iter().map(|e| &e.about);
        let entries = parts.chain(interpolations).chain([&entry.about]);
        let parameters: Vec<&str> = entries
            .flat_map(|about| about.parameters.iter().map(|p| p.key))
            .collect();
        for key in row.params.keys() {
            seen += usize::from(found.contains(&key.as_str()));
            assert!(
                found.contains(&key.as_str())
                    || parameters.contains(&key.as_str())
                    || key == "interpolation",
                "{} {}: `{key}` is no parameter and not in the table FOUND of src/experiment/columns",
                row.technique,
                row.label
            );
        }
    }
    assert!(seen > 20, "contenders find something: {seen}");
}
