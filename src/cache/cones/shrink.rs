//! Closing cones where no light is left (section 3.1.2 and Fig. 7).

use glam::Vec3;

use super::cone::{Cone, angle_between, turned};
use super::rules::{Shrinking, SmallCones};
use super::{MOST_CONES, Update};

/// Samples of an update without which it says nothing that none met a cone.
pub(super) const SAMPLES_TO_DOUBT: u32 = 4;

/// Where a cone is tested for light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EdgeTest {
    /// Which cone of the entry.
    pub cone: usize,
    /// Unit, near its edge.
    pub direction: Vec3,
}

impl Update<'_> {
    /// A direction near the edge of a cone; `turn` in [0, 1) goes around it.
    pub fn edge_of(&self, cone: usize, turn: f32) -> EdgeTest {
        let Cone { half_angle, .. } = self.cones()[cone];
        let angle = half_angle * (1.0 - self.rules.edge);
        EdgeTest {
            cone,
            direction: self.cones()[cone].direction_at(angle, turn),
        }
    }

    /// Lowers the count where a cone is dark at its edge and no sample met it: its light may be gone, and what comes next
    /// weighs more. The fewer samples reach a light at all, the less that says: those that do not were sent to strong lights
    /// that something hides, and had none left for this cone. Only for lights that may have changed: weak ones are missed by
    /// most updates anyway.
    pub fn doubt(&mut self, dark: &[EdgeTest]) {
        let doubtful = |test: &EdgeTest| !self.lit[test.cone];
        if self.samples >= SAMPLES_TO_DOUBT && dark.iter().any(doubtful) {
            let evidence = self.arrivals as f32 / self.samples as f32;
            self.forget(self.rules.doubt.powf(evidence));
        }
    }

    /// Shrinks the cones of tests that met no light.
    pub fn shrink(&mut self, dark: &[EdgeTest]) {
        let mut gone = [false; MOST_CONES];
        for test in dark {
            gone[test.cone] = self.shrink_one(test);
        }
        for index in (0..self.entry.used).rev().filter(|&i| gone[i]) {
            self.remove(index);
        }
    }

    /// Shrinks a cone away from a dark direction; says whether it is gone.
    fn shrink_one(&mut self, test: &EdgeTest) -> bool {
        let cone = self.entry.cones[test.cone];
        if cone.half_angle < self.rules.small_deg.to_radians() {
            return match self.rules.small_cones {
                SmallCones::Fade => false,
                SmallCones::Removed => true,
                SmallCones::RemovedUnlit => !self.lit[test.cone],
            };
        }
        let depth = (cone.half_angle - angle_between(cone.axis, test.direction)).max(0.0);
        let narrower = match self.rules.shrinking {
            Shrinking::FarEdge => 0.5 * depth,
            Shrinking::Literal => depth,
        };
        let shrunk = Cone {
            axis: turned(cone.axis, test.direction, -0.5 * depth),
            half_angle: (cone.half_angle - narrower).max(self.rules.least_angle()),
            light: cone.light,
        };
        self.replace(test.cone, shrunk);
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::cones::{Entry, Rules};

    fn wide() -> Entry {
        let cone = Cone {
            axis: Vec3::Z,
            half_angle: 20f32.to_radians(),
            light: Vec3::ONE,
        };
        Entry::of(&[cone], 50.0)
    }

    fn shrunk(rules: &Rules) -> (Cone, Vec3) {
        let mut update = Update::of(wide(), rules, 8);
        let test = update.edge_of(0, 0.0);
        let from_axis = angle_between(test.direction, Vec3::Z).to_degrees();
        assert!((from_axis - 18.0).abs() < 1e-3, "{from_axis}");
        update.shrink(&[test]);
        (update.finish().cones()[0], test.direction)
    }

    #[test]
    fn the_far_edge_stays_and_the_near_one_comes_to_the_test() {
        let (cone, dark) = shrunk(&Rules::default());
        assert!((cone.half_angle.to_degrees() - 19.0).abs() < 1e-3);
        assert!(cone.gap_to(dark).abs() < 1e-5, "{}", cone.gap_to(dark));
        let far = Vec3::new(-dark.x, -dark.y, dark.z);
        let far = turned(far, Vec3::Z, -2f32.to_radians());
        assert!(cone.gap_to(far).abs() < 1e-5, "{}", cone.gap_to(far));
        assert_eq!(cone.light, Vec3::ONE);
    }

    #[test]
    fn to_the_letter_both_edges_move() {
        let rules = Rules {
            shrinking: Shrinking::Literal,
            ..Rules::default()
        };
        let (cone, dark) = shrunk(&rules);
        assert!((cone.half_angle.to_degrees() - 18.0).abs() < 1e-3);
        assert!((cone.gap_to(dark).to_degrees() - 1.0).abs() < 1e-3);
    }

    #[test]
    fn small_cones_stay_or_go_as_told() {
        for (small_cones, lit, left) in [
            (SmallCones::Fade, false, 1),
            (SmallCones::Removed, true, 0),
            (SmallCones::RemovedUnlit, true, 1),
            (SmallCones::RemovedUnlit, false, 0),
        ] {
            let rules = Rules {
                small_cones,
                ..Rules::default()
            };
            let mut entry = wide();
            entry.cones[0].half_angle = 1.5f32.to_radians();
            let mut update = Update::of(entry, &rules, 8);
            if lit {
                update.add(Vec3::Z, Vec3::ONE);
            }
            let test = update.edge_of(0, 0.4);
            update.shrink(&[test]);
            assert_eq!(update.finish().cones().len(), left, "{small_cones:?}");
        }
    }

    #[test]
    fn a_dark_cone_that_no_sample_meets_is_doubted_as_far_as_samples_arrive() {
        let rules = Rules {
            turn_deg: 5.0,
            ..Rules::default()
        };
        let count = |samples: u32, met: u32, missed: u32| {
            let mut update = Update::of(wide(), &rules, samples);
            (0..met).for_each(|_| update.add(Vec3::Z, Vec3::ONE));
            (0..missed).for_each(|_| update.add(Vec3::X, Vec3::ONE));
            update.average();
            let test = update.edge_of(0, 0.4);
            update.doubt(&[test]);
            update.shrink(&[test]);
            update.finish().count
        };
        assert_eq!(count(1, 0, 1), 51.0);
        assert_eq!(count(10, 1, 9), 60.0);
        assert_eq!(count(10, 0, 10), 7.5);
        let half = 60.0 / 8f32.sqrt();
        assert!((count(10, 0, 5) - half).abs() < 1e-4);
        assert_eq!(count(10, 0, 0), 60.0);
    }

    #[test]
    fn a_cone_never_shrinks_below_the_least() {
        let rules = Rules::default();
        let mut entry = wide();
        for i in 0..2000 {
            let mut update = Update::of(entry, &rules, 8);
            let test = update.edge_of(0, (i as f32 * 0.618).fract());
            update.shrink(&[test]);
            entry = update.finish();
        }
        let left = entry.cones()[0].half_angle.to_degrees();
        assert!((1.429..2.0).contains(&left), "{left}");
    }
}
