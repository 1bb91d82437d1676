//! What went into one pixel.

use super::Setting;
use crate::cache::{Weighted, inverse_distance_weights};
use crate::trace::RayCounter;

/// What went into one pixel (row-major index): its samples, the records each used, their distances,
/// weights and values.
pub(super) fn replay(setting: &Setting, pixel: u32) -> Result<Vec<String>, String> {
    let shot = setting.shot;
    let counter = RayCounter::default();
    let records = setting.place_and_evaluate(&counter);
    let (diagonal, power) = (shot.scene.diagonal, records.interpolation.power());
    let caster = shot.tracer.caster(&counter);
    let mut lines = Vec::new();
    for sample in 0..shot.spp {
        let Some(seen) = shot.look(&caster, pixel, sample) else {
            lines.push(format!(
                "sample {sample}: background {:?}",
                records.function.background()
            ));
            continue;
        };
        let site = seen.site;
        lines.push(format!(
            "sample {sample}: position {:?} normal {:?} depth {}",
            (site.position.as_dvec3() + shot.scene.origin).to_array(),
            site.normal.to_array(),
            seen.depth
        ));
        let found = records
            .search
            .map(&[site.position], &[site.normal], |_, n| n.to_vec());
        let neighbours = found.into_iter().next().unwrap_or_default();
        let mut weights = vec![0.0; neighbours.len()];
        inverse_distance_weights(&neighbours, diagonal, power, &mut weights);
        for (neighbour, weight) in neighbours.iter().zip(&weights) {
            let point = records.sites[neighbour.record as usize] as usize;
            let pixel = records.points.pixel[point] as usize;
            let alone = Weighted {
                neighbours: std::slice::from_ref(neighbour),
                weights: &[1.0],
            };
            lines.push(format!(
                "  record {} at pixel {},{}: distance {:.6}, weight {weight:.4}, value {:?}",
                neighbour.record,
                pixel % shot.width,
                pixel / shot.width,
                neighbour.distance,
                records.function.shade(&caster, &seen, alone)
            ));
        }
        let function = records.function.as_ref();
        let near = Weighted {
            neighbours: &neighbours,
            weights: &weights,
        };
        let value = function
            .shade(&caster, &seen, near)
            .unwrap_or_else(|| function.shade_missed(&caster, &seen));
        lines.push(format!("  shaded {value:?}"));
    }
    Ok(lines)
}
