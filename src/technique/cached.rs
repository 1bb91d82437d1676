//! A cached function under a distribution: place, evaluate, refine, evaluate, look up, shade.

use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Contender, Frame, PlacedRecord, Rendered, Site, Stages, Technique, shading_points};
use crate::cache::{
    DistanceMetric, Neighbour, RecordSearch, SearchRule, ShadingPoints, inverse_distance_weights,
};
use crate::image::Image;
use crate::metric::pixel_errors;
use crate::placement::{FirstStage, Refinable};
use crate::trace::RayCounter;

/// A function that is evaluated at few records and interpolated everywhere else.
pub trait CachedFunction: Sync {
    /// Evaluates at `sites` and appends the records.
    fn evaluate(&mut self, frame: &Frame, sites: &[Site], counter: &RayCounter);

    /// Summed absolute difference of the gathering samples of two records.
    fn difference(&self, a: u32, b: u32) -> f32;

    /// The value at a site from its neighbours; `weights` sum to 1 and are parallel to them.
    fn interpolate(&self, site: &Site, neighbours: &[Neighbour], weights: &[f32]) -> [f32; 3];

    /// The value where the camera sees no surface.
    fn background(&self) -> [f32; 3];

    /// Bytes held by the records.
    fn bytes(&self) -> usize;
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

/// Renders a contender of a cached technique. Where the method leaves a setting to be picked by
/// error, every setting is rendered and the one with the least RMSE against the reference is kept;
/// the cost of the others is not charged, as in the paper.
pub fn render(
    technique: &dyn Technique,
    frame: &Frame,
    contender: &Contender,
) -> Result<Rendered, String> {
    let candidates = contender.distribution.first.candidates();
    if candidates.is_empty() {
        let first = contender.distribution.first.as_ref();
        return render_setting(technique, frame, contender, first);
    }
    let reference = contender
        .reference
        .ok_or("a per-scene choice of settings needs a reference; name one setting instead")?;
    let mut best: Option<(f64, Rendered)> = None;
    for first in &candidates {
        let rendered = render_setting(technique, frame, contender, first.as_ref())?;
        let error = pixel_errors(reference, &rendered.image).mse;
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, rendered));
        }
    }
    let (_, mut rendered) = best.ok_or("no setting to choose from")?;
    rendered.notes.push(format!(
        "best of {} settings by RMSE against the reference; the others are not charged",
        candidates.len()
    ));
    Ok(rendered)
}

/// Finished records of one setting, ready to be looked up.
struct Records {
    function: Box<dyn CachedFunction>,
    search: RecordSearch,
    points: ShadingPoints,
    /// Indices into `points`; the first `first_count` are of the first stage.
    sites: Vec<u32>,
    first_count: usize,
    /// Notes, found parameters, map and stage times so far.
    rendered: Rendered,
}

fn render_setting(
    technique: &dyn Technique,
    frame: &Frame,
    contender: &Contender,
    first: &dyn FirstStage,
) -> Result<Rendered, String> {
    let counter = RayCounter::default();
    let records = place_and_evaluate((technique, frame, &counter), contender, first)?;
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
    rendered.non_finite = non_finite;
    rendered.records = records
        .sites
        .iter()
        .zip(select(points, &records.sites))
        .enumerate()
        .map(|(i, (&point, site))| PlacedRecord {
            site,
            pixel: points.pixel[point as usize],
            stage: u8::from(i >= records.first_count),
        })
        .collect();
    rendered.rays = counter.read();
    rendered.bytes_peak = records.function.bytes() + frame.tracer.bytes() + points.bytes();
    Ok(rendered)
}

/// Everything before the image: both stages of placement, evaluation and the search structure.
fn place_and_evaluate(
    (technique, frame, counter): (&dyn Technique, &Frame, &RayCounter),
    contender: &Contender,
    first: &dyn FirstStage,
) -> Result<Records, String> {
    let (mut function, lookup) = technique
        .cached(frame)
        .ok_or("this technique has no records")?;
    let rule = lookup.rule(frame);
    let mut stages = Stages::default();
    let points = stages.time("shading_points", || shading_points(frame, counter));
    let refinement = contender.distribution.refinement.as_deref();
    let kept = refinement.map_or(0.0, |r| r.ratio());
    let refined = ((contender.caches as f64 * kept).round() as usize).min(contender.caches);
    let placement = stages.time("placement", || {
        first.place(&points, contender.caches - refined, contender.seed)
    });
    let mut rendered = Rendered {
        found: placement.found,
        notes: placement.notes,
        ..Rendered::default()
    };
    let mut sites = placement.sites;
    let first_count = sites.len();
    stages.time("evaluation", || {
        function.evaluate(frame, &select(&points, &sites), counter);
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
            function.evaluate(frame, &select(&points, &more.sites), counter);
        });
        sites.extend(more.sites);
    }
    if sites.len() != contender.caches {
        rendered.notes.push(format!(
            "{} records instead of {}: the view has {} shading points",
            sites.len(),
            contender.caches,
            points.len()
        ));
    }
    let search = stages.time("search", || search_over(&points, &sites, rule));
    rendered.stages = stages;
    Ok(Records {
        function,
        search,
        points,
        sites,
        first_count,
        rendered,
    })
}

