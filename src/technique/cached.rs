//! A cached function under a distribution: place, evaluate, refine, evaluate, look up, shade.

use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::frame::look_band;
use super::{
    Contender, Distribution, Frame, Method, PlacedRecord, Rendered, Seen, ShadingFunction, Site,
    Stages, Technique, per_sample, shading_points,
};
use crate::cache::{
    DistanceMetric, Interpolation, Neighbour, Ranking, RecordSearch, SearchRule, ShadingPoints,
    inverse_distance_weights,
};
use crate::image::Image;
use crate::metric::pixel_errors;
use crate::placement::{self, FirstStage, Records as _, Refinable};
use crate::sample::hash;
use crate::trace::{Caster, RayCounter};

/// A technique whose contenders are records of one function.
pub trait CachedTechnique: Technique {
    /// The function without records, for one job, and its run-time rule. `how` says
    /// how records will be interpolated and which seed keys random choices of them.
    ///
    /// # Errors
    /// A sentence, if its records cannot be interpolated so.
    fn function<'a>(
        &'a self,
        frame: &'a Frame<'a>,
        how: (Interpolation, u64),
    ) -> Result<(Box<dyn CachedFunction + 'a>, Lookup), String>;

    /// A random estimate of the function at every sample, for the contender without records; its
    /// samples count passes.
    fn estimator<'a>(&'a self, frame: &'a Frame<'a>, seed: u64) -> Box<dyn ShadingFunction + 'a>;

    /// Whether images from records are noisy.
    fn is_noisy(&self) -> bool {
        false
    }

    /// Adds to an image made from records what is not in them and costs all contenders the same.
    fn finish(&self, _: &Frame, _: &mut Rendered) {}
}

/// A shading point that becomes a record.
#[derive(Clone, Copy, Debug)]
pub struct RecordSite {
    pub site: Site,
    /// The pixel whose centre sees it; its camera ray tells direction and material.
    pub pixel: u32,
}

impl RecordSite {
    /// A shading point by its index.
    pub fn of(points: &ShadingPoints, point: u32) -> Self {
        Self {
            site: Site::of(points, point),
            pixel: points.pixel[point as usize],
        }
    }
}

/// A function that is evaluated at few records and interpolated everywhere else.
pub trait CachedFunction: Sync {
    /// Evaluates at `sites` and appends the records.
    fn evaluate(&mut self, sites: &[RecordSite], counter: &RayCounter);

    /// Summed absolute difference of the gathering samples of two records.
    fn difference(&self, a: u32, b: u32) -> f32;

    /// What a record alone says of a shading point, linear RGB.
    fn predict(&self, record: u32, of: &Site) -> Vec3;

    /// What the function is multiplied by on its way to the image where the camera sees a shading
    /// point.
    fn importance(&self, _: &Caster, _: &RecordSite) -> Vec3 {
        Vec3::ONE
    }

    /// Length within which the function changes, scene units: positive and finite.
    fn length(&self) -> f32;

    /// The value of a camera sample from its neighbours and their weights, which sum to 1. There
    /// are none when the lookup misses: no record, or none that may be used.
    fn shade(&self, caster: &Caster, seen: &Seen, found: (&[Neighbour], &[f32])) -> [f32; 3];

    /// The value where the camera sees no surface.
    fn background(&self) -> [f32; 3];

    /// Bytes held by the records.
    fn bytes(&self) -> usize;

    /// Values that were not finite and were left out of records.
    fn non_finite(&self) -> u64 {
        0
    }

    /// What is worth reporting of lookups.
    fn found(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
}

/// The largest M: weights of a sample live on the stack.
const MOST_USED: usize = 32;

/// The run-time rule's parameters (Wu & Shen, table 1), shared by all cached techniques.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Lookup {
    /// N: spatially nearest records that are candidates.
    pub candidates: usize,
    /// M: records that are used.
    pub used: usize,
    /// θ_max: largest angle between normals, degrees.
    pub max_angle_deg: f32,
    /// Weight of the normals in the combined distance: `None` is the paper's 0.5 / L, in metres;
    /// `Some(κ)` is the scale-free 0.5 · L · κ.
    pub lambda_scaled: Option<f32>,
}

impl Default for Lookup {
    fn default() -> Self {
        Self {
            candidates: 20,
            used: 6,
            max_angle_deg: 30.0,
            lambda_scaled: None,
        }
    }
}

