//! `render`: one image; and the single contender that `caches` shares.

use crate::environment::EnvironmentDescription;
use toml::{Table, Value};

use super::args::{ContenderArgs, RenderArgs};
use super::exit::{self, Failure};
use super::out::say;
use super::run::set_threads;
use crate::experiment::Override;
use crate::image::{Attributes, Layer, write_exr, write_png};
use crate::scene::{Scene, SceneDescription, find_environment, find_scene};
use crate::technique::{
    Choice, Film, Passes, Rendered, Shot, Stages, Technique, TechniqueEntry, Terms, Unit,
};
use crate::trace::{RayCounter, Tracer};
use crate::world::Moment;

/// A contender that was checked, and its loaded scene.
pub struct Prepared {
    pub technique: Box<dyn Technique>,
    /// Canonical id of the method; `None` for the method `reference`.
    method: Option<String>,
    parameters: Table,
    pub scene: Scene,
    tracer: Tracer,
    size: [usize; 2],
    view: usize,
    spp: u32,
    budget: usize,
    seed: u64,
}

impl Prepared {
    /// Checks everything that can be checked before the scene is loaded, then loads it.
    pub fn new(args: &ContenderArgs) -> Result<Self, Failure> {
        set_threads(args.threads)?;
        let entry = technique_entry(&args.technique)?;
        let mut description = find_scene(&args.scene)?;
        let (parameters, technique) = settings(args, entry, &mut description)?;
        let technique = (entry.build)(&technique)?;
        let name = args.method.as_deref().unwrap_or(entry.default_method);
        let is_reference = name.eq_ignore_ascii_case("reference");
        if let Some(key) = parameters.keys().next().filter(|_| is_reference) {
            let known: Vec<&str> = entry.about.parameters.iter().map(|p| p.key).collect();
            return Err(Failure::usage(format!(
                "--set {key}: no such parameter of {}; known: {}, and max_depth, ao_distance, metres_per_unit, environment of the scene",
                entry.about.id,
                known.join(", ")
            )));
        }
        let method = match is_reference {
            true => None,
            false => Some(technique.start(name, &parameters, Terms::default())?.id),
        };
        technique.fits(&description).map_err(Failure::usage)?;
        // One image is for looking at: what is absent of it is told, but no light may be.
        description.require_files(technique.needs(), true)?;
        let view = match &args.view {
            None => 0,
            Some(name) => {
                let known: Vec<&str> = description.views.iter().map(|v| v.name.as_str()).collect();
                known.iter().position(|k| k == name).ok_or_else(|| {
                    Failure::usage(format!(
                        "no view `{name}`; the scene has: {}",
                        known.join(", ")
                    ))
                })?
            }
        };
        let size = match &args.size {
            Some(text) => parse_size(text)?,
            None => description
                .views
                .get(view)
                .map(|v| [v.width, v.height])
                .ok_or_else(|| Failure::usage("the scene declares no view"))?,
        };
        if args.spp == 0 {
            return Err(Failure::usage("--spp must be at least 1"));
        }
        let scene = Scene::build(&description, technique.needs())?;
        for note in scene.report.sentences() {
            eprintln!("note: {note}");
        }
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        Ok(Self {
            technique,
            method,
            parameters,
            scene,
            tracer,
            size,
            view,
            spp: args.spp,
            budget: args.budget.unwrap_or_else(|| default_budget(entry, size)),
            seed: args.seed,
        })
    }

    pub fn shot(&self) -> Shot<'_> {
        let film = Film {
            width: self.size[0],
            height: self.size[1],
            spp: self.spp,
        };
        let view = &self.scene.views[self.view];
        let moment = Moment::still(&self.scene, &self.tracer);
        Shot::exposed_for(self.technique.as_ref(), moment, view, film)
    }

    /// Canonical id of the method, or `reference`.
    fn method_id(&self) -> &str {
        self.method.as_deref().unwrap_or("reference")
    }

    /// Whether the exact function is rendered.
    pub fn is_reference(&self) -> bool {
        self.method.is_none()
    }

    /// Renders the contender, or the exact function.
    pub fn render(&self) -> Result<Rendered, Failure> {
        let mut shot = self.shot();
        let technique = self.technique.as_ref();
        let Some(method) = &self.method else {
            return Ok(exact(technique, &shot));
        };
        shot.layer = technique.shared_layer(&shot);
        let choice = Choice {
            method,
            parameters: &self.parameters,
            terms: Terms {
                budget: self.budget,
                seed: self.seed,
            },
        };
        let started = technique.start(method, &self.parameters, choice.terms)?;
        let searches = started.contender.searches();
        let reference = searches.then(|| exact(technique, &shot).image);
        choice
            .still(technique, &shot, reference.as_ref())
            .map_err(Failure::job)
    }
}

