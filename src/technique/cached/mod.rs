//! A cached function under a distribution: place, evaluate, refine, evaluate, look up, shade.

use std::collections::BTreeMap;

use glam::Vec3;
use rayon::prelude::*;
use toml::Table;

use super::distribution::distributions;
use super::{
    Clock, Contender, ContenderEntry, Distribution, Listed, PlacedRecord, Rendered, Search, Seen,
    Shot, Site, Stages, Started, Terms, shading_points,
};
use crate::cache::{Interpolation, RecordSearch, SearchRule, ShadingPoints};
use crate::entry::ParameterError;
use crate::image::Image;
use crate::memory::released;
use crate::metric::pixel_errors;
use crate::placement::{FirstStage, Records as _, Refinable};
use crate::sample::hash;
use crate::trace::RayCounter;

mod function;
mod growing;
mod lookup;
mod per_sample;
mod replay;
mod shader;

pub use function::{CachedFunction, CachedTechnique};
pub use lookup::Lookup;

use growing::Growing;
use per_sample::PER_SAMPLE;
use shader::Shader;

/// What every cached technique compares beside distributions.
pub static CONTENDERS: &[ContenderEntry<dyn CachedTechnique>] = &[PER_SAMPLE];

/// Every contender of a cached technique.
pub fn listed() -> Vec<Listed> {
    let others = CONTENDERS.iter().map(ContenderEntry::listed);
    distributions().into_iter().chain(others).collect()
}

/// Builds a contender of a cached technique: one of [`CONTENDERS`], or a distribution.
///
/// # Errors
/// As [`super::Technique::start`].
pub fn start<'a>(
    technique: &'a (dyn CachedTechnique + 'static),
    id: &str,
    parameters: &Table,
    terms: Terms,
) -> Result<Started<'a>, ParameterError> {
    if let Some(entry) = CONTENDERS.iter().find(|e| e.about.answers_to(id)) {
        return entry.started(technique, parameters, terms);
    }
    let distribution = Distribution::new(id, parameters)?;
    technique.accepts(&distribution.interpolation)?;
    Ok(Started {
        id: distribution.id.clone(),
        parts: distribution.parts.clone(),
        contender: Box::new(Distributed {
            technique,
            distribution,
            terms,
            picked: BTreeMap::new(),
        }),
    })
}

/// Records placed by a distribution anew in each shot.
struct Distributed<'a> {
    technique: &'a dyn CachedTechnique,
    distribution: Distribution,
    terms: Terms,
    /// What was picked for each viewer, by its number, where the distribution leaves settings open.
    picked: BTreeMap<u16, Picked>,
}

/// Settings that were picked by error.
struct Picked {
    /// The first stage with these settings.
    first: Box<dyn FirstStage>,
    /// What picking took, until it is told.
    search: Search,
}

impl Contender for Distributed<'_> {
    fn searches(&self) -> bool {
        !self.distribution.first.candidates().is_empty()
    }

    /// Every setting is rendered and the one with the least squared error is kept. Of noisy images the setting is
    /// picked with another seed, so that no contender gets the luckiest noise of several.
    fn search(&mut self, shots: &[Shot], references: &[&Image]) -> Result<(), String> {
        for (shot, reference) in shots.iter().zip(references) {
            if let Some(picked) = self.pick(shot, reference)? {
                self.picked.insert(shot.viewer, picked);
            }
        }
        Ok(())
    }

    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        let mut images = Vec::with_capacity(shots.len());
        for shot in shots {
            let picked = self.picked.get(&shot.viewer);
            if self.searches() && picked.is_none() {
                return Err(
                    "a per-scene choice of settings needs a reference; name one setting instead"
                        .into(),
                );
            }
            let first = picked.map_or(&self.distribution.first, |picked| &picked.first);
            let setting = self.setting(shot, first.as_ref(), self.terms.seed);
            let mut rendered = setting.render()?;
            if let Some(picked) = self.picked.get_mut(&shot.viewer) {
                rendered.search.add(std::mem::take(&mut picked.search));
                rendered.notes.push(format!(
                    "best of {} settings by RMSE against the reference; the search is not charged",
                    self.distribution.first.candidates().len()
                ));
            }
            images.push(rendered);
        }
        Ok(images)
    }

    fn replay(&mut self, shot: &Shot, pixel: u32) -> Result<Vec<String>, String> {
        let candidates = self.distribution.first.candidates();
        let picked = self.picked.get(&shot.viewer).map(|picked| &picked.first);
        let first = picked
            .or(candidates.first())
            .unwrap_or(&self.distribution.first);
        let setting = self.setting(shot, first.as_ref(), self.terms.seed);
        replay::replay(&setting, pixel)
    }
}

