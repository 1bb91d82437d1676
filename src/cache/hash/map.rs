//! From the key of a cell to its number.
//!
//! A slot holds a 32-bit key and a 32-bit index. A map of 32-bit keys covers 1024³ cells, so that higher levels have several, as in the paper
//! (section 3.1): the lower 30 bits of a Morton key are looked up in the table that the higher bits choose.

use std::borrow::Cow;

use rayon::prelude::*;

use super::blocks::{Blocks, block_of};
use super::{cuckoo, open};
use crate::entry::words;
use crate::memory::room_for;

words! {
    /// How a key is found.
    pub enum MapKind {
        /// Cuckoo hashing with four functions of blocks of 4³ cells, and a bit for each of their cells.
        Blocks = "blocks",
        /// Cuckoo hashing with four functions.
        Cuckoo = "cuckoo",
        /// Cuckoo hashing with three functions.
        CuckooThree = "cuckoo-3",
        /// Linear probing from one position, at most 7 of 10 slots taken.
        OpenAddressing = "open-addressing",
    }
}

/// Bits of a key within a table.
const KEY_BITS: u32 = 30;

/// Tables that are numbered directly: all of a level of 4096³ cells.
const DIRECT: usize = 64;

/// Marks a part of space without cells.
const NO_TABLE: u32 = u32::MAX;

/// A slot without a key, which has 30 bits otherwise.
pub(super) const EMPTY: u64 = u64::MAX;

/// The slots of a hash table: key in the upper half, index in the lower.
pub(super) struct Table {
    pub slots: Vec<u64>,
    /// What the keys are mixed with before they are hashed.
    pub constant: u64,
    /// How often building began anew with another constant.
    pub rebuilds: u32,
}

impl Table {
    pub fn empty(slots: usize, constant: u64) -> Self {
        let mut room = room_for(slots);
        room.resize(slots, EMPTY);
        Self {
            slots: room,
            constant,
            rebuilds: 0,
        }
    }

    /// The slot that a 32-bit hash stands for.
    #[inline]
    pub fn position(&self, hash: u32) -> usize {
        ((u64::from(hash) * self.slots.len() as u64) >> 32) as usize
    }

    /// Two independent hashes of a key.
    #[inline]
    pub fn hashes(&self, key: u32) -> [u32; 2] {
        let hash = crate::sample::hash(u64::from(key) ^ self.constant);
        [(hash >> 32) as u32, hash as u32]
    }
}

/// What a table takes up: a key and the index it leads to.
#[inline]
pub(super) fn slot(key: u32, index: u32) -> u64 {
    u64::from(key) << 32 | u64::from(index)
}

#[inline]
pub(super) fn key_of(slot: u64) -> u32 {
    (slot >> 32) as u32
}

/// Keys of one table: consecutive ones with the same upper bits.
pub(super) struct Keys<'a> {
    /// Sorted.
    keys: &'a [u64],
    /// Index of the first.
    first: u32,
}

impl Keys<'_> {
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// The slot of every key; of a repeated key only the first.
    pub fn slots(&self) -> impl Iterator<Item = u64> {
        let inner = |key: u64| (key & ((1 << KEY_BITS) - 1)) as u32;
        self.keys
            .iter()
            .enumerate()
            .filter(|&(i, &key)| i == 0 || self.keys[i - 1] != key)
            .map(move |(i, &key)| slot(inner(key), self.first + i as u32))
    }
}

/// A map from the keys of a level's cells to their rank among them.
pub struct CellMap {
    kind: MapKind,
    /// The upper bits of the keys of each table, ascending.
    prefixes: Vec<u64>,
    /// The table of upper bits below [`DIRECT`], or [`NO_TABLE`].
    direct: [u32; DIRECT],
    tables: Vec<Table>,
    /// Keys in the tables: of cells, or of their blocks.
    keys: usize,
    /// Where the tables lead to blocks.
    blocks: Option<Blocks>,
}

