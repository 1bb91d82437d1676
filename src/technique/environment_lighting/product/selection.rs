//! Systematic sampling of a list: points at equal distances along the running sum of its weights.

use super::contributions::Contributions;
use super::lights::{LANES, LightArrays};

/// A chosen light.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Chosen {
    pub light: usize,
    /// Where the point lies in the light's weight, in [0, 1): uniform, and usable again.
    pub within: f32,
    /// Its weight c_j.
    pub weight: f32,
}

/// Chooses `count` lights at (u + i) / count of the total weight, in the order of the list; none when
/// the total is 0.
pub(super) fn systematic(
    (contributions, lights): (&Contributions, &LightArrays),
    count: usize,
    u: f32,
    chosen: &mut Vec<Chosen>,
) {
    chosen.clear();
    let total = contributions.total();
    if !(total > 0.0 && total.is_finite()) {
        return;
    }
    let step = f64::from(total) / count as f64;
    let running = &contributions.running;
    let mut chunk = 0;
    let mut weights = contributions.weights(lights, 0);
    for i in 0..count {
        let target = ((f64::from(u) + i as f64) * step) as f32;
        let before = chunk;
        while chunk + 1 < running.len() && running[chunk] <= target {
            chunk += 1;
        }
        if chunk != before {
            weights = contributions.weights(lights, chunk);
        }
        let mut sum = if chunk == 0 { 0.0 } else { running[chunk - 1] };
        let mut last = None;
        for (lane, &weight) in weights.iter().enumerate() {
            if weight > 0.0 {
                last = Some(Chosen {
                    light: chunk * LANES + lane,
                    within: ((target - sum) / weight).clamp(0.0, 1.0 - f32::EPSILON),
                    weight,
                });
                if sum + weight > target {
                    break;
                }
            }
            sum += weight;
        }
        // Rounding may leave a chunk without any positive weight: then the last positive one.
        chosen.extend(last.or_else(|| chosen.last().copied()));
    }
}