impl Lookup {
    /// Checks ranges; the message names the key.
    pub fn validate(&self) -> Result<(), String> {
        if !(1..=MOST_USED).contains(&self.used)
            || self.candidates < self.used
            || self.candidates > 256
        {
            return Err(format!(
                "lookup: expected 1 ≤ used ≤ {MOST_USED} and used ≤ candidates ≤ 256, got used = {}, candidates = {}",
                self.used, self.candidates
            ));
        }
        if !(0.0..=180.0).contains(&self.max_angle_deg) {
            return Err("lookup: max_angle_deg must lie in 0 to 180".into());
        }
        Ok(())
    }

    fn rule(&self, frame: &Frame) -> SearchRule {
        let (diagonal, metres) = (frame.scene.diagonal, frame.scene.metres_per_unit as f32);
        SearchRule {
            candidates: self.candidates,
            used: self.used,
            max_angle_deg: self.max_angle_deg,
            metric: Ranking::Combined(match self.lambda_scaled {
                None => DistanceMetric::literal(diagonal, metres),
                Some(kappa) => DistanceMetric::scaled(kappa, diagonal),
            }),
        }
    }
}

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
    let shader = Shader {
        frame,
        records: &records,
        counter: &counter,
    };
    let (image, lookups, non_finite) = rendered.stages.time("rendering", || shader.image());
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
        let mut growing = Growing {
            function: function.as_mut(),
            frame,
            points: &points,
            importance: Vec::new(),
            counter,
            added: 0,
            stages: Stages::default(),
        };
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

/// The records of a job while a refinement adds to them.
struct Growing<'a, 'f> {
    function: &'a mut (dyn CachedFunction + 'f),
    frame: &'a Frame<'a>,
    points: &'a ShadingPoints,
    /// Of each point; empty if nothing is predicted.
    importance: Vec<Vec3>,
    counter: &'a RayCounter,
    /// How many were added.
    added: usize,
    /// Time taken by adding.
    stages: Stages,
}

impl Growing<'_, '_> {
    fn weigh(&mut self) {
        let (frame, function, points) = (self.frame, &*self.function, self.points);
        let caster = || frame.tracer.caster(self.counter);
        self.importance = (0..points.len() as u32)
            .into_par_iter()
            .with_min_len(1024)
            .map_init(caster, |caster, i| {
                function.importance(caster, &RecordSite::of(points, i))
            })
            .collect();
    }
}

impl placement::Records for Growing<'_, '_> {
    fn difference(&self, a: u32, b: u32) -> f32 {
        self.function.difference(a, b)
    }

    fn predict(&self, record: u32, point: u32) -> Vec3 {
        let value = self.function.predict(record, &Site::of(self.points, point));
        value * self.importance[point as usize]
    }

    fn add(&mut self, points: &[u32]) {
        let sites = select(self.points, points);
        let (function, counter) = (&mut *self.function, self.counter);
        let evaluate = || function.evaluate(&sites, counter);
        self.stages.time("evaluation", evaluate);
        self.added += points.len();
    }
}

/// What went into one pixel (row-major index): its samples, the records each used, their distances,
/// weights and values.
pub fn replay(
    technique: &dyn CachedTechnique,
    frame: &Frame,
    contender: &Contender,
    pixel: u32,
) -> Result<Vec<String>, String> {
    let Method::Distribution(distribution) = contender.method else {
        return Err(format!(
            "{} has no records to replay",
            contender.method.id()
        ));
    };
    let counter = RayCounter::default();
    let candidates = distribution.first.candidates();
    let first = candidates.first().unwrap_or(&distribution.first).as_ref();
    let job = (technique, frame, contender);
    let records = place_and_evaluate(job, &counter, (first, distribution))?;
    let how = (frame.scene.diagonal, records.interpolation.power());
    let caster = frame.tracer.caster(&counter);
    let mut lines = Vec::new();
    for sample in 0..frame.spp {
        let Some(seen) = frame.look(&caster, pixel, sample) else {
            lines.push(format!(
                "sample {sample}: background {:?}",
                records.function.background()
            ));
            continue;
        };
        let site = seen.site;
        lines.push(format!(
            "sample {sample}: position {:?} normal {:?} depth {}",
            (site.position.as_dvec3() + frame.scene.origin).to_array(),
            site.normal.to_array(),
            seen.depth
        ));
        let found = records
            .search
            .map(&[site.position], &[site.normal], |_, n| n.to_vec());
        let neighbours = found.into_iter().next().unwrap_or_default();
        let mut weights = vec![0.0; neighbours.len()];
        inverse_distance_weights(&neighbours, how, &mut weights);
        for (neighbour, weight) in neighbours.iter().zip(&weights) {
            let point = records.sites[neighbour.record as usize] as usize;
            let pixel = records.points.pixel[point] as usize;
            lines.push(format!(
                "  record {} at pixel {},{}: distance {:.6}, weight {weight:.4}, value {:?}",
                neighbour.record,
                pixel % frame.width,
                pixel / frame.width,
                neighbour.distance,
                records
                    .function
                    .shade(&caster, &seen, (&[*neighbour], &[1.0]))
            ));
        }
        let value = records
            .function
            .shade(&caster, &seen, (&neighbours, &weights));
        lines.push(format!("  shaded {value:?}"));
    }
    Ok(lines)
}

