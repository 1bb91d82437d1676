//! Which lights were hidden from a block of texels of late: what they would add without shadows is then no guide to what they
//! add.
//!
//! The paper has nothing of the kind; Guo, Eisemann & Eisemann ("Next Event Estimation++", 2020) remember what is seen between
//! voxels. Lights are remembered in groups, with one number each of samples and of those among them that arrived. No group is
//! ever given up, so that what is chosen less counts for more when it arrives.

use crate::shade::LIGHT_GROUPS;

/// Words of a block's memory: two bytes a group.
pub(super) const WORDS: usize = LIGHT_GROUPS / 2;
/// Samples that are remembered at most; then all numbers are halved, so that what moves is forgotten.
const MOST: u32 = 32;

/// What a block remembers, in its words.
pub(super) struct Hidden<'b> {
    words: &'b mut [u32],
}

impl<'b> Hidden<'b> {
    /// The memory of a block in [`WORDS`] words; zeros remember nothing.
    pub fn of(words: &'b mut [u32]) -> Self {
        Self { words }
    }

    /// Samples, and those that arrived.
    fn counts(&self, group: usize) -> [u32; 2] {
        let half = self.words[group / 2] >> (16 * (group % 2));
        [half & 0xff, half >> 8 & 0xff]
    }

    /// Remembers whether a sample of a group arrived.
    pub fn remember(&mut self, group: u32, arrived: bool) {
        let group = group as usize;
        let [mut samples, mut arrivals] = self.counts(group);
        if samples >= MOST {
            (samples, arrivals) = (samples / 2, arrivals / 2);
        }
        samples += 1;
        arrivals += u32::from(arrived);
        let shift = 16 * (group % 2);
        let word = &mut self.words[group / 2];
        *word = *word & !(0xffff << shift) | (samples | arrivals << 8) << shift;
    }

    /// What each group's light is multiplied with when samples are chosen: about the share of samples that arrived, 1 where
    /// nothing is known.
    pub fn chances(&self) -> [f32; LIGHT_GROUPS] {
        std::array::from_fn(|group| {
            let [samples, arrivals] = self.counts(group);
            (arrivals + 1) as f32 / (samples + 1) as f32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_arrives_seldom_is_chosen_seldom_but_never_not_at_all() {
        let mut words = [0; WORDS];
        let mut hidden = Hidden::of(&mut words);
        assert_eq!(hidden.chances(), [1.0; LIGHT_GROUPS]);
        for number in 0..1000 {
            hidden.remember(3, false);
            hidden.remember(4, true);
            hidden.remember(15, number % 4 == 0);
        }
        let chances = hidden.chances();
        assert!(chances[3] > 0.02 && chances[3] < 0.1, "{}", chances[3]);
        assert_eq!(chances[4], 1.0);
        assert!((chances[15] - 0.25).abs() < 0.1, "{}", chances[15]);
        let others = (0..LIGHT_GROUPS).filter(|group| ![3, 4, 15].contains(group));
        others.for_each(|group| assert_eq!(chances[group], 1.0));
        // What comes out from behind something is soon known.
        (0..32).for_each(|_| hidden.remember(3, true));
        assert!(hidden.chances()[3] > 0.6);
    }
}
