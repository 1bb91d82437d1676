//! Systematic sampling of a list: points at equal distances along the running sum of its weights.

use super::contributions::Contributions;
use super::lights::{LANES, Lane, LightArrays};

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
    contributions: &Contributions,
    lights: &LightArrays,
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
    let mut places = Places::new(contributions, lights);
    for i in 0..count {
        let target = ((f64::from(u) + i as f64) * step) as f32;
        // Rounding may leave a chunk without any positive weight: then the last positive one.
        chosen.extend(places.at(target).or_else(|| chosen.last().copied()));
    }
}

/// Where points of growing distance lie along the list.
struct Places<'a> {
    contributions: &'a Contributions,
    lights: &'a LightArrays,
    /// The part of the list that the last point lay in, by lane of the uppermost level, and the
    /// weights of its chunks.
    part: usize,
    parts: Lane,
    /// The chunk of eight lights that the last point lay in, and their weights.
    chunk: usize,
    weights: Lane,
}

impl<'a> Places<'a> {
    fn new(contributions: &'a Contributions, lights: &'a LightArrays) -> Self {
        Self {
            contributions,
            lights,
            part: 0,
            parts: contributions.weights(lights, 1, 0),
            chunk: 0,
            weights: contributions.weights(lights, 0, 0),
        }
    }

    fn at(&mut self, target: f32) -> Option<Chosen> {
        let running = &self.contributions.running;
        let before = self.part;
        while self.part + 1 < running.len() && running[self.part] <= target {
            self.part += 1;
        }
        if self.part != before {
            self.parts = self.contributions.weights(self.lights, 1, self.part);
        }
        let start = if self.part == 0 {
            0.0
        } else {
            running[self.part - 1]
        };
        let (lane, start) = lane_at(&self.parts, start, target)?;
        let chunk = self.part * LANES + lane;
        if chunk != self.chunk {
            self.chunk = chunk;
            self.weights = self.contributions.weights(self.lights, 0, chunk);
        }
        let (lane, start) = lane_at(&self.weights, start, target)?;
        let weight = self.weights[lane];
        Some(Chosen {
            light: chunk * LANES + lane,
            within: ((target - start) / weight).clamp(0.0, 1.0 - f32::EPSILON),
            weight,
        })
    }
}

/// The lane in which a sum that begins at `start` passes the target, the last positive one at the latest,
/// and where that lane begins.
#[inline(always)]
fn lane_at(weights: &Lane, start: f32, target: f32) -> Option<(usize, f32)> {
    // Without branches: where the target lies is no more likely in one lane than in another.
    let (mut begins, mut sum) = ([0.0; LANES], start);
    let (mut positive, mut passed) = (0u32, 0u32);
    for (lane, &weight) in weights.iter().enumerate() {
        begins[lane] = sum;
        sum += weight;
        positive |= u32::from(weight > 0.0) << lane;
        passed |= u32::from(sum > target) << lane;
    }
    let lane = match positive & passed {
        0 => positive.checked_ilog2()?,
        lanes => lanes.trailing_zeros(),
    };
    Some((lane as usize, begins[lane as usize]))
}