impl CellMap {
    /// Of sorted keys; their tables are built in parallel. The rank of a repeated key is that of its first.
    ///
    /// # Panics
    ///
    /// If there are more than `u32::MAX` keys, or repeated ones in [`MapKind::Blocks`].
    pub fn build(keys: &[u64], kind: MapKind) -> Self {
        assert!(keys.len() <= u32::MAX as usize, "an index has 32 bits");
        let mut keys = Cow::Borrowed(keys);
        let mut blocks = None;
        if kind == MapKind::Blocks {
            let (found, names) = Blocks::of(&keys);
            (keys, blocks) = (Cow::Owned(names), Some(found));
        }
        let mut parts = Vec::new();
        let mut prefixes = Vec::new();
        let mut direct = [NO_TABLE; DIRECT];
        let mut first = 0;
        for part in keys.chunk_by(|a, b| a >> KEY_BITS == b >> KEY_BITS) {
            let prefix = part[0] >> KEY_BITS;
            if let Some(number) = direct.get_mut(prefix as usize) {
                *number = parts.len() as u32;
            }
            prefixes.push(prefix);
            parts.push(Keys { keys: part, first });
            first += part.len() as u32;
        }
        let build = |keys: &Keys| match kind {
            MapKind::Blocks | MapKind::Cuckoo => cuckoo::build(keys, 4),
            MapKind::CuckooThree => cuckoo::build(keys, 3),
            MapKind::OpenAddressing => open::build(keys),
        };
        Self {
            kind,
            prefixes,
            direct,
            tables: parts.par_iter().map(build).collect(),
            keys: keys.len(),
            blocks,
        }
    }

    /// Rank of a key, if it is there.
    #[inline]
    pub fn find(&self, key: u64) -> Option<u32> {
        match &self.blocks {
            None => self.find_in_tables(key),
            Some(blocks) => blocks.find(self.find_in_tables(block_of(key))?, key),
        }
    }

