//! Cells by blocks of 4³: a table leads to the block, whose bits say which of its cells there are.
//!
//! Cells of a block are neighbours in Morton order, so that the rank of a cell is that of the block's first cell and the
//! number of bits below its own. On surfaces a block has some 16 cells, which share one slot and 12 bytes: a third of the room
//! of the paper's slots, with the key, so that a foreign cell is still told from its own.

use crate::memory::room_for;

/// Bits of a key that name a cell within its block.
const BITS: u32 = 6;

/// The cells of all blocks, block by block.
pub(super) struct Blocks {
    /// Bit `i` is set where the block has the cell whose lower bits are `i`.
    cells: Vec<u64>,
    /// Rank of the first cell of each block.
    first: Vec<u32>,
}

impl Blocks {
    /// Of sorted keys, and the keys of the blocks.
    ///
    /// # Panics
    ///
    /// If keys are repeated or not sorted.
    pub fn of(keys: &[u64]) -> (Self, Vec<u64>) {
        assert!(keys.is_sorted_by(|a, b| a < b), "sorted, and each once");
        let blocks = || keys.chunk_by(|a, b| block_of(*a) == block_of(*b));
        let count = blocks().count();
        let (mut cells, mut first) = (room_for(count), room_for(count));
        let mut names = room_for(count);
        let mut rank = 0;
        for block in blocks() {
            names.push(block_of(block[0]));
            cells.push(block.iter().fold(0, |bits, key| bits | bit(*key)));
            first.push(rank);
            rank += block.len() as u32;
        }
        (Self { cells, first }, names)
    }

    /// Rank of a key, if its block, the one of this rank, has it.
    #[inline]
    pub fn find(&self, block: u32, key: u64) -> Option<u32> {
        let (cells, bit) = (self.cells[block as usize], bit(key));
        (cells & bit != 0).then(|| self.first[block as usize] + (cells & (bit - 1)).count_ones())
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice()) + size_of_val(self.first.as_slice())
    }
}

/// Key of the block that has a cell.
#[inline]
pub(super) fn block_of(key: u64) -> u64 {
    key >> BITS
}

/// The bit of a cell in its block.
#[inline]
fn bit(key: u64) -> u64 {
    1 << (key & ((1 << BITS) - 1))
}