/// 16 lights, or the records per pixel of 120,000 at full HD.
fn default_budget(entry: &TechniqueEntry, [width, height]: [usize; 2]) -> usize {
    let of_paper = (width * height) as f64 * 120_000.0 / (1920.0 * 1080.0);
    match entry.unit {
        Unit::Lights => 16,
        Unit::Samples => 1,
        Unit::Caches => (of_paper.round() as usize).max(1),
    }
}

/// The shading function at every sample.
fn exact(technique: &dyn Technique, shot: &Shot) -> Rendered {
    let counter = RayCounter::default();
    let mut stages = Stages::default();
    let function = technique.shading_function(shot);
    let mut passes = Passes::new(shot, function.as_ref());
    stages.time("rendering", || {
        for _ in 0..technique.reference_samples(shot.spp) {
            passes.add(&counter);
        }
    });
    Rendered {
        image: passes.mean(),
        rays: counter.read(),
        stages,
        non_finite: passes.non_finite,
        ..Rendered::default()
    }
}

/// The entry of a technique, or an error that lists what there is.
pub fn technique_entry(id: &str) -> Result<&'static TechniqueEntry, Failure> {
    crate::registry::technique(id).ok_or_else(|| {
        let known: Vec<&str> = crate::registry::TECHNIQUES
            .iter()
            .map(|e| e.about.id)
            .collect();
        Failure::usage(format!(
            "no technique is called `{id}`; known: {}",
            known.join(", ")
        ))
    })
}

/// Splits `--set` into parameters of the method and of the technique, and applies those of the scene.
fn settings(
    args: &ContenderArgs,
    entry: &TechniqueEntry,
    description: &mut SceneDescription,
) -> Result<(Table, Table), Failure> {
    let (mut method, mut technique) = (Table::new(), Table::new());
    if entry.about.parameters.iter().any(|p| p.key == "seed") {
        technique.insert("seed".into(), Value::Integer(args.seed as i64));
    }
    for text in &args.settings {
        let Override { key, values } = Override::parse(text)?;
        let [value] = values.as_slice() else {
            return Err(Failure::usage(format!(
                "--set {text}: one value is expected here"
            )));
        };
        let takes = |key: &str| entry.about.parameters.iter().any(|p| p.key == key);
        match key.as_str() {
            "ao_distance" if !takes("distance") => {
                let id = entry.about.id;
                return Err(Failure::usage(format!(
                    "--set {text}: {id} takes no ao_distance; leave it out"
                )));
            }
            "max_depth" | "ao_distance" | "metres_per_unit" => {
                let number = value.as_integer().map(|i| i as f64).or(value.as_float());
                let number = number
                    .filter(|n| *n > 0.0 && n.is_finite())
                    .ok_or_else(|| {
                        Failure::usage(format!("--set {text}: expected a positive number"))
                    })?;
                match key.as_str() {
                    "max_depth" => description.max_depth = number as u32,
                    "ao_distance" => description.ao_distance = Some(number),
                    _ => description.metres_per_unit = Some(number),
                }
            }
            "environment" => description.environment = Some(environment(value)?),
            _ if takes(&key) => {
                technique.insert(key, value.clone());
            }
            _ => {
                method.insert(key, value.clone());
            }
        }
    }
    Ok((method, technique))
}

fn environment(value: &Value) -> Result<EnvironmentDescription, Failure> {
    let name = value
        .as_str()
        .ok_or_else(|| Failure::usage("--set environment=MAP: expected a name or a file"))?;
    Ok(find_environment(name)?)
}

fn parse_size(text: &str) -> Result<[usize; 2], Failure> {
    text.split_once(['x', 'X'])
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]))
        .filter(|[w, h]: &[usize; 2]| *w > 0 && *h > 0 && w.saturating_mul(*h) <= 1 << 28)
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
    let prepared = Prepared::new(&args.contender)?;
    let rendered = prepared.render()?;
    let exposure = prepared.technique.exposure_stops(&prepared.scene);
    if png {
        write_png(&args.out, &rendered.image, exposure)?;
    } else {
        let mut attributes = Attributes::new();
        attributes.insert("scene".into(), prepared.scene.name.clone().into());
        attributes.insert("method".into(), prepared.method_id().into());
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
    let [width, height] = prepared.size;
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
    let mut notes = prepared.scene.report.sentences();
    notes.extend_from_slice(&rendered.notes);
    if args.json {
        let record = serde_json::json!({
            "scene": prepared.scene.name,
            "technique": args.contender.technique,
            "method": prepared.method_id(),
            "width": width,
            "height": height,
            "spp": prepared.spp,
            "seed": prepared.seed,
            "exposure_stops": prepared.technique.exposure_stops(&prepared.scene),
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
            eprintln!("{:<20} {:>8.3} s", stage.name, stage.seconds.wall);
        }
        for note in &rendered.notes {
            eprintln!("note: {note}");
        }
    }
    Ok(())
}
