//! `render`: one image; and the single contender that `caches` shares.

use std::collections::HashSet;

use toml::{Table, Value};

use super::args::{ContenderArgs, RenderArgs};
use super::exit::{self, Failure};
use super::out::say;
use super::run::set_threads;
use crate::experiment::{
    Config, EXACT, Job, Loaded, Override, build_technique, exact, plan_image, render_job,
};
use crate::image::{Attributes, Layer, write_exr, write_png};
use crate::registry::technique_named;
use crate::scene::Scene;
use crate::standard_error::tell;
use crate::technique::{Rendered, Technique, TechniqueEntry, Terms};

/// What `--set` replaces of the scene.
const OF_SCENE: [&str; 4] = ["max_depth", "ao_distance", "metres_per_unit", "environment"];

/// A planned job of one image, and its loaded scene.
pub struct Prepared {
    pub job: Job,
    pub technique: Box<dyn Technique>,
    loaded: Loaded,
}

impl Prepared {
    /// Plans the job, which checks everything that can be checked before the scene is loaded, then loads it.
    pub fn new(args: &ContenderArgs) -> Result<Self, Failure> {
        set_threads(args.threads)?;
        let job = plan_image(&experiment(args)?)?;
        let technique = build_technique(&job)?;
        let loaded = Loaded::new(&job, technique.as_ref())?;
        for note in loaded.world.scene().report.sentences() {
            tell!("note: {note}");
        }
        Ok(Self {
            job,
            technique,
            loaded,
        })
    }

    /// The scene as it was loaded.
    pub fn scene(&self) -> &Scene {
        self.loaded.world.scene()
    }

    /// Whether the exact function is rendered.
    pub fn is_exact(&self) -> bool {
        self.job.method == EXACT
    }

    /// Renders the contender, or the exact function, and tells its notes.
    pub fn render(&mut self) -> Result<Rendered, Failure> {
        let rendered = self.rendered()?;
        for note in &rendered.notes {
            tell!("note: {note}");
        }
        Ok(rendered)
    }

    fn rendered(&mut self) -> Result<Rendered, Failure> {
        let is_exact = self.is_exact();
        let (job, technique) = (&self.job, self.technique.as_ref());
        let frame = job.sequence.representative();
        let views = self.loaded.views(job, frame).map_err(Failure::job)?;
        let mut shot = self.loaded.shot(job, frame, &views[0], technique);
        if is_exact {
            return Ok(exact(technique, &shot));
        }
        shot.layer = technique.shared_layer(&shot);
        let started = technique.start(&job.method, &job.method_parameters, Terms::default())?;
        let (searches, remembers) = (started.contender.searches(), started.contender.remembers());
        let reference = searches.then(|| exact(technique, &shot).image);
        let mut rendered =
            render_job(job, technique, &shot, reference.as_ref()).map_err(Failure::job)?;
        if remembers && frame > 0 {
            rendered.notes.push(format!(
                "{} learns from earlier frames, and of this image there were none: it begins at --time; `run` plays a [sequence]",
                job.method
            ));
        }
        Ok(rendered)
    }
}

/// The experiment of one scene and one method that a command line describes.
fn experiment(args: &ContenderArgs) -> Result<Config, Failure> {
    let entry = technique_named(&args.technique).map_err(Failure::usage)?;
    let method = args.method.as_deref().unwrap_or(entry.default_method);
    let mut settings = Settings::read(args, entry)?;
    if let Some(key) = settings.method.keys().next()
        && method.eq_ignore_ascii_case(EXACT)
    {
        let known: Vec<&str> = entry.about.parameters.iter().map(|p| p.key).collect();
        return Err(Failure::usage(format!(
            "--set {key}: no such parameter of {}; known: {}, and {} of the scene",
            entry.about.id,
            known.join(", "),
            OF_SCENE.join(", ")
        )));
    }
    settings.method.insert("id".into(), method.into());
    let scene = &mut settings.scene;
    scene.insert("name".into(), args.scene.as_str().into());
    // One image is for looking at: what is absent of it is told, but no light may be.
    scene.insert("incomplete".into(), true.into());
    if let Some(view) = &args.view {
        scene.insert("view".into(), view.as_str().into());
    }
    if let Some(text) = &args.size {
        scene.insert("size".into(), parse_size(text)?.to_vec().into());
    }
    if let Some(count) = args.budget {
        let unit = entry.units[0];
        if count == 0 || count as f64 > unit.most {
            return Err(Failure::usage(format!(
                "--budget {count}: expected 1 to {} {}, the budget of {}",
                unit.most, unit.heading, entry.about.id
            )));
        }
        if method.eq_ignore_ascii_case(EXACT) {
            let contenders = (entry.contenders)();
            let example = contenders.first().map_or("", |listed| &listed.id);
            return Err(Failure::usage(format!(
                "--budget {count}: `{EXACT}`, the method of this image, has no budget but the samples of --spp: give those, or \
                 another method, for example --method {example}"
            )));
        }
        scene.insert(unit.key.into(), (count as i64).into());
    }
    let mut sequence = Table::new();
    if let Some(path) = &args.path {
        sequence.insert("path".into(), path.as_str().into());
    }
    if args.time < 0.0 || !args.time.is_finite() {
        return Err(Failure::usage("--time: expected seconds, 0 or more"));
    }
    let (frame, fps) = match args.time {
        0.0 => (0, 1.0),
        time_s => (1, 1.0 / time_s),
    };
    sequence.insert("frames".into(), vec![Value::Integer(frame)].into());
    sequence.insert("fps".into(), fps.into());
    let experiment: [(&str, Value); 7] = [
        ("sequence", sequence.into()),
        ("name", "image".into()),
        ("technique", entry.about.id.into()),
        ("parameters", settings.technique.into()),
        ("spp", i64::from(args.spp).into()),
        ("scene", vec![settings.scene].into()),
        ("method", vec![settings.method].into()),
    ];
    let experiment = experiment.map(|(key, value)| (key.to_owned(), value));
    let mut config: Config = Table::from_iter(experiment)
        .try_into()
        .map_err(|error| Failure::usage(error.to_string().trim_end()))?;
    config.seed = args.seed;
    Ok(config)
}