/// What went into one pixel (row-major index): its samples, the records each used, their distances,
/// weights and values.
pub fn replay(
    technique: &dyn Technique,
    frame: &Frame,
    contender: &Contender,
    pixel: u32,
) -> Result<Vec<String>, String> {
    let counter = RayCounter::default();
    let candidates = contender.distribution.first.candidates();
    let first = candidates.first().unwrap_or(&contender.distribution.first);
    let records = place_and_evaluate((technique, frame, &counter), contender, first.as_ref())?;
    let caster = frame.tracer.caster(&counter);
    let mut lines = Vec::new();
    for sample in 0..frame.spp {
        let Some((site, depth)) = frame.site(&caster, &frame.camera_ray(pixel, sample)) else {
            lines.push(format!(
                "sample {sample}: background {:?}",
                records.function.background()
            ));
            continue;
        };
        lines.push(format!(
            "sample {sample}: position {:?} normal {:?} depth {depth}",
            (site.position.as_dvec3() + frame.scene.origin).to_array(),
            site.normal.to_array()
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
                records.function.interpolate(&site, &[*neighbour], &[1.0])
            ));
        }
        if !neighbours.is_empty() {
            let value = records.function.interpolate(&site, &neighbours, &weights);
            lines.push(format!("  interpolated {value:?}"));
        }
    }
    Ok(lines)
}

fn select(points: &ShadingPoints, sites: &[u32]) -> Vec<Site> {
    sites
        .iter()
        .map(|&i| Site {
            position: points.position[i as usize],
            normal: points.normal[i as usize],
            geometric_normal: points.geometric_normal[i as usize],
        })
        .collect()
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

/// A surface hit of one camera sample.
struct Sample {
    pixel: u32,
    site: Site,
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
            let samples = self.hits(top, bottom);
            let values = self.values(&samples);
            lookups += samples.len() as u64;
            non_finite += self.film(top, &samples, &values, &mut image);
        }
        (image, lookups, non_finite)
    }

    /// Surface hits of rows `top..bottom`, in 8×8 pixel tiles so that neighbours follow each other.
    fn hits(&self, top: usize, bottom: usize) -> Vec<Sample> {
        const TILE: usize = 8;
        let frame = self.frame;
        let across = frame.width.div_ceil(TILE);
        let down = (bottom - top).div_ceil(TILE);
        let tiles: Vec<Vec<Sample>> = (0..across * down)
            .into_par_iter()
            .map(|tile| {
                let caster = frame.tracer.caster(self.counter);
                let (x0, y0) = (tile % across * TILE, top + tile / across * TILE);
                let mut hits = Vec::with_capacity(TILE * TILE * frame.spp as usize);
                for y in y0..(y0 + TILE).min(bottom) {
                    for x in x0..(x0 + TILE).min(frame.width) {
                        let pixel = (y * frame.width + x) as u32;
                        for sample in 0..frame.spp {
                            let ray = frame.camera_ray(pixel, sample);
                            if let Some((site, _)) = frame.site(&caster, &ray) {
                                hits.push(Sample { pixel, site });
                            }
                        }
                    }
                }
                hits
            })
            .collect();
        tiles.into_iter().flatten().collect()
    }

    fn values(&self, samples: &[Sample]) -> Vec<[f32; 3]> {
        let positions: Vec<Vec3> = samples.iter().map(|s| s.site.position).collect();
        let normals: Vec<Vec3> = samples.iter().map(|s| s.site.normal).collect();
        let diagonal = self.frame.scene.diagonal;
        self.search.map(&positions, &normals, |query, neighbours| {
            if neighbours.is_empty() {
                return self.function.background();
            }
            let mut weights = [0.0; MOST_USED];
            let weights = &mut weights[..neighbours.len()];
            inverse_distance_weights(neighbours, diagonal, weights);
            self.function
                .interpolate(&samples[query].site, neighbours, weights)
        })
    }

    /// Averages the samples of each pixel; background samples take the background's value.
    fn film(&self, top: usize, samples: &[Sample], values: &[[f32; 3]], image: &mut Image) -> u64 {
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
