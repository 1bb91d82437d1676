//! Results folders made by hand: rows and small images without rendering.

#[allow(dead_code, reason = "not every test looks at figures")]
pub mod boxes;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lightbench::experiment::{Budget, Config, Job, Plan, Row, Sequence, Store};
use lightbench::image::{Attributes, Image, Layer, Plane, write_exr};
use lightbench::technique::CACHES;

/// A results folder in the making.
pub struct Folder {
    pub path: PathBuf,
    config: Config,
    plan: Plan,
    rows: Vec<(Row, Option<Vec<Layer>>)>,
    /// Of the jobs that follow; a still unless it is set.
    pub sequence: Option<Sequence>,
}

/// Which job of an experiment.
#[derive(Clone, Copy)]
pub struct Which<'a> {
    pub scene: &'a str,
    pub view: &'a str,
    pub label: &'a str,
    pub seed: u64,
    /// Swept records, if they are swept.
    pub caches: Option<i64>,
}

impl Folder {
    /// A folder for an experiment file; `extra` is appended to its least form.
    pub fn new(path: &Path, extra: &str) -> Self {
        let text = format!(
            "name = \"synthetic\"\ntitle = \"Synthetic\"\ntechnique = \"ambient-occlusion\"\nscene = []\nmethod = []\n{extra}"
        );
        let config: Config = toml::from_str(&text).expect("a config");
        Self {
            path: path.to_owned(),
            plan: Plan {
                all: Vec::new(),
                sharded: None,
                selected_of: None,
                name: config.name.clone(),
                title: config.title.clone(),
                configs: vec!["configs/synthetic.toml".into()],
                overrides: vec!["scale=1/4".into()],
                jobs: Vec::new(),
                notes: Vec::new(),
            },
            config,
            rows: Vec::new(),
            sequence: None,
        }
    }

    /// Plans a job without a result.
    pub fn plan(&mut self, which: Which) -> Job {
        let sweep: BTreeMap<String, toml::Value> = which
            .caches
            .map(|c| ("caches".to_owned(), toml::Value::Integer(c)))
            .into_iter()
            .collect();
        let job = Job {
            metres_per_unit: None,
            max_depth: None,
            incomplete: false,
            id: lightbench::experiment::hash(&format!(
                "{} {} {} {} {sweep:?}",
                which.scene, which.view, which.label, which.seed
            )),
            scene: which.scene.into(),
            found: which.scene.into(),
            asked: which.scene.into(),
            paper: Some(which.scene.to_uppercase()),
            view: which.view.into(),
            sequence: self
                .sequence
                .clone()
                .unwrap_or_else(|| Sequence::still(which.view)),
            additions: None,
            shown: which.scene.into(),
            moves: false,
            transform: None,
            technique: "ambient-occlusion".into(),
            technique_parameters: toml::Table::new(),
            method: which.label.into(),
            label: which.label.into(),
            method_parameters: toml::Table::new(),
            environment: None,
            budget: Budget {
                unit: &CACHES,
                amount: which.caches.unwrap_or(7500) as f64,
            },
            seed: which.seed,
            width: 320,
            height: 180,
            spp: 4,
            sweep,
            also_at: Vec::new(),
            reference: "0123456789abcdef".into(),
            references: Default::default(),
            allow_non_finite: false,
        };
        self.plan.jobs.push(job.clone());
        job
    }

    /// Plans a job and gives it a result with these errors.
    pub fn job(
        &mut self,
        which: Which,
        (rmse, flip): (f64, f64),
        layers: Option<Vec<Layer>>,
    ) -> &mut Row {
        let job = self.plan(which);
        let mut row = Row {
            status: "ok".into(),
            rmse: Some(rmse),
            flip_ldr: Some(flip),
            caches: job.budget.count(),
            rays: 288_000,
            shadow_rays: job.budget.count().unwrap_or_default() * 1024,
            lookups: 230_400,
            bytes_work: 5_300_000,
            seconds_total: 0.4,
            cpu_seconds_total: 0.8,
            ..Row::default()
        };
        row.describe(&job, "synthetic");
        for (stage, seconds) in [
            ("shading_points", 0.05),
            ("placement", 0.02),
            ("rendering", 0.33),
        ] {
            row.seconds.insert(stage.into(), seconds.into());
            row.cpu_seconds.insert(stage.into(), (2.0 * seconds).into());
        }
        self.rows.push((row, layers));
        &mut self.rows.last_mut().expect("just pushed").0
    }