impl Distributed<'_> {
    /// The best setting for one shot; `None` where there is none to choose from.
    fn pick(&self, shot: &Shot, reference: &Image) -> Result<Option<Picked>, String> {
        let clock = Clock::start();
        let seed = match self.technique.is_noisy() {
            true => hash(self.terms.seed),
            false => self.terms.seed,
        };
        let mut search = Search::default();
        let mut best: Option<(f64, Box<dyn FirstStage>)> = None;
        for first in self.distribution.first.candidates() {
            let mut rendered = self.setting(shot, first.as_ref(), seed).render()?;
            shot.add_layer(&mut rendered.image);
            search.rays += rendered.rays;
            let error = pixel_errors(reference, &rendered.image).mse;
            if best.as_ref().is_none_or(|(least, _)| error < *least) {
                best = Some((error, first));
            }
        }
        search.seconds = clock.seconds();
        Ok(best.map(|(_, first)| Picked { first, search }))
    }

    fn setting<'s>(
        &'s self,
        shot: &'s Shot<'s>,
        first: &'s dyn FirstStage,
        seed: u64,
    ) -> Setting<'s> {
        Setting {
            technique: self.technique,
            shot,
            first,
            distribution: &self.distribution,
            terms: Terms { seed, ..self.terms },
        }
    }
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

/// One shot under a distribution whose settings are all known.
struct Setting<'a> {
    technique: &'a dyn CachedTechnique,
    shot: &'a Shot<'a>,
    first: &'a dyn FirstStage,
    /// Whose refinement and interpolation go with the first stage.
    distribution: &'a Distribution,
    terms: Terms,
}

impl<'a> Setting<'a> {
    fn render(&self) -> Result<Rendered, String> {
        let shot = self.shot;
        let counter = RayCounter::default();
        let mut records = self.place_and_evaluate(&counter);
        let mut rendered = std::mem::take(&mut records.rendered);
        let shaded = rendered.stages.time("rendering", || {
            Shader {
                shot,
                records: &records,
                counter: &counter,
            }
            .image()
        });
        let points = &records.points;
        rendered.image = shaded.image;
        rendered.lookups = shaded.lookups;
        rendered.non_finite = shaded.non_finite + records.function.non_finite();
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
        rendered.bytes_cache = released((records.function, records.search));
        self.technique.finish(shot, &mut rendered);
        Ok(rendered)
    }

    /// Everything before the image: both stages of placement, evaluation and the search structure.
    fn place_and_evaluate(&self, counter: &RayCounter) -> Records<'a> {
        let Self {
            technique,
            shot,
            first,
            distribution,
            terms,
        } = *self;
        let interpolation = distribution.interpolation;
        let (mut function, lookup) = technique.function(shot, interpolation, terms.seed);
        let refinement = distribution.refinement.as_deref();
        let mut stages = Stages::default();
        let points = stages.time("shading_points", || shading_points(shot, counter));
        // No more records than points: lists are made for them.
        let budget = terms.budget.min(points.len());
        let kept = refinement.map_or(0.0, |r| r.ratio());
        let refined = ((budget as f64 * kept).round() as usize).min(budget);
        let placement = stages.time("placement", || {
            first.place(&points, budget - refined, terms.seed)
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
            let length = function.length().min(shot.scene.diagonal);
            interpolation.rule(lookup.rule(shot), length)
        };
        if let Some(refinement) = refinement.filter(|_| refined > 0) {
            let search = search_over(&points, &sites, rule(function.as_ref()));
            let mut growing = Growing::new(function.as_mut(), &points, counter);
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
                refinement.refine(&mut input, refined, terms.seed)
            });
            let (added, inside) = (growing.added, growing.stages.total());
            stages.add("refinement", whole.total() - inside);
            growing.add(&more.sites[added..]);
            stages.add("refined_evaluation", growing.stages.total());
            rendered.discontinuity = more.map;
            rendered.found.extend(more.found);
            rendered.notes.extend(more.notes);
            sites.extend(more.sites);
        }
        if sites.len() != terms.budget {
            rendered.notes.push(format!(
                "{} records instead of {}: the view has {} shading points",
                sites.len(),
                terms.budget,
                points.len()
            ));
        }
        let rule = rule(function.as_ref());
        let search = stages.time("search", || search_over(&points, &sites, rule));
        rendered.stages = stages;
        Records {
            function,
            interpolation,
            search,
            points,
            sites,
            first_count,
            rendered,
        }
    }
}

fn select(points: &ShadingPoints, sites: &[u32]) -> Vec<Seen> {
    sites.par_iter().map(|&i| Seen::of(points, i)).collect()
}

fn search_over(points: &ShadingPoints, sites: &[u32], rule: SearchRule) -> RecordSearch {
    let of =
        |values: &[Vec3]| -> Vec<Vec3> { sites.par_iter().map(|&i| values[i as usize]).collect() };
    let (positions, normals) = (of(&points.position), of(&points.normal));
    RecordSearch::new(&positions, &normals, rule)
}
