//! Reservoirs of several surfaces become one (Bitterli et al. 2020, algorithms 4 and 6).

use super::receiver::{Receiver, Surface};
use super::reservoir::{Reservoir, Selected, Selecting};
use super::settings::{Settings, Weights};
use crate::sample::Rng;
use crate::technique::Shot;
use crate::trace::Caster;

/// A reservoir and the surface that it was made for.
#[derive(Clone, Copy, Debug)]
pub struct Offer {
    pub reservoir: Reservoir,
    pub surface: Surface,
}

/// What combines.
pub struct Combining<'a> {
    pub shot: &'a Shot<'a>,
    pub settings: &'a Settings,
}

impl Combining<'_> {
    /// The surface's own reservoir with those of others, and the weights that were not finite.
    ///
    /// Where weights see shadows, the sample of each reservoir is seen by the reservoir's own surface, in the result as
    /// well as in what is given; only then is what a surface could have drawn the same as what it is lit by, and the result
    /// unbiased.
    pub fn combined(
        &self,
        receiver: &Receiver,
        own: Reservoir,
        others: &[Offer],
        caster: &Caster,
        rng: &mut Rng,
    ) -> (Reservoir, u64) {
        let mut selecting = Selecting::default();
        let reservoirs = || std::iter::once(own).chain(others.iter().map(|o| o.reservoir));
        for (source, reservoir) in reservoirs().enumerate() {
            let u = rng.next_f64();
            let Some(place) = reservoir.place else {
                continue;
            };
            let target = receiver.target(&place);
            let sample = Selected {
                place,
                target,
                source,
            };
            let count = f64::from(reservoir.count);
            let weight = f64::from(target) * f64::from(reservoir.weight) * count;
            selecting.offer(sample, weight, u);
        }
        let count: u32 = reservoirs().map(|reservoir| reservoir.count).sum();
        let share = match (selecting.selected, self.settings.weights) {
            (None, _) => 0.0,
            (_, Weights::Count) => 1.0 / f64::from(count),
            (Some(selected), _) => {
                let own = Own {
                    receiver,
                    count: own.count,
                };
                self.share(&selected, &own, others, caster)
            }
        };
        (selecting.reservoir(count, share), selecting.non_finite)
    }

    /// What the sum of weights is to be multiplied by.
    fn share(&self, selected: &Selected, own: &Own, others: &[Offer], caster: &Caster) -> f64 {
        let shadows = self.settings.sees_shadows();
        let foreign = selected.source > 0;
        if shadows && foreign && own.receiver.shadowed_target(caster, &selected.place) == 0.0 {
            return 0.0;
        }
        let mut of_source = selected.target;
        // Counts of those that could have drawn the sample, and counts times targets.
        let mut support = u64::from(own.count);
        let mut targets = f64::from(own.count) * f64::from(selected.target);
        for (source, offer) in (1..).zip(others) {
            let receiver = Receiver::new(self.shot, &offer.surface);
            let target = match shadows && source != selected.source {
                true => receiver.shadowed_target(caster, &selected.place),
                false => receiver.target(&selected.place),
            };
            if source == selected.source {
                of_source = target;
            }
            if target > 0.0 {
                support += u64::from(offer.reservoir.count);
            }
            targets += f64::from(offer.reservoir.count) * f64::from(target);
        }
        match self.settings.weights {
            Weights::Balance => f64::from(of_source) / targets,
            _ => 1.0 / support as f64,
        }
    }
}

/// The surface that combines.
struct Own<'a> {
    receiver: &'a Receiver<'a>,
    /// Samples of its own reservoir.
    count: u32,
}
