//! Noticing that the light of an entry has changed, where no cone says so: what a shadow hides turns no cone, nor does a lamp
//! that is dimmed.

use glam::Vec3;

use super::Update;
use crate::image::luminance;

/// What the last updates brought, as luminance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Watch {
    /// Their mean, of which the newest one is [`super::Rules::recent`].
    pub recent: f32,
    /// Standard deviation of an update from it.
    pub spread: f32,
}

/// How much of `spread` is the newest update, at least.
const SPREAD: f32 = 0.125;
/// Updates before there is anything to compare with.
const FIRST: f32 = 2.0;
/// A spread below this part of the light is taken for that much: some updates are equal by chance.
const LEAST_SPREAD: f32 = 0.05;

impl Update<'_> {
    /// Compares the light of the last updates with that of the entry, once all samples were added. Where they differ by more
    /// than chance explains, the count is lowered, the more the less chance explains it: what comes next then weighs more.
    pub fn watch(&mut self) {
        let count = self.entry.count;
        let arrived = self.arrived[..self.entry.used].iter().copied();
        let now = luminance(arrived.sum::<Vec3>().into());
        let before = luminance(self.entry.light().into());
        let mut watch = self.entry.watch;
        if count <= 0.0 {
            self.entry.watch.recent = now;
            return;
        }
        let weight = self.rules.weight_of(self.samples);
        // Of samples that arrive seldom most updates say nothing of how far the others spread. The variance of samples of
        // equal light that arrive by chance is at most their light times that of one of them.
        let seldom = (self.rules.seldom * before * self.largest).sqrt();
        let least = seldom.max(LEAST_SPREAD * before.max(watch.recent));
        let spread = watch.spread.max(least);
        let mut distance = (now - watch.recent).abs();
        watch.recent += (now - watch.recent) * self.rules.recent;
        let apart = (watch.recent - before).abs();
        // What is left of the variance of an update in either mean.
        let recent = self.rules.recent;
        let left = recent / (2.0 - recent) + weight / count;
        let by_chance = self.rules.surprise * spread * left.sqrt();
        if count >= FIRST * weight && apart > by_chance {
            self.lowered = true;
            let surprise = (apart / by_chance).powi(2);
            self.forget(self.rules.surprised * surprise);
            watch.recent += (now - watch.recent) * (1.0 - 1.0 / (1.0 + surprise));
            distance = distance.min(2.0 * spread);
        }
        let newest = (weight / count).clamp(SPREAD, 1.0);
        let squares = [watch.spread, distance].map(|distance| distance * distance);
        watch.spread = (squares[0] + (squares[1] - squares[0]) * newest).sqrt();
        self.entry.watch = watch;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::cones::{Entry, Rules};
    use crate::sample::Rng;

    /// An entry after updates of eight samples, each of which arrives with a chance.
    fn updated(mut entry: Entry, updates: u32, chance: f32, light: f32, rng: &mut Rng) -> Entry {
        let rules = Rules::default();
        for _ in 0..updates {
            let mut update = Update::of(entry, &rules, 8);
            for _ in 0..8 {
                if rng.next_f32() < chance {
                    update.add(Vec3::Z, Vec3::splat(light / 8.0));
                }
            }
            update.watch();
            update.average();
            entry = update.finish();
        }
        entry
    }

    #[test]
    fn what_changes_is_followed_within_some_updates() {
        for (before, after) in [(1.0, 0.0), (0.0, 1.0), (1.0, 0.02), (0.02, 1.0), (0.5, 0.0)] {
            let mut rng = Rng::new(1, 0, 0, 0);
            // Chances of less than a tenth are strengths.
            let [was, is] = [before, after].map(|share| match share > 0.1 {
                true => [share, 1.0],
                false => [1.0, share],
            });
            let entry = updated(Entry::default(), 60, was[0], was[1], &mut rng);
            let entry = updated(entry, 10, is[0], is[1], &mut rng);
            let left = (entry.light().x - after).abs() / before.max(after);
            assert!(left < 0.03, "{before} to {after}: {left}");
        }
    }

    #[test]
    fn chance_alone_lowers_the_count_seldom() {
        for (chance, least_count, bias) in [
            (0.02, 100.0, 0.6),
            (0.1, 110.0, 0.1),
            (0.5, 200.0, 0.04),
            (0.9, 240.0, 0.03),
            (1.0, 250.0, 0.01),
        ] {
            let mut rng = Rng::new(2, 0, 0, 0);
            let mut entry = updated(Entry::default(), 40, chance, 1.0, &mut rng);
            let (mut counts, mut mean) = (0.0, 0.0);
            for _ in 0..2000 {
                entry = updated(entry, 1, chance, 1.0, &mut rng);
                counts += entry.count / 2000.0;
                mean += entry.light().x / 2000.0;
            }
            assert!(counts > least_count, "chance {chance}: {counts}");
            assert!(
                (mean / chance - 1.0).abs() < bias,
                "chance {chance}: {mean}"
            );
        }
    }

    #[test]
    fn light_that_is_no_number_or_none_is_no_surprise() {
        let mut rng = Rng::new(3, 0, 0, 0);
        let dark = updated(Entry::default(), 20, 0.0, 1.0, &mut rng);
        assert_eq!((dark.count, dark.watch), (160.0, Watch::default()));
        let mut entry = updated(dark, 20, 1.0, 1.0, &mut rng);
        entry.watch.recent = f32::NAN;
        let after = updated(entry, 1, 1.0, 1.0, &mut rng);
        assert_eq!(after.count, entry.count + 8.0);
    }
}
