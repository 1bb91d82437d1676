//! The cells of all levels, and what they hold.

use glam::Vec3;
use rayon::prelude::*;

use super::cell::{Cell, Precision, side_of, unpack_normal};
use super::foreseen;
use super::grid::{Grid, MOST_LEVELS};
use super::map::{CellMap, MapKind};
use super::occupied::{coarser, occupied_cells};

/// How the cells of a scene are made.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Number of the finest level, of 2^levels cells a side; at most [`MOST_LEVELS`].
    pub levels: u32,
    /// How occupied cells are found.
    pub map: MapKind,
    /// How sums of samples are stored.
    pub precision: Precision,
}

/// What a cell holds for one of its sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// There is no such cell: no surface passes there.
    Absent,
    /// The cell has no samples on this side.
    Empty,
    /// The cell has samples on this side.
    Found {
        /// Mean of the samples' values.
        value: Vec3,
        /// How many they were; [`Precision::Half`] counts to 65535.
        samples: u32,
    },
}

/// Size of a level.
#[derive(Clone, Copy, Debug)]
pub struct LevelSize {
    /// Its number: 2^level cells a side.
    pub level: u32,
    /// Occupied cells.
    pub cells: usize,
    /// Their share of all cells of the level.
    pub density: f64,
    /// Bytes of what the cells hold.
    pub bytes_data: usize,
    /// Bytes of the map.
    pub bytes_map: usize,
    /// Bytes of the paper's map: 1.1 slots a cell, of 4 bytes without key.
    pub bytes_map_paper: f64,
    /// How often building the map's tables began anew.
    pub rebuilds: u32,
    /// Share of the map's slots that are taken.
    pub load: f64,
}

/// The cells on the surfaces of a scene, on every level, and the mean light that arrived at either side of each.
pub struct HashCells {
    pub(super) grid: Grid,
    pub(super) precision: Precision,
    /// From the coarsest.
    pub(super) levels: Vec<Level>,
    /// How often everything was wiped: cells with another stamp are empty.
    pub(super) stamp: u32,
}

/// The cells of a level.
pub(super) struct Level {
    pub map: CellMap,
    pub cells: usize,
    /// All cells by rank. Zeros until a cell is written: memory that was never touched costs nothing.
    pub words: Vec<u32>,
}

impl HashCells {
    /// The cells that the triangles touch, without samples.
    ///
    /// # Errors
    ///
    /// A sentence if there are too many levels, or too many cells for indices of 32 bits.
    pub fn new(
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        options: Options,
    ) -> Result<Self, String> {
        let finest = options.levels;
        if finest > MOST_LEVELS {
            return Err(format!(
                "{finest} levels are more than the {MOST_LEVELS} that keys can tell apart"
            ));
        }
        let grid = Grid::around(positions, triangles, finest);
        let too_many = || {
            format!(
                "level {finest} of the scene has more than {} cells: take fewer levels",
                u32::MAX
            )
        };
        // Before any work, which then would take all memory.
        if foreseen::cells(&grid, positions, triangles) > 1.5 * f64::from(u32::MAX) {
            return Err(too_many());
        }
        let keys = occupied_cells(&grid, positions, triangles);
        if keys.len() > u32::MAX as usize {
            return Err(too_many());
        }
        let level = |keys: &Vec<u64>| Level {
            map: CellMap::build(keys, options.map),
            cells: keys.len(),
            words: Vec::new(),
        };
        let mut above = coarser(&keys);
        let last = level(&keys);
        // They take more room than those of all other levels.
        drop(keys);
        let mut others = Vec::new();
        for _ in 0..finest {
            let next = coarser(&above);
            others.push(std::mem::replace(&mut above, next));
        }
        let mut levels: Vec<Level> = others.par_iter().rev().map(level).collect();
        drop(others);
        levels.push(last);
        for level in &mut levels {
            level.words = vec![0; level.cells * options.precision.words()];
        }
        Ok(Self {
            grid,
            precision: options.precision,
            levels,
            stamp: 0,
        })
    }

    /// The cube and its cells.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// What a cell of a level holds for a surface point with this unit geometric normal, turned to the viewer.
    pub fn look(&self, level: u32, position: Vec3, normal: Vec3) -> Look {
        let Some(index) = self.find(level, position) else {
            return Look::Absent;
        };
        let cell = self.cell(level, index);
        let side = cell.sides[side_of(unpack_normal(cell.normal), normal)];
        if side.samples == 0 {
            return Look::Empty;
        }
        Look::Found {
            value: side.mean,
            samples: side.samples,
        }
    }

    /// What was stored before counts no longer. It costs nothing now: cells are emptied when they are next written, and read
    /// as empty until then (the wipe index of section 3.1).
    pub fn wipe(&mut self) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            // Old stamps would count again.
            for level in &mut self.levels {
                level.words.fill(0);
            }
        }
    }

    /// Sizes of the levels, from the coarsest.
    pub fn levels(&self) -> impl Iterator<Item = LevelSize> {
        self.levels
            .iter()
            .zip(0..)
            .map(|(level, number)| LevelSize {
                level: number,
                cells: level.cells,
                density: level.cells as f64 / 8f64.powi(number as i32),
                bytes_data: size_of_val(level.words.as_slice()),
                bytes_map: level.map.bytes(),
                bytes_map_paper: 4.4 * level.cells as f64,
                rebuilds: level.map.rebuilds(),
                load: level.map.load(),
            })
    }

    /// Bytes of all cells and maps.
    pub fn bytes(&self) -> usize {
        self.levels()
            .map(|level| level.bytes_data + level.bytes_map)
            .sum()
    }

    /// Rank of the cell of a level that holds a point.
    pub(super) fn find(&self, level: u32, position: Vec3) -> Option<u32> {
        let key = self.grid.key_at(level, position)?;
        self.levels[level as usize].map.find(key)
    }

    /// What a cell holds; what was wiped is empty.
    pub(super) fn cell(&self, level: u32, index: u32) -> Cell {
        let words = self.precision.words();
        let start = index as usize * words;
        let cell = self
            .precision
            .unpack(&self.levels[level as usize].words[start..start + words]);
        if cell.stamp == self.stamp {
            cell
        } else {
            Cell::default()
        }
    }
}

#[cfg(test)]
#[path = "levels_tests.rs"]
pub(super) mod tests;
