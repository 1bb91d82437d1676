//! What went into one pixel.

use super::Sampled;
use super::illumination::Illumination;
use super::interleaving::set_of;
use super::reduced::indirect_cost;
use crate::environment::EnvironmentSampler;
use crate::trace::RayCounter;

/// A line for each camera sample and each light that reaches its surface. Indirect lights are
/// replayed at full resolution.
pub(super) fn replay(illumination: &Illumination, job: &Sampled, pixel: u32) -> Vec<String> {
    let shot = illumination.shot;
    let counter = RayCounter::default();
    let caster = shot.tracer.caster(&counter);
    let mut lines = vec![format!("exposure {}", illumination.scale)];
    let sets = match &job.sampler {
        EnvironmentSampler::PerPoint(mis) => {
            lines.push(format!("samples drawn at every point: {mis:?}"));
            Vec::new()
        }
        EnvironmentSampler::Product { parameters, .. } => {
            lines.push(format!("lights chosen at every point: {parameters:?}"));
            Vec::new()
        }
        EnvironmentSampler::Lights(sampler) => {
            let map = illumination.environment;
            let (reduction, rays) = (sampler.reduction(), job.terms.budget);
            let cost = indirect_cost(illumination, reduction, rays, &counter);
            let set = sampler.lights_within(map, job.terms.budget, cost, job.terms.seed);
            let parameters = &job.technique.parameters;
            let sets = parameters.interleaved_sets;
            set.interleaved(sets, parameters.perturbation, job.terms.seed)
        }
    };
    for sample in 0..shot.spp {
        let (at, seen) = match illumination.point(&caster, pixel, sample) {
            Err(radiance) => {
                lines.push(format!("sample {sample}: background {radiance}"));
                continue;
            }
            Ok(surface) => surface,
        };
        lines.push(format!(
            "sample {sample}: position {:?} normal {} depth {}",
            (at.position.as_dvec3() + shot.scene.origin).to_array(),
            at.shading_normal,
            seen.depth
        ));
        let [x, y] = [pixel as usize % shot.width, pixel as usize / shot.width];
        let Some(lights) = sets.get(set_of([x, y], sample, sets.len().max(1))) else {
            continue;
        };
        for (light, ready) in lights.iter().zip(illumination.parallel(lights.iter())) {
            let reflected = at.evaluate(ready.direction) * ready.power;
            let open = illumination.sees(&caster, &at, ready.direction);
            lines.push(format!(
                "  {:?} light from {}: power {:?}, reflected {reflected}, {}",
                light.kind,
                light.direction,
                light.power,
                if open { "visible" } else { "blocked" }
            ));
        }
    }
    lines
}
