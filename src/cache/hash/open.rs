//! Open addressing: a key lies in the first free place from the one that its hash names, and a lookup reads
//! on until it finds it or a free place.

use super::map::{EMPTY, Keys, Table, key_of};
use crate::sample::hash;

/// Largest share of slots that are taken.
const LOAD: f64 = 0.7;

/// A table of all keys.
pub(super) fn build(keys: &Keys) -> Table {
    let slots = (keys.len() as f64 / LOAD).ceil() as usize;
    let mut table = Table::empty(slots.max(keys.len() + 1), hash(0));
    for slot in keys.slots() {
        let mut place = table.position(table.hashes(key_of(slot))[0]);
        while table.slots[place] != EMPTY {
            place = after(place, &table);
        }
        table.slots[place] = slot;
    }
    table
}

/// Index of a key, if it is there.
#[inline]
pub(super) fn find(table: &Table, key: u32) -> Option<u32> {
    let mut place = table.position(table.hashes(key)[0]);
    loop {
        let slot = table.slots[place];
        if slot == EMPTY {
            return None;
        }
        if key_of(slot) == key {
            return Some(slot as u32);
        }
        place = after(place, table);
    }
}

#[inline]
fn after(place: usize, table: &Table) -> usize {
    if place + 1 == table.slots.len() {
        0
    } else {
        place + 1
    }
}
