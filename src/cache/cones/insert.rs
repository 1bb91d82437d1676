//! Adding samples of lights to the cones of an entry (section 3.1.1 and Fig. 5).

use glam::Vec3;

use super::cone::Cone;
use super::news::News;
use super::rules::{Comparison, Inside, Rules, Unlit};
use super::{Entry, MOST_CONES, angle_between};
use crate::image::luminance;

/// One update of an entry: samples are added, then [`Update::finish`] takes them into the mean.
pub struct Update<'a> {
    pub(super) rules: &'a Rules,
    pub(super) entry: Entry,
    /// Light from outside the cones of before, where that is evidence.
    pub(super) news: Option<News>,
    /// X: light that the samples of this update brought into each cone, a mean over all of them.
    pub(super) arrived: [Vec3; MOST_CONES],
    /// Whether one fell into it.
    pub(super) lit: [bool; MOST_CONES],
    /// Axis of each cone when the update began, or when it was made.
    pub(super) axes: [Vec3; MOST_CONES],
    /// Largest angle between one and what became of it, radians.
    pub(super) turn: f32,
    /// Luminance of the sample that brought most.
    pub(super) largest: f32,
    /// Samples of the update, those that reach no light included.
    pub(super) samples: u32,
    /// Samples that reached their light.
    pub(super) arrivals: u32,
    /// Whether the count was lowered.
    pub(super) lowered: bool,
}

impl<'a> Update<'a> {
    /// Begins an update of `samples` samples with what an entry holds.
    pub fn of(entry: Entry, rules: &'a Rules, samples: u32) -> Self {
        Self {
            rules,
            entry,
            news: None,
            arrived: [Vec3::ZERO; MOST_CONES],
            lit: [false; MOST_CONES],
            axes: entry.cones.map(|cone| cone.axis),
            turn: 0.0,
            largest: 0.0,
            samples,
            arrivals: 0,
            lowered: false,
        }
    }

    /// The cones as they are by now.
    pub fn cones(&self) -> &[Cone] {
        self.entry.cones()
    }

    /// Adds light from a unit direction: radiance over density (or irradiance over probability) of a sample that reaches
    /// its light, divided by the number of all samples of the update.
    pub fn add(&mut self, direction: Vec3, light: Vec3) {
        let bright = luminance(light.into());
        if let Some(news) = &mut self.news {
            news.hear(direction, bright);
        }
        let cone = self.cone_for(direction, light);
        self.arrived[cone] += light;
        self.arrivals += 1;
        self.largest = self.largest.max(bright);
        self.lit[cone] = true;
    }

    /// The cone that a sample belongs to, after it has been made or widened for it.
    fn cone_for(&mut self, direction: Vec3, light: Vec3) -> usize {
        if let Some(inside) = self.around(direction) {
            return inside;
        }
        let new = Cone {
            axis: direction,
            half_angle: self.rules.least_angle(),
            light: Vec3::ZERO,
        };
        if self.entry.used < self.rules.cones.min(MOST_CONES) {
            return self.push(new);
        }
        // A sample is a cone without width.
        let sample = Weighed {
            cone: Cone {
                axis: direction,
                ..Cone::default()
            },
            light: luminance(light.into()) * self.samples as f32,
        };
        let cones: [Weighed; MOST_CONES] = std::array::from_fn(|index| self.weighed(index));
        let cones = &cones[..self.entry.used];
        let between = |a: &Weighed, b: &Weighed| a.distance(b, self.rules.comparison);
        let distances = cones.iter().map(|cone| between(cone, &sample));
        let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let (nearest, distance) = nearest.unwrap_or((0, 0.0));
        match closest_pair(cones, between) {
            Some((pair, apart)) if apart <= distance => {
                self.merge(pair);
                self.push(new)
            }
            _ => {
                let widened = self.entry.cones[nearest].around(direction);
                self.replace(nearest, widened);
                nearest
            }
        }
    }

    /// A cone and the light of all samples that it is the mean of, as luminance.
    fn weighed(&self, index: usize) -> Weighed {
        let cone = self.entry.cones[index];
        let [before, now] = [cone.light, self.arrived[index]].map(|light| luminance(light.into()));
        Weighed {
            cone,
            light: before * self.entry.count + now * self.samples as f32,
        }
    }

