//! Noticing that light has moved: it arrives from where no cone was.
//!
//! *Differs* from the paper, in which only turns of a cone lower the count. Light that moves farther than it is wide turns none:
//! it makes a new cone, while the old one fades as slowly as the mean forgets.

use glam::Vec3;

use super::shrink::SAMPLES_TO_DOUBT;
use super::{Entry, Update};
use crate::image::luminance;

/// Light of an update that arrives from where no cone was.
pub(super) struct News {
    /// The entry as the update found it.
    before: Entry,
    /// Luminance of the samples from outside its cones.
    light: f32,
    /// Luminance of the two brightest of them, the brighter one first.
    brightest: [f32; 2],
}

impl News {
    /// Takes note of a sample of this luminance.
    pub fn hear(&mut self, direction: Vec3, bright: f32) {
        if self.before.cones().iter().any(|cone| cone.holds(direction)) {
            return;
        }
        self.light += bright;
        let [first, second] = self.brightest;
        self.brightest = [first.max(bright), second.max(first.min(bright))];
    }

    /// What of it says that the light has moved. The two brightest samples do not: of a strong light that is seldom met comes
    /// one or two, of one that has moved most of all.
    fn evidence(&self) -> f32 {
        self.light - self.brightest.iter().sum::<f32>()
    }
}

impl Update<'_> {
    /// Listens for light from outside the cones as they are now, before samples are added. Only for lights that may have
    /// changed.
    pub fn listen(&mut self) {
        self.news = Some(News {
            before: self.entry,
            light: 0.0,
            brightest: [0.0; 2],
        });
    }

    /// Lowers the count by the part of the light that came from outside all cones of before, once all samples were added: what
    /// comes next then weighs more.
    pub fn take_news(&mut self) {
        let Some(news) = &self.news else {
            return;
        };
        let arrived: Vec3 = self.arrived[..self.entry.used].iter().sum();
        let all = luminance(arrived.into());
        if self.samples >= SAMPLES_TO_DOUBT && all > 0.0 {
            let known = (1.0 - news.evidence() / all).clamp(0.0, 1.0);
            self.forget(known.powf(-self.rules.news));
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
        update.listen();
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