    /// Writes everything a run would have written.
    pub fn write(&self) {
        let store = Store::create(&self.path).expect("folder");
        let json = |value: serde_json::Result<String>| value.expect("serializes");
        store
            .write("plan.json", &json(serde_json::to_string(&self.plan)))
            .expect("plan");
        store
            .write("config.json", &json(serde_json::to_string(&self.config)))
            .expect("config");
        let provenance = r#"{"program":"lightbench 0.1.0","threads":2,"started_unix_seconds":1700000000,"overrides":["scale=1/4"]}"#;
        store
            .write("provenance.json", provenance)
            .expect("provenance");
        for (row, layers) in &self.rows {
            store
                .write_job(row, |folder| {
                    let Some(layers) = layers else { return Ok(()) };
                    let mut attributes = Attributes::new();
                    attributes.insert("exposure".into(), 0.0.into());
                    write_exr(&folder.join("image.exr"), layers, &attributes)
                        .map_err(std::io::Error::other)
                })
                .expect("job");
        }
        store.write_rows(&store.rows(&self.plan)).expect("rows");
    }

    pub fn text(&self, file: &str) -> String {
        std::fs::read_to_string(self.path.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
    }
}

/// What a file of a reference says beside its layers.
#[allow(dead_code, reason = "not every test leaves references")]
pub fn reference_attributes() -> Attributes {
    let mut attributes = Attributes::new();
    for key in ["samples", "wanted", "non_finite", "rays"] {
        attributes.insert(key.into(), 1.into());
    }
    attributes.insert("random".into(), true.into());
    attributes.insert("seconds".into(), 0.5.into());
    attributes
}

/// All layers that a job leaves, for a reference and a smooth error of some strength.
pub fn layers(reference: &Image, strength: f32) -> Vec<Layer> {
    let (width, height) = (reference.width, reference.height);
    let wave = |i: usize| {
        let (x, y) = ((i % width) as f32, (i / width) as f32);
        strength * ((x * 0.21).sin() * (y * 0.13).cos() * (x / width as f32)).powi(2)
    };
    let beauty = Image {
        pixels: reference
            .pixels
            .iter()
            .enumerate()
            .map(|(i, p)| p.map(|v| v - wave(i)))
            .collect(),
        ..reference.clone()
    };
    let plane = |value: &dyn Fn(usize) -> f32| Plane {
        width,
        height,
        values: (0..width * height).map(value).collect(),
    };
    let record = |i: usize| match (i * 2_654_435_761) % 97 {
        0..=3 => 1.0,
        4 => 2.0,
        _ => 0.0,
    };
    vec![
        Layer::color("beauty", beauty),
        Layer::color("reference", reference.clone()),
        Layer::gray("records", plane(&record)),
        Layer::gray("flip", plane(&wave)),
        Layer::gray("discontinuity", plane(&|i| wave(i + 7))),
    ]
}

/// A smooth image with an edge.
pub fn picture(width: usize, height: usize) -> Image {
    let mut image = Image::new(width, height);
    for (i, pixel) in image.pixels.iter_mut().enumerate() {
        let (x, y) = (
            (i % width) as f32 / width as f32,
            (i / width) as f32 / height as f32,
        );
        let ball = (x - 0.6).hypot(y - 0.5) < 0.25;
        *pixel = [if ball { 0.35 + x * 0.4 } else { 0.9 - 0.5 * y }; 3];
    }
    image
}