    /// (A) The cone around a direction.
    fn around(&self, direction: Vec3) -> Option<usize> {
        let cones = self.cones().iter().enumerate();
        let inside = cones.filter(|(_, cone)| cone.holds(direction));
        let order = |cone: &Cone| match self.rules.inside {
            Inside::Deepest => angle_between(cone.axis, direction) / cone.half_angle,
            Inside::Narrowest => cone.half_angle,
        };
        inside
            .min_by(|(_, a), (_, b)| order(a).total_cmp(&order(b)))
            .map(|(index, _)| index)
    }

    /// (B) A new cone.
    fn push(&mut self, cone: Cone) -> usize {
        let index = self.entry.used;
        self.entry.cones[index] = cone;
        self.arrived[index] = Vec3::ZERO;
        self.lit[index] = false;
        self.axes[index] = cone.axis;
        self.entry.used += 1;
        index
    }

    /// (C) A cone that is widened, or turned otherwise.
    pub(super) fn replace(&mut self, index: usize, cone: Cone) {
        let turn = angle_between(self.axes[index], cone.axis);
        self.turn = self.turn.max(turn);
        self.entry.cones[index] = cone;
    }

    /// (D) Two cones become the smallest one around both.
    fn merge(&mut self, [a, b]: [usize; 2]) {
        let merged = self.entry.cones[a].enclosing(&self.entry.cones[b]);
        self.replace(a, merged);
        self.arrived[a] += self.arrived[b];
        self.lit[a] |= self.lit[b];
        self.remove(b);
    }

    pub(super) fn remove(&mut self, index: usize) {
        self.arrived.copy_within(index + 1..self.entry.used, index);
        self.lit.copy_within(index + 1..self.entry.used, index);
        self.axes.copy_within(index + 1..self.entry.used, index);
        self.entry.remove(index);
    }

    /// Takes all samples, those that reached no light included, into the mean.
    pub fn average(&mut self) {
        self.forget_what_turned();
        let weight = self.rules.weight_of(self.samples);
        let count = (self.entry.count + weight).min(self.rules.most_count.max(weight));
        self.entry.count = count;
        let share = weight / count;
        for (index, cone) in self.entry.cones[..self.entry.used].iter_mut().enumerate() {
            if self.lit[index] || self.rules.unlit == Unlit::Fades {
                cone.light += (self.arrived[index] - cone.light) * share;
            }
        }
    }

    /// Lowers the count: what is remembered weighs less beside what comes next.
    pub(super) fn forget(&mut self, divisor: f32) {
        self.entry.count /= divisor;
    }

    /// Forgets where an axis has turned, once in an update.
    fn forget_what_turned(&mut self) {
        let turn_deg = self.turn.to_degrees();
        if self.lowered
            || turn_deg <= self.rules.turn_deg
            || self.entry.count <= self.rules.turn_count
        {
            return;
        }
        self.lowered = true;
        self.forget((1.0 + 0.05 * turn_deg).clamp(1.01, 3.0));
    }

    /// The entry after the update, without cones that hold next to nothing.
    pub fn finish(mut self) -> Entry {
        self.forget_what_turned();
        self.entry.tidy(self.rules.negligible, &self.lit);
        self.entry
    }
}

/// A cone that may be merged, and its light.
struct Weighed {
    cone: Cone,
    /// Luminance, summed over samples.
    light: f32,
}

impl Weighed {
    /// How little two cones should become one.
    fn distance(&self, other: &Self, comparison: Comparison) -> f32 {
        let (a, b) = (&self.cone, &other.cone);
        match comparison {
            Comparison::Gaps => (a.gap_to(b.axis) - b.half_angle).max(0.0),
            Comparison::Axes => angle_between(a.axis, b.axis),
            Comparison::Light => {
                let half_angle = a.half_angle_around(b);
                let widened = |w: &Self| w.light * (half_angle - w.cone.half_angle).max(0.0);
                widened(self) + widened(other)
            }
        }
    }
}

/// The two cones whose distance by `between` is least, and that distance; `None` of a single cone.
fn closest_pair(
    cones: &[Weighed],
    between: impl Fn(&Weighed, &Weighed) -> f32,
) -> Option<([usize; 2], f32)> {
    let pairs = (0..cones.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
    let measured = pairs.map(|[a, b]| ([a, b], between(&cones[a], &cones[b])));
    measured.min_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests;