fn select(points: &ShadingPoints, sites: &[u32]) -> Vec<RecordSite> {
    sites.iter().map(|&i| RecordSite::of(points, i)).collect()
}

fn search_over(points: &ShadingPoints, sites: &[u32], rule: SearchRule) -> RecordSearch {
    let positions: Vec<Vec3> = sites.iter().map(|&i| points.position[i as usize]).collect();
    let normals: Vec<Vec3> = sites.iter().map(|&i| points.normal[i as usize]).collect();
    RecordSearch::new(&positions, &normals, rule)
}

/// Shades all samples of a frame from finished records.
struct Shader<'a> {
    frame: &'a Frame<'a>,
    records: &'a Records<'a>,
    counter: &'a RayCounter,
}

impl Shader<'_> {
    /// The image, the number of lookups and the number of non-finite values left out.
    fn image(&self) -> (Image, u64, u64) {
        /// Rows that are gathered before their lookups: bounds memory at any resolution.
        const BAND: usize = 64;
        let mut image = Image::new(self.frame.width, self.frame.height);
        let (mut lookups, mut non_finite) = (0, 0);
        for top in (0..self.frame.height).step_by(BAND) {
            let bottom = (top + BAND).min(self.frame.height);
            let samples = look_band(self.frame, self.counter, top..bottom, self.frame.spp);
            let values = self.values(&samples);
            lookups += samples.len() as u64;
            non_finite += self.film(top, &samples, &values, &mut image);
        }
        (image, lookups, non_finite)
    }

    fn values(&self, samples: &[Seen]) -> Vec<[f32; 3]> {
        let positions: Vec<Vec3> = samples.iter().map(|s| s.site.position).collect();
        let normals: Vec<Vec3> = samples.iter().map(|s| s.site.normal).collect();
        let function = self.records.function.as_ref();
        let how = (
            self.frame.scene.diagonal,
            self.records.interpolation.power(),
        );
        let caster = || self.frame.tracer.caster(self.counter);
        self.records.search.map_with(
            &positions,
            &normals,
            (caster, |caster, query, neighbours| {
                let mut weights = [0.0; MOST_USED];
                let weights = &mut weights[..neighbours.len()];
                inverse_distance_weights(neighbours, how, weights);
                function.shade(caster, &samples[query], (neighbours, weights))
            }),
        )
    }

    /// Averages the samples of each pixel; background samples take the background's value.
    fn film(&self, top: usize, samples: &[Seen], values: &[[f32; 3]], image: &mut Image) -> u64 {
        let width = self.frame.width;
        let rows = (self.frame.height - top).min(64);
        let mut sums = vec![([0.0f64; 3], 0u32); rows * width];
        let mut non_finite = 0;
        for (sample, value) in samples.iter().zip(values) {
            let (sum, hits) = &mut sums[sample.pixel as usize - top * width];
            *hits += 1;
            if value.iter().all(|v| v.is_finite()) {
                (0..3).for_each(|c| sum[c] += f64::from(value[c]));
            } else {
                non_finite += 1;
            }
        }
        let background = self.records.function.background();
        for (pixel, (sum, hits)) in image.pixels[top * width..].iter_mut().zip(&sums) {
            let open = f64::from(self.frame.spp - hits);
            *pixel = std::array::from_fn(|c| {
                ((sum[c] + open * f64::from(background[c])) / f64::from(self.frame.spp)) as f32
            });
        }
        non_finite
    }
}
