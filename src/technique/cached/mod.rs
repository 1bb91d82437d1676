//! A cached function under a distribution: place, evaluate, refine, evaluate, look up, shade.

use glam::Vec3;

use super::{
    Contender, Distribution, Frame, Method, PlacedRecord, Rendered, Site, Stages, per_sample,
    shading_points,
};
use crate::cache::{Interpolation, RecordSearch, SearchRule, ShadingPoints};
use crate::metric::pixel_errors;
use crate::placement::{FirstStage, Records as _, Refinable};
use crate::sample::hash;
use crate::trace::RayCounter;

mod function;
mod growing;
mod lookup;
mod replay;
mod shader;

pub use function::{CachedFunction, CachedTechnique, RecordSite};
pub use lookup::Lookup;
pub use replay::replay;

use growing::Growing;
use shader::Shader;

/// Renders a contender of a cached technique.
///
/// # Errors
/// A choice of settings without a reference.
pub fn render(
    technique: &dyn CachedTechnique,
    frame: &Frame,
    contender: &Contender,
) -> Result<Rendered, String> {
    match contender.method {
        Method::Distribution(distribution) => {
            render_distribution(technique, frame, contender, distribution)
        }
        Method::PerSample(method) => per_sample::render(technique, frame, contender, method),
        Method::EnvironmentSampler(id, _) => Err(format!("cached techniques do not take {id}")),
        Method::OnDemand(_) => Err("records are made on demand for irradiance only".into()),
    }
}

/// Where the method leaves a setting to be picked by error, every setting is rendered and the one
/// with the least RMSE against the reference is kept; the cost of the others is not charged, as in
/// the paper. Of noisy images the setting is picked with another seed, so that no contender gets the
/// luckiest noise of several.
fn render_distribution(
    technique: &dyn CachedTechnique,
    frame: &Frame,
    contender: &Contender,
    distribution: &Distribution,
) -> Result<Rendered, String> {
    let candidates = distribution.first.candidates();
    let job = (technique, frame, contender);
    if candidates.is_empty() {
        return render_setting(job, (distribution.first.as_ref(), distribution));
    }
    let reference = contender
        .reference
        .ok_or("a per-scene choice of settings needs a reference; name one setting instead")?;
    let noisy = technique.is_noisy();
    let trial = Contender {
        seed: if noisy {
            hash(contender.seed)
        } else {
            contender.seed
        },
        ..*contender
    };
    let mut best: Option<(f64, usize, Rendered)> = None;
    for (index, first) in candidates.iter().enumerate() {
        let trial = (technique, frame, &trial);
        let rendered = render_setting(trial, (first.as_ref(), distribution))?;
        let error = pixel_errors(reference, &rendered.image).mse;
        if best.as_ref().is_none_or(|(least, _, _)| error < *least) {
            best = Some((error, index, rendered));
        }
    }
    let (_, index, mut rendered) = best.ok_or("no setting to choose from")?;
    if noisy {
        rendered = render_setting(job, (candidates[index].as_ref(), distribution))?;
    }
    rendered.notes.push(format!(
        "best of {} settings by RMSE against the reference; the others are not charged",
        candidates.len()
    ));
    Ok(rendered)
}

/// Finished records of one setting, ready to be looked up.
struct Records<'a> {
    function: Box<dyn CachedFunction + 'a>,
    interpolation: Interpolation,
    search: RecordSearch,
    points: ShadingPoints,
    /// Indices into `points`; the first `first_count` are of the first stage.
    sites: Vec<u32>,
    first_count: usize,
    /// Notes, found parameters, map and stage times so far.
    rendered: Rendered,
}

/// What a setting is rendered for.
type Job<'a> = (&'a dyn CachedTechnique, &'a Frame<'a>, &'a Contender<'a>);
/// A first stage, and the distribution whose refinement and interpolation go with it.
type Setting<'a> = (&'a dyn FirstStage, &'a Distribution);

