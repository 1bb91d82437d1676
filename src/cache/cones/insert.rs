//! Adding samples of lights to the cones of an entry (section 3.1.1 and Fig. 5).

use glam::Vec3;

use super::cone::Cone;
use super::rules::{Comparison, Rules, Unlit, Weighting};
use super::{Entry, MOST_CONES, angle_between};

/// One update of an entry: samples are added, then [`Update::finish`] takes them into the mean.
pub struct Update<'a> {
    pub(super) rules: &'a Rules,
    pub(super) entry: Entry,
    /// X: light that the samples of this update brought into each cone, a mean over all of them.
    pub(super) arrived: [Vec3; MOST_CONES],
    /// Whether one fell into it.
    pub(super) lit: [bool; MOST_CONES],
    /// Largest turn of an axis so far, radians.
    pub(super) turn: f32,
    /// Samples of the update, once they are averaged.
    pub(super) samples: u32,
    /// Whether the count was lowered.
    lowered: bool,
}

impl<'a> Update<'a> {
    /// Begins with what an entry holds.
    pub fn of(entry: Entry, rules: &'a Rules) -> Self {
        Self {
            rules,
            entry,
            arrived: [Vec3::ZERO; MOST_CONES],
            lit: [false; MOST_CONES],
            turn: 0.0,
            samples: 0,
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
        let cone = self.cone_for(direction);
        self.arrived[cone] += light;
        self.lit[cone] = true;
    }

    /// The cone that a sample belongs to, after it has been made or widened for it.
    fn cone_for(&mut self, direction: Vec3) -> usize {
        if let Some(inside) = self.innermost(direction) {
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
        let between = match self.rules.comparison {
            Comparison::Gaps => |a: &Cone, b: &Cone| (a.gap_to(b.axis) - b.half_angle).max(0.0),
            Comparison::Axes => |a: &Cone, b: &Cone| angle_between(a.axis, b.axis),
        };
        // A sample is a cone without width.
        let sample = Cone {
            axis: direction,
            ..Cone::default()
        };
        let distances = self.cones().iter().map(|cone| between(cone, &sample));
        let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let (nearest, distance) = nearest.unwrap_or((0, 0.0));
        match self.entry.closest_pair(between) {
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

    /// (A) The cone that a direction is deepest inside of, measured by its half angle.
    fn innermost(&self, direction: Vec3) -> Option<usize> {
        let depth = |cone: &Cone| angle_between(cone.axis, direction) / cone.half_angle;
        let depths = self.cones().iter().map(depth).enumerate();
        let inside = depths.filter(|(_, depth)| *depth <= 1.0);
        inside.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }

    /// (B) A new cone.
    fn push(&mut self, cone: Cone) -> usize {
        let index = self.entry.used;
        self.entry.cones[index] = cone;
        self.arrived[index] = Vec3::ZERO;
        self.lit[index] = false;
        self.entry.used += 1;
        index
    }

    /// (C) A cone that is widened, or turned otherwise.
    pub(super) fn replace(&mut self, index: usize, cone: Cone) {
        let turn = angle_between(self.entry.cones[index].axis, cone.axis);
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
        self.entry.remove(index);
    }

    /// Takes `samples` samples, those that reached no light included, into the mean.
    pub fn average(&mut self, samples: u32) {
        self.samples = samples;
        self.lower_count();
        let weight = match self.rules.weighting {
            Weighting::Samples => samples as f32,
            Weighting::Updates => 1.0,
        };
        let count = (self.entry.count + weight).min(self.rules.most_count.max(weight));
        self.entry.count = count;
        let share = weight / count;
        for (index, cone) in self.entry.cones[..self.entry.used].iter_mut().enumerate() {
            if self.lit[index] || self.rules.unlit == Unlit::Fades {
                cone.light += (self.arrived[index] - cone.light) * share;
            }
        }
    }

    /// Lowers the count where an axis has turned, once in an update: what comes next then weighs more.
    fn lower_count(&mut self) {
        let turn_deg = self.turn.to_degrees();
        if self.lowered
            || turn_deg <= self.rules.turn_deg
            || self.entry.count <= self.rules.turn_count
        {
            return;
        }
        self.lowered = true;
        let factor = (1.0 + 0.05 * turn_deg).clamp(1.01, 3.0);
        self.entry.count = (self.entry.count / factor).max(1.0);
    }

    /// The entry after the update, without cones that hold next to nothing.
    pub fn finish(mut self) -> Entry {
        self.lower_count();
        self.entry.tidy(self.rules.negligible, &self.lit);
        self.entry
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Frame, Rng};

    fn at(degrees: f32) -> Vec3 {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        Vec3::new(sine, 0.0, cosine)
    }

    fn cone(degrees: f32, half_angle_deg: f32) -> Cone {
        Cone {
            axis: at(degrees),
            half_angle: half_angle_deg.to_radians(),
            light: Vec3::ONE,
        }
    }

    /// Where cones are (degrees from z, half angle) after a sample was added to some.
    fn added(cones: &[Cone], degrees: f32) -> Vec<[i32; 2]> {
        let rules = Rules::default();
        let mut update = Update::of(Entry::of(cones, 10.0), &rules);
        update.add(at(degrees), Vec3::ONE);
        let place = |cone: &Cone| {
            let angle = cone.axis.x.atan2(cone.axis.z);
            [angle, cone.half_angle].map(|a| a.to_degrees().round() as i32)
        };
        update.cones().iter().map(place).collect()
    }

    #[test]
    fn a_sample_inside_a_cone_changes_none() {
        assert_eq!(added(&[cone(0.0, 10.0)], 9.0), [[0, 10]]);
        // Of two cones around it the one that it is deeper in takes it.
        let rules = Rules::default();
        let both = Entry::of(&[cone(0.0, 30.0), cone(30.0, 10.0)], 0.0);
        let mut update = Update::of(both, &rules);
        update.add(at(27.0), Vec3::ONE);
        assert_eq!(update.lit[..2], [false, true]);
    }

    #[test]
    fn a_sample_outside_makes_a_cone_while_there_is_room() {
        assert_eq!(added(&[], 5.0), [[5, 1]]);
        let two = [cone(0.0, 10.0), cone(40.0, 5.0)];
        assert_eq!(added(&two, -30.0), [[0, 10], [40, 5], [-30, 1]]);
    }

    #[test]
    fn a_sample_near_a_cone_widens_it_when_all_are_taken() {
        let three = [cone(-60.0, 5.0), cone(0.0, 5.0), cone(60.0, 5.0)];
        assert_eq!(added(&three, 15.0), [[-60, 5], [5, 10], [60, 5]]);
    }

    #[test]
    fn otherwise_the_closest_cones_are_merged() {
        let three = [cone(-60.0, 5.0), cone(0.0, 5.0), cone(16.0, 5.0)];
        assert_eq!(added(&three, 60.0), [[-60, 5], [8, 13], [60, 1]]);
        let rules = Rules::default();
        let mut update = Update::of(Entry::of(&three, 10.0), &rules);
        update.add(at(60.0), Vec3::ONE);
        assert_eq!(update.cones()[1].light, Vec3::splat(2.0));
    }

    #[test]
    fn a_single_cone_takes_everything() {
        let rules = Rules {
            cones: 1,
            ..Rules::default()
        };
        let mut update = Update::of(Entry::default(), &rules);
        for degrees in [0.0, 50.0, -20.0] {
            update.add(at(degrees), Vec3::splat(0.25));
        }
        assert_eq!(update.cones().len(), 1);
        let gaps = [0.0, 50.0, -20.0].map(|d| update.cones()[0].gap_to(at(d)));
        assert!(gaps.iter().all(|gap| *gap < 1e-4), "{gaps:?}");
        update.average(4);
        assert!((update.finish().light() - 0.75).length() < 1e-6);
    }

    /// Whatever becomes of the cones, all light together is the mean of all samples.
    #[test]
    fn light_is_the_mean_of_all_samples_however_cones_merge() {
        for cones in [1, 3, 8] {
            let rules = Rules {
                cones,
                turn_count: 256.0,
                negligible: 0.0,
                most_count: 255.0,
                ..Rules::default()
            };
            let mut rng = Rng::new(1, 0, cones as u64, 0);
            let mut entry = Entry::default();
            let mut sum = 0.0f64;
            let updates = 30;
            for _ in 0..updates {
                let mut update = Update::of(entry, &rules);
                for _ in 0..8 {
                    let light = rng.next_f32() * 2.0 - 1.0;
                    let frame = Frame::from_normal(Vec3::Z);
                    let half = cone(0.0, 90.0);
                    let direction = half.direction(&frame, [rng.next_f32(), rng.next_f32()]);
                    if light > 0.0 {
                        update.add(direction, Vec3::splat(light / 8.0));
                        sum += f64::from(light);
                    }
                }
                update.average(8);
                entry = update.finish();
                assert!(entry.cones().len() <= cones);
                let sound = |c: &Cone| c.axis.is_normalized() && c.half_angle <= 1.5708;
                assert!(entry.cones().iter().all(sound));
            }
            let mean = sum / f64::from(8 * updates);
            let found = f64::from(entry.light().x);
            assert!((found / mean - 1.0).abs() < 1e-4, "{found} {mean}");
        }
    }

    #[test]
    fn a_turn_lowers_the_count_once() {
        let rules = Rules::default();
        let full = [cone(-60.0, 1.43), cone(0.0, 10.0), cone(60.0, 1.43)];
        let mut update = Update::of(Entry::of(&full, 100.0), &rules);
        update.add(at(30.0), Vec3::ONE);
        // By 10°: 1.5 times.
        update.average(8);
        let count = update.entry.count;
        assert!((count - (100.0 / 1.5 + 8.0)).abs() < 1e-2, "{count}");
        assert_eq!(update.finish().count, count);
        // Very far: 3 times; and never below 1.
        let mut update = Update::of(Entry::of(&full, 5.0), &rules);
        update.turn = 2.0;
        update.average(1);
        assert!((update.entry.count - (5.0 / 3.0 + 1.0)).abs() < 1e-4);
    }

    #[test]
    fn light_that_is_gone_fades() {
        let rules = Rules::default();
        let mut entry = Entry::of(&[cone(0.0, 5.0)], 0.0);
        for _ in 0..200 {
            let mut update = Update::of(entry, &rules);
            update.average(8);
            entry = update.finish();
        }
        assert_eq!(entry.cones().len(), 0, "{entry:?}");
        let stays = Rules {
            unlit: Unlit::Stays,
            ..rules
        };
        let mut update = Update::of(Entry::of(&[cone(0.0, 5.0)], 20.0), &stays);
        update.average(8);
        assert_eq!(update.finish().light(), Vec3::ONE);
    }
}
