//! One image: planned as the only job of an experiment, and rendered as jobs are.

use std::collections::{BTreeMap, HashMap};

use super::afford::afford;
use super::config::{Config, ConfigError, Source};
use super::plan::Planner;
use super::{Job, Plan};
use crate::image::Image;
use crate::technique::{Passes, Rendered, Shot, Stages, Technique};
use crate::trace::RayCounter;

/// The method of single images that is no contender: the shading function at every sample.
pub const EXACT: &str = "reference";

/// The job of an experiment of one scene and one method, which may be [`EXACT`]. A budget that is not set
/// has a default.
///
/// # Errors
/// What is wrong in the experiment, as [`super::plan`] says it, and more than one job.
pub fn plan_image(config: &Config) -> Result<Job, ConfigError> {
    let mut plan = Plan::default();
    Planner {
        source: &Source::default(),
        config,
        sweep: BTreeMap::new(),
        cases: &mut HashMap::new(),
        is_image: true,
    }
    .add_jobs(&mut plan)?;
    match <[Job; 1]>::try_from(plan.jobs) {
        Ok([job]) => Ok(job),
        Err(jobs) => Err(ConfigError::Other(format!(
            "expected one image, not {}",
            jobs.len()
        ))),
    }
}

/// The image of a job's contender. `reference` is for contenders that pick settings by error, and may be
/// missing for all others.
///
/// # Errors
/// A sentence, where the contender cannot be built or needs what is not there.
pub fn render_job(
    job: &Job,
    technique: &dyn Technique,
    shot: &Shot,
    reference: Option<&Image>,
) -> Result<Rendered, String> {
    let render = |count: u64| job.choice(count).still(technique, shot, reference);
    let afforded = afford(job.budget, |trial| {
        trial.add(vec![render(trial.count)?], shot.pixels());
        Ok(())
    })?;
    let Some(mut afforded) = afforded else {
        return render(job.budget.amount as u64);
    };
    let mut images = std::mem::take(&mut afforded.images);
    afforded.tell(&mut images);
    images.pop().ok_or_else(|| "no image was rendered".into())
}

/// The image of the method [`EXACT`].
pub fn exact(technique: &dyn Technique, shot: &Shot) -> Rendered {
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