fn render_setting(job: Job, setting: Setting) -> Result<Rendered, String> {
    let (technique, frame, _) = job;
    let counter = RayCounter::default();
    let mut records = place_and_evaluate(job, &counter, setting)?;
    let mut rendered = std::mem::take(&mut records.rendered);
    let (image, lookups, non_finite) = rendered.stages.time("rendering", || {
        Shader {
            frame,
            records: &records,
            counter: &counter,
        }
        .image()
    });
    let points = &records.points;
    rendered.image = image;
    rendered.lookups = lookups;
    rendered.non_finite = non_finite + records.function.non_finite();
    rendered.found.extend(records.function.found());
    rendered.records = records
        .sites
        .iter()
        .enumerate()
        .map(|(i, &point)| PlacedRecord {
            site: Site::of(points, point),
            pixel: points.pixel[point as usize],
            stage: u8::from(i >= records.first_count),
        })
        .collect();
    rendered.rays = counter.read();
    rendered.bytes_peak = records.function.bytes() + frame.tracer.bytes() + points.bytes();
    technique.finish(frame, &mut rendered);
    Ok(rendered)
}

/// Everything before the image: both stages of placement, evaluation and the search structure.
fn place_and_evaluate<'a>(
    (technique, frame, contender): Job<'a>,
    counter: &RayCounter,
    (first, distribution): Setting,
) -> Result<Records<'a>, String> {
    let interpolation = distribution.interpolation;
    let (mut function, lookup) = technique.function(frame, (interpolation, contender.seed))?;
    let refinement = distribution.refinement.as_deref();
    let mut stages = Stages::default();
    let points = stages.time("shading_points", || shading_points(frame, counter));
    let kept = refinement.map_or(0.0, |r| r.ratio());
    let refined = ((contender.budget as f64 * kept).round() as usize).min(contender.budget);
    let placement = stages.time("placement", || {
        first.place(&points, contender.budget - refined, contender.seed)
    });
    let mut rendered = Rendered {
        found: placement.found,
        notes: placement.notes,
        ..Rendered::default()
    };
    let mut sites = placement.sites;
    let first_count = sites.len();
    stages.time("evaluation", || {
        function.evaluate(&select(&points, &sites), counter);
    });
    let rule = |function: &dyn CachedFunction| {
        let length = function.length().min(frame.scene.diagonal);
        interpolation.rule(lookup.rule(frame), length)
    };
    if let Some(refinement) = refinement.filter(|_| refined > 0) {
        let search = search_over(&points, &sites, rule(function.as_ref()));
        let mut growing = Growing::new(function.as_mut(), frame, (&points, counter));
        let mut whole = Stages::default();
        let more = whole.time("refinement", || {
            if refinement.predicts() {
                growing.weigh();
            }
            let mut input = Refinable {
                points: &points,
                sites: &sites,
                search: &search,
                power: interpolation.power(),
                records: &mut growing,
            };
            refinement.refine(&mut input, refined, contender.seed)
        });
        let (added, inside) = (growing.added, growing.stages.total());
        stages.0.push(("refinement", whole.total() - inside));
        growing.add(&more.sites[added..]);
        stages
            .0
            .push(("refined_evaluation", growing.stages.total()));
        rendered.discontinuity = more.map;
        rendered.found.extend(more.found);
        rendered.notes.extend(more.notes);
        sites.extend(more.sites);
    }
    if sites.len() != contender.budget {
        rendered.notes.push(format!(
            "{} records instead of {}: the view has {} shading points",
            sites.len(),
            contender.budget,
            points.len()
        ));
    }
    let rule = rule(function.as_ref());
    let search = stages.time("search", || search_over(&points, &sites, rule));
    rendered.stages = stages;
    Ok(Records {
        function,
        interpolation,
        search,
        points,
        sites,
        first_count,
        rendered,
    })
}

fn select(points: &ShadingPoints, sites: &[u32]) -> Vec<RecordSite> {
    sites.iter().map(|&i| RecordSite::of(points, i)).collect()
}

fn search_over(points: &ShadingPoints, sites: &[u32], rule: SearchRule) -> RecordSearch {
    let positions: Vec<Vec3> = sites.iter().map(|&i| points.position[i as usize]).collect();
    let normals: Vec<Vec3> = sites.iter().map(|&i| points.normal[i as usize]).collect();
    RecordSearch::new(&positions, &normals, rule)
}
