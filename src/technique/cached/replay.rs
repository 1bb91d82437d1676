//! What went into one pixel.

use super::{Job, place_and_evaluate};
use crate::cache::inverse_distance_weights;
use crate::technique::{CachedTechnique, Contender, Frame, Method};
use crate::trace::RayCounter;

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
    let job: Job = (technique, frame, contender);
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
