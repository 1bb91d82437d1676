//! A cached function under a distribution: place, evaluate, refine, evaluate, look up, shade.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::frame::look_band;
use super::{
    Contender, Distribution, Frame, Method, PlacedRecord, Rendered, Seen, ShadingFunction, Site,
    Stages, Technique, per_sample, shading_points,
};
use crate::cache::{
    DistanceMetric, Neighbour, RecordSearch, SearchRule, ShadingPoints, inverse_distance_weights,
};
use crate::image::Image;
use crate::metric::pixel_errors;
use crate::placement::{FirstStage, Refinable, Refinement};
use crate::sample::hash;
use crate::trace::{Caster, RayCounter};

/// A technique whose contenders are records of one function.
pub trait CachedTechnique: Technique {
    /// The function without records, for one job, and its run-time rule. `seed` keys random choices
    /// of its records.
    fn function<'a>(
        &'a self,
        frame: &'a Frame<'a>,
        seed: u64,
    ) -> (Box<dyn CachedFunction + 'a>, Lookup);

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
            metric: match self.lambda_scaled {
                None => DistanceMetric::literal(diagonal, metres),
                Some(kappa) => DistanceMetric::scaled(kappa, diagonal),
            },
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
    let refinement = distribution.refinement.as_deref();
    let job = (technique, frame, contender);
    if candidates.is_empty() {
        return Ok(render_setting(job, distribution.first.as_ref(), refinement));
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
        let rendered = render_setting((technique, frame, &trial), first.as_ref(), refinement);
        let error = pixel_errors(reference, &rendered.image).mse;
        if best.as_ref().is_none_or(|(least, _, _)| error < *least) {
            best = Some((error, index, rendered));
        }
    }
    let (_, index, mut rendered) = best.ok_or("no setting to choose from")?;
    if noisy {
        rendered = render_setting(job, candidates[index].as_ref(), refinement);
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

fn render_setting(
    job: Job,
    first: &dyn FirstStage,
    refinement: Option<&dyn Refinement>,
) -> Rendered {
    let (technique, frame, _) = job;
    let counter = RayCounter::default();
    let records = place_and_evaluate(job, &counter, (first, refinement));
    let shader = Shader {
        frame,
        function: records.function.as_ref(),
        search: &records.search,
        counter: &counter,
    };
    let mut rendered = records.rendered;
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
    rendered
}

/// Everything before the image: both stages of placement, evaluation and the search structure.
fn place_and_evaluate<'a>(
    (technique, frame, contender): Job<'a>,
    counter: &RayCounter,
    (first, refinement): (&dyn FirstStage, Option<&dyn Refinement>),
) -> Records<'a> {
    let (mut function, lookup) = technique.function(frame, contender.seed);
    let rule = lookup.rule(frame);
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
    if let Some(refinement) = refinement.filter(|_| refined > 0) {
        let more = stages.time("refinement", || {
            let search = search_over(&points, &sites, rule);
            let input = Refinable {
                points: &points,
                sites: &sites,
                search: &search,
                difference: &|a, b| function.difference(a, b),
            };
            refinement.refine(&input, refined, contender.seed)
        });
        rendered.discontinuity = more.map;
        rendered.found.extend(more.found);
        rendered.notes.extend(more.notes);
        stages.time("refined_evaluation", || {
            function.evaluate(&select(&points, &more.sites), counter);
        });
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
    let search = stages.time("search", || search_over(&points, &sites, rule));
    rendered.stages = stages;
    Records {
        function,
        search,
        points,
        sites,
        first_count,
        rendered,
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
    let refinement = distribution.refinement.as_deref();
    let job = (technique, frame, contender);
    let records = place_and_evaluate(job, &counter, (first, refinement));
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
        inverse_distance_weights(&neighbours, frame.scene.diagonal, &mut weights);
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
    function: &'a dyn CachedFunction,
    search: &'a RecordSearch,
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
        let diagonal = self.frame.scene.diagonal;
        let caster = || self.frame.tracer.caster(self.counter);
        self.search.map_with(
            &positions,
            &normals,
            (caster, |caster, query, neighbours| {
                let mut weights = [0.0; MOST_USED];
                let weights = &mut weights[..neighbours.len()];
                inverse_distance_weights(neighbours, diagonal, weights);
                self.function
                    .shade(caster, &samples[query], (neighbours, weights))
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
        let background = self.function.background();
        for (pixel, (sum, hits)) in image.pixels[top * width..].iter_mut().zip(&sums) {
            let open = f64::from(self.frame.spp - hits);
            *pixel = std::array::from_fn(|c| {
                ((sum[c] + open * f64::from(background[c])) / f64::from(self.frame.spp)) as f32
            });
        }
        non_finite
    }
}