/// The values of `--set`, by what they are settings of.
struct Settings {
    scene: Table,
    technique: Table,
    method: Table,
}

impl Settings {
    fn read(args: &ContenderArgs, entry: &TechniqueEntry) -> Result<Self, Failure> {
        let mut settings = Self {
            scene: Table::new(),
            technique: Table::new(),
            method: Table::new(),
        };
        let takes = |key: &str| entry.about.parameters.iter().any(|p| p.key == key);
        if takes("seed") {
            let seed = Value::Integer(args.seed as i64);
            settings.technique.insert("seed".into(), seed);
        }
        let mut given = HashSet::new();
        for text in &args.settings {
            let Override { key, values } = Override::parse(text)?;
            let [value] = values.as_slice() else {
                let message = format!("--set {text}: one value is expected here");
                return Err(Failure::usage(message));
            };
            let of = match key.as_str() {
                key if OF_SCENE.contains(&key) => &mut settings.scene,
                key if takes(key) => &mut settings.technique,
                _ => &mut settings.method,
            };
            if !given.insert(key.clone()) {
                let message =
                    format!("--set {text}: `{key}` is set twice; leave one of the two out");
                return Err(Failure::usage(message));
            }
            of.insert(key, value.clone());
        }
        Ok(settings)
    }
}

fn parse_size(text: &str) -> Result<[i64; 2], Failure> {
    text.split_once(['x', 'X'])
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]))
        .filter(|[w, h]| *w > 0 && *h > 0)
        .ok_or_else(|| {
            Failure::usage(format!(
                "--size {text}: expected WIDTHxHEIGHT in pixels, for example 480x270"
            ))
        })
}

/// Renders and writes one image.
pub fn run(args: &RenderArgs) -> Result<u8, Failure> {
    let png = match args.out.extension().and_then(|e| e.to_str()) {
        Some("png") => true,
        Some("exr") => false,
        _ => {
            return Err(Failure::usage(format!(
                "--out {}: expected a .exr or .png file",
                args.out.display()
            )));
        }
    };
    let mut prepared = Prepared::new(&args.contender)?;
    let rendered = prepared.render()?;
    let exposure = prepared.technique.exposure_stops(prepared.scene());
    if png {
        write_png(&args.out, &rendered.image, exposure)?;
    } else {
        let mut attributes = Attributes::new();
        attributes.insert("scene".into(), prepared.scene().name.clone().into());
        attributes.insert("method".into(), prepared.job.method.as_str().into());
        attributes.insert("exposure".into(), f64::from(exposure).into());
        write_exr(
            &args.out,
            &[Layer::color("beauty", rendered.image.clone())],
            &attributes,
        )?;
    }
    report(args, &prepared, &rendered)?;
    Ok(exit::OK)
}

fn report(args: &RenderArgs, prepared: &Prepared, rendered: &Rendered) -> Result<(), Failure> {
    let job = &prepared.job;
    let stages: serde_json::Map<String, serde_json::Value> = rendered
        .stages
        .0
        .iter()
        .map(|stage| (stage.name.to_owned(), stage.seconds.wall.into()))
        .collect();
    let found: serde_json::Map<String, serde_json::Value> = rendered
        .found
        .iter()
        .map(|(key, value)| ((*key).to_owned(), (*value).into()))
        .collect();
    if args.json {
        let mut notes = prepared.scene().report.sentences();
        notes.extend_from_slice(&rendered.notes);
        let record = serde_json::json!({
            "scene": prepared.scene().name,
            "technique": job.technique,
            "method": job.method,
            "width": job.width,
            "height": job.height,
            "spp": job.spp,
            "seed": job.seed,
            "exposure_stops": prepared.technique.exposure_stops(prepared.scene()),
            "caches": rendered.records.len(),
            "lights": rendered.lights.as_ref().map(|set| set.lights.len()),
            "rays": rendered.rays.closest,
            "shadow_rays": rendered.rays.shadow,
            "lookups": rendered.lookups,
            "non_finite": rendered.non_finite,
            "seconds_total": rendered.stages.total().wall,
            "seconds": stages,
            "found": found,
            "notes": notes,
        });
        say!("{record:#}");
    } else {
        for stage in &rendered.stages.0 {
            tell!("{:<20} {:>8.3} s", stage.name, stage.seconds.wall);
        }
    }
    Ok(())
}