    #[inline]
    fn find_in_tables(&self, key: u64) -> Option<u32> {
        let prefix = key >> KEY_BITS;
        let number = match self.direct.get(prefix as usize) {
            Some(&NO_TABLE) => return None,
            Some(&number) => number as usize,
            None => self.prefixes.binary_search(&prefix).ok()?,
        };
        let table = &self.tables[number];
        let key = (key & ((1 << KEY_BITS) - 1)) as u32;
        match self.kind {
            MapKind::Blocks | MapKind::Cuckoo => cuckoo::find::<4>(table, key),
            MapKind::CuckooThree => cuckoo::find::<3>(table, key),
            MapKind::OpenAddressing => open::find(table, key),
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(self.prefixes.as_slice())
            + size_of_val(self.tables.as_slice())
            + self.slots() * size_of::<u64>()
            + self.blocks.as_ref().map_or(0, Blocks::bytes)
    }

    /// Places for keys, taken or not.
    pub fn slots(&self) -> usize {
        self.tables.iter().map(|table| table.slots.len()).sum()
    }

    /// Share of the slots that are taken; 0 where there are none.
    pub fn load(&self) -> f64 {
        self.keys as f64 / self.slots().max(1) as f64
    }

    /// How often building a table began anew, summed over its tables.
    pub fn rebuilds(&self) -> u32 {
        self.tables.iter().map(|table| table.rebuilds).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    const KINDS: [MapKind; 4] = [
        MapKind::Blocks,
        MapKind::Cuckoo,
        MapKind::CuckooThree,
        MapKind::OpenAddressing,
    ];

    /// Sorted distinct random keys below 2^`bits`.
    fn random_keys(count: usize, bits: u32) -> Vec<u64> {
        let mut rng = Rng::new(11, u64::from(bits), 0, 0);
        let mut keys: Vec<u64> = (0..count).map(|_| rng.next_u64() >> (64 - bits)).collect();
        keys.sort_unstable();
        keys.dedup();
        keys
    }

    fn check(keys: &[u64], kind: MapKind, bits: u32) -> CellMap {
        let map = CellMap::build(keys, kind);
        for (rank, &key) in keys.iter().enumerate() {
            assert_eq!(map.find(key), Some(rank as u32), "{kind:?} {key}");
        }
        let mut rng = Rng::new(12, 0, 0, 0);
        for _ in 0..keys.len().max(100) {
            let key = rng.next_u64() >> (64 - bits);
            if keys.binary_search(&key).is_err() {
                assert_eq!(map.find(key), None, "{kind:?} {key}");
            }
        }
        map
    }

    #[test]
    fn every_key_is_found_and_no_other() {
        // 1024³, 4096³ (several tables), and so many cells that tables are searched.
        for bits in [30, 36, 60] {
            let count = if bits == 60 { 50_000 } else { 1_000_000 };
            let keys = random_keys(count, bits);
            for kind in KINDS {
                let map = check(&keys, kind, bits);
                let most = if kind == MapKind::OpenAddressing {
                    0.7
                } else {
                    1.0 / 1.1
                };
                if bits < 60 && kind != MapKind::Blocks {
                    assert!(map.load() <= most && map.load() > 0.5, "{}", map.load());
                }
                assert!(map.bytes() >= 8 * map.slots());
            }
        }
    }

    #[test]
    fn four_functions_fill_the_papers_table_at_the_first_try() {
        let keys = random_keys(300_000, 30);
        let map = CellMap::build(&keys, MapKind::Cuckoo);
        assert_eq!(map.rebuilds(), 0);
        assert_eq!(map.slots(), (keys.len() as f64 * 1.1).ceil() as usize);
    }

    #[test]
    fn tables_are_the_same_every_time() {
        let keys = random_keys(100_000, 32);
        for kind in KINDS {
            let [a, b] = [0; 2].map(|_| CellMap::build(&keys, kind));
            // Four times 1024³ cells, or so many blocks and more.
            assert_eq!(a.tables.len(), if kind == MapKind::Blocks { 1 } else { 4 });
            for (a, b) in a.tables.iter().zip(&b.tables) {
                assert_eq!(a.slots, b.slots, "{kind:?}");
            }
        }
    }

    #[test]
    fn few_keys_and_none() {
        for kind in KINDS {
            assert_eq!(CellMap::build(&[], kind).find(0), None);
            assert_eq!(CellMap::build(&[], kind).load(), 0.0);
            for count in 1..60 {
                let keys: Vec<u64> = (0..count).map(|i| i * i * 7).collect();
                check(&keys, kind, 30);
            }
            check(&[u64::MAX >> 4], kind, 60);
            check(&[(1 << 30) - 1, 1 << 30], kind, 36);
        }
    }

    #[test]
    fn surfaces_take_a_sixth_of_the_room_in_blocks() {
        // A sloping plane of 256² and more cells.
        let mut keys: Vec<u64> = (0..1u32 << 16)
            .flat_map(|place| {
                let [x, y] = [place & 255, place >> 8];
                let z = (x + 2 * y) / 4;
                [z, z + 1].map(|z| morton([x, y, z]))
            })
            .collect();
        keys.sort_unstable();
        let [blocks, cuckoo] =
            [MapKind::Blocks, MapKind::Cuckoo].map(|kind| check(&keys, kind, 24).bytes());
        assert!(6 * blocks < cuckoo, "{blocks} {cuckoo}");
    }

    /// Bits of three coordinates in turn.
    fn morton(coordinates: [u32; 3]) -> u64 {
        let bit = |i: usize| u64::from(coordinates[i % 3] >> (i / 3) & 1) << i;
        (0..24).map(bit).sum()
    }

    #[test]
    fn repeated_keys_keep_their_first_rank() {
        for kind in &KINDS[1..] {
            let kind = *kind;
            let map = CellMap::build(&[3, 3, 5, 5, 5, 9], kind);
            assert_eq!(
                [3, 5, 9, 4].map(|key| map.find(key)),
                [Some(0), Some(2), Some(5), None]
            );
        }
    }
}
