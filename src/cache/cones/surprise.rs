//! Noticing that the light of an entry has changed, where no cone says so: what a shadow hides turns no cone, nor does a lamp
//! that is dimmed.

use glam::Vec3;

use super::Update;
use crate::image::luminance;

/// What the last updates brought, as luminance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Watch {
    /// Their mean, which forgets a quarter in each update.
    pub recent: f32,
    /// Mean distance of an update from it.
    pub spread: f32,
}

/// How much of `recent` is the newest update.
const RECENT: f32 = 0.25;
/// How much of `spread` is the newest update, at least.
const SPREAD: f32 = 0.125;
/// Updates before there is anything to compare with.
const FIRST: f32 = 2.0;
/// A spread below this part of the light is taken for that much: some updates are equal by chance.
const LEAST_SPREAD: f32 = 0.05;
/// The standard deviation of normally distributed numbers, over their mean distance from the mean.
const DEVIATION: f32 = 1.2533;

impl Update<'_> {
    /// Compares the light of the last updates with that of the entry, once all samples were added. Where they differ by more
    /// than chance explains, the count is lowered, the more the less chance explains it: what comes next then weighs more.
    pub fn watch(&mut self) {
        let count = self.entry.count;
        let arrived = self.arrived[..self.entry.used].iter().copied();
        let now = luminance(arrived.sum::<Vec3>().into());
        let before = luminance(self.entry.light().into());
        let watch = &mut self.entry.watch;
        if count <= 0.0 {
            watch.recent = now;
            return;
        }
        let weight = self.rules.weight_of(self.samples);
        let spread = watch.spread.max(LEAST_SPREAD * before.max(watch.recent));
        let mut distance = (now - watch.recent).abs();
        watch.recent += (now - watch.recent) * RECENT;
        let apart = (watch.recent - before).abs();
        // What is left of the variance of an update in either mean.
        let left = RECENT / (2.0 - RECENT) + weight / count;
        let by_chance = self.rules.surprise * DEVIATION * spread * left.sqrt();
        if count >= FIRST * weight && apart > by_chance {
            self.lowered = true;
            let surprise = (apart / by_chance).powi(2);
            self.entry.count = count / (self.rules.doubt * surprise);
            watch.recent += (now - watch.recent) * (1.0 - 1.0 / (1.0 + surprise));
            distance = distance.min(2.0 * spread);
        }
        watch.spread += (distance - watch.spread) * (weight / count).clamp(SPREAD, 1.0);
    }
}
