//! Cuckoo hashing: a key lies in one of three or four places, so that a lookup reads at most as many.
//!
//! Building follows Alcantara (2011): a key that finds its places taken displaces another, which goes on to
//! its own next place, until one is free; a chain that is too long begins all anew with another constant. The paper describes two functions and
//! 1.1 slots a key, which two functions cannot do (they fill half of the slots at most); three and four can, as in Alcantara's library. The
//! functions are multiples of one hash added to another, which fill as much as independent ones (Mitzenmacher et al. 2012).

use super::map::{EMPTY, Keys, Table, key_of};
use crate::sample::hash;

/// Slots a key at the first try, and the growth with each that failed (section 3.1).
const FACTOR: f64 = 1.1;
const GROWTH: f64 = 1.01;

/// A table of all keys; [`Table::rebuilds`] says how many tries failed.
pub(super) fn build(keys: &Keys, functions: u32) -> Table {
    let mut factor = FACTOR;
    for rebuilds in 0.. {
        let slots = (keys.len() as f64 * factor).ceil() as usize;
        let mut table = Table::empty(slots, hash(u64::from(rebuilds)));
        table.rebuilds = rebuilds;
        let longest = longest_chain(keys.len(), slots);
        let filled = match functions {
            3 => fill::<3>(&mut table, keys, longest),
            _ => fill::<4>(&mut table, keys, longest),
        };
        if filled {
            return table;
        }
        factor *= GROWTH;
    }
    unreachable!("it grows until there is room for every key")
}

/// Keys that one insertion may displace: the empirical bound of Alcantara's library for three functions, and at least 7 lg n.
fn longest_chain(keys: usize, slots: usize) -> u32 {
    let log = (keys.max(2) as f64).log2();
    let slope = 0.028255 + 1.1594772 * (keys as f64 / slots as f64).ln();
    let empirical = if slope < 0.0 {
        4.0 * (-log / slope).ceil()
    } else {
        0.0
    };
    empirical.max(7.0 * log).max(32.0) as u32
}

/// The places of a key.
#[inline]
fn places<const FUNCTIONS: usize>(table: &Table, key: u32) -> [usize; FUNCTIONS] {
    let [start, step] = table.hashes(key);
    std::array::from_fn(|i| table.position(start.wrapping_add(step.wrapping_mul(i as u32))))
}

/// Whether all keys found a place.
fn fill<const FUNCTIONS: usize>(table: &mut Table, keys: &Keys, longest: u32) -> bool {
    keys.slots()
        .all(|slot| insert::<FUNCTIONS>(table, slot, longest))
}

fn insert<const FUNCTIONS: usize>(table: &mut Table, mut slot: u64, longest: u32) -> bool {
    // The place that the key was displaced from.
    let mut left = None;
    for _ in 0..=longest {
        let places = places::<FUNCTIONS>(table, key_of(slot));
        if let Some(&free) = places.iter().find(|&&place| table.slots[place] == EMPTY) {
            table.slots[free] = slot;
            return true;
        }
        let from = places.iter().rposition(|&place| Some(place) == left);
        let next = places[from.map_or(0, |from| (from + 1) % FUNCTIONS)];
        std::mem::swap(&mut table.slots[next], &mut slot);
        left = Some(next);
    }
    false
}

/// Index of a key, if it is there.
#[inline]
pub(super) fn find<const FUNCTIONS: usize>(table: &Table, key: u32) -> Option<u32> {
    let slots = places::<FUNCTIONS>(table, key).map(|place| table.slots[place]);
    let found = slots.into_iter().find(|&slot| key_of(slot) == key)?;
    Some(found as u32)
}
