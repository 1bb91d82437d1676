//! Cells in world space: the cache structure of HashCache (Roth et al. 2020, sections 3.1 and 3.2).
//!
//! A cube around the scene is halved `levels` times ([`Grid`]). The cells that triangles touch are found once
//! ([`occupied_cells`]), each level has a hash map from the Morton key of a cell to its number ([`CellMap`]), and an
//! array of what was learned: the mean light that arrives at either side of a cell ([`HashCells`]). A frame's samples are
//! sorted, reduced and merged into every level ([`HashCells::update`]).
//!
//! Where this differs from the paper:
//!
//! - Occupied cells are sorted lists of keys and bitmaps of 16³ cells, never a field of all cells.
//! - A slot of a map is a 32-bit key and a 32-bit index, 8 bytes; the paper's is one 32-bit word (its Table 1: 4.4 bytes a
//!   cell). With the key a foreign cell is a miss, and never a wrong colour. [`LevelSize`] has both sizes.
//! - [`MapKind::Blocks`] gives blocks of 4³ cells a slot, and a bit to each of their cells. Every kind of map finds the same.
//! - Each side of a cell has a count of its own.

mod blocks;
mod cell;
mod cuckoo;
mod foreseen;
mod grid;
mod levels;
mod map;
mod memory;
mod occupied;
mod open;
mod triangle;
mod update;

pub use cell::Precision;
pub use foreseen::bytes as foreseen_bytes;
pub use grid::{Grid, MOST_LEVELS};
pub use levels::{HashCells, LevelSize, Look, Options};
pub use map::{CellMap, MapKind};
pub use memory::LevelMemory;
pub use occupied::{coarser, occupied_cells};
pub use update::{Sample, Update};
