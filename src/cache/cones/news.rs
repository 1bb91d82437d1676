//! Noticing that light has moved: it arrives from where no cone was.
//!
//! *Differs* from the paper, in which only turns of a cone lower the count. Light that moves farther than it is wide turns none:
//! it makes a new cone, while the old one fades as slowly as the mean forgets.

use glam::Vec3;

use super::Update;
use super::shrink::SAMPLES_TO_DOUBT;
use crate::image::luminance;

impl Update<'_> {
    /// Whether a direction lay in a cone when the update began.
    pub(super) fn is_known(&self, direction: Vec3) -> bool {
        self.before.cones().iter().any(|cone| cone.holds(direction))
    }

    /// Lowers the count by the part of the light that came from outside all cones of before, once all samples were added: what
    /// comes next then weighs more. Only for lights that may have changed. The two brightest samples from outside are no
    /// evidence: of a strong light that is seldom met comes one or two, of one that has moved most of all.
    pub fn take_news(&mut self) {
        let arrived: Vec3 = self.arrived[..self.entry.used].iter().sum();
        let all = luminance(arrived.into());
        if self.samples >= SAMPLES_TO_DOUBT && self.news > 0.0 && all > 0.0 {
            let evidence = self.news - self.brightest_news.iter().sum::<f32>();
            let known = (1.0 - evidence / all).clamp(0.0, 1.0);
            self.entry.count *= known.powf(self.rules.news);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::cones::{Cone, Entry, Rules};

    /// The count of an entry with one cone after an update in which so many samples of all arrive from outside it.
    fn count(rules: &Rules, samples: u32, outside: u32) -> f32 {
        let cone = Cone {
            axis: Vec3::Z,
            half_angle: 0.1,
            light: Vec3::ONE,
        };
        let mut update = Update::of(Entry::of(&[cone], 40.0), rules, samples);
        for number in 0..samples {
            let direction = match number < outside {
                true => Vec3::new(0.6, 0.0, 0.8),
                false => Vec3::Z,
            };
            update.add(direction, Vec3::splat(1.0 / samples as f32));
        }
        update.take_news();
        update.average();
        update.finish().count
    }

    #[test]
    fn light_that_has_moved_lowers_the_count() {
        let rules = Rules {
            news: 1.0,
            ..Rules::default()
        };
        assert_eq!(count(&rules, 8, 0), 48.0);
        assert_eq!(count(&rules, 8, 4), 38.0);
        assert_eq!(count(&rules, 8, 8), 18.0);
        let by_default = count(&Rules::default(), 8, 8);
        assert!((8.0..8.01).contains(&by_default), "{by_default}");
        // One or two samples say nothing.
        assert_eq!(count(&Rules::default(), 8, 2), 48.0);
        assert_eq!(count(&Rules::default(), 1, 1), 41.0);
        let never = Rules {
            news: 0.0,
            ..Rules::default()
        };
        assert_eq!(count(&never, 8, 8), 48.0);
    }
}
