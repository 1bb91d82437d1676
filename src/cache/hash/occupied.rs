//! The cells that triangles touch.
//!
//! The paper tests all cells of each triangle's bounding box and marks them in a field of bits (section 3.1, figures 1 and 2),
//! which at 4096³ takes 8 GiB. Here each triangle descends to the blocks of 16³ cells that it touches, and each block
//! to its cells, which it marks in 4096 bits in Morton order: sorted keys follow without a sort. The cost is that of the
//! occupied cells, and blocks share it out among threads, so that two large triangles are no slower than many small ones.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::grid::{Grid, coordinates, finite_corners, morton};
use super::triangle::Triangle;

/// Halvings from a block to its cells.
const BLOCK_LEVELS: u32 = 4;

/// Words of bits of a block: one for each 4³ cells.
const WORDS: usize = 64;

/// Blocks whose keys are written together.
const TOGETHER: usize = 256;

/// Keys of the cells of the finest level that triangles touch, sorted and unique.
///
/// Cells a little away count as touched, because a hit point computed in `f32` may be off its triangle: up to a thousandth of a cell, or
/// four units in the last place of the scene's largest coordinate if that is more. Triangles with a vertex that is not
/// finite are left out; triangles without area count.
///
/// # Panics
///
/// If a triangle has a vertex that is not there.
pub fn occupied_cells(grid: &Grid, positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<u64> {
    let scene = Scene {
        grid,
        positions,
        triangles,
    };
    let pairs = scene.pairs();
    let starts: Vec<usize> = (0..pairs.len())
        .into_par_iter()
        .filter(|&i| i == 0 || pairs[i - 1].block != pairs[i].block)
        .collect();
    let mut blocks = Vec::new();
    (0..starts.len())
        .into_par_iter()
        .map(|i| {
            let end = starts.get(i + 1).copied().unwrap_or(pairs.len());
            scene.block(&pairs[starts[i]..end])
        })
        .collect_into_vec(&mut blocks);
    drop(pairs);
    keys_of(&blocks, scene.block_levels())
}

/// Keys of the cells one level up, sorted and unique, of sorted keys; linear time.
pub fn coarser(keys: &[u64]) -> Vec<u64> {
    let new = |i: &usize| *i == 0 || keys[*i - 1] >> 3 != keys[*i] >> 3;
    let mut parents = Vec::with_capacity((0..keys.len()).filter(new).count());
    parents.extend((0..keys.len()).filter(new).map(|i| keys[i] >> 3));
    parents
}

/// A triangle in a block.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Pair {
    /// Key of a cell of the level of blocks.
    block: u64,
    triangle: u32,
}

/// The occupied cells of a block.
struct Block {
    key: u64,
    /// One bit a cell, in Morton order.
    bits: [u64; WORDS],
}

/// A cube of 2^`log2` cells a side.
#[derive(Clone, Copy)]
struct Cube {
    corner: [u32; 3],
    log2: u32,
}

impl Cube {
    fn halves(self) -> impl Iterator<Item = Cube> {
        let log2 = self.log2 - 1;
        (0..8u32).map(move |half| Cube {
            corner: std::array::from_fn(|axis| self.corner[axis] + ((half >> axis & 1) << log2)),
            log2,
        })
    }

    fn is_touched(self, triangle: &Triangle, slack: f64) -> bool {
        let half = 0.5 * f64::from(1u32 << self.log2);
        let centre = DVec3::from_array(self.corner.map(f64::from)) + half;
        triangle.touches(centre, half + slack)
    }
}

/// The at most eight cubes of at least 2^`least` cells a side, as small as may be, that hold the cells from `low` to `high`.
fn covering(low: [u32; 3], high: [u32; 3], least: u32) -> impl Iterator<Item = Cube> {
    let fits = |log2: u32| (0..3).all(|axis| (high[axis] >> log2) - (low[axis] >> log2) <= 1);
    let log2 = (least..).find(|&log2| fits(log2)).expect("32 at most");
    let halves = (0..8u32).filter(move |half| {
        (0..3).all(|axis| half >> axis & 1 <= (high[axis] >> log2) - (low[axis] >> log2))
    });
    halves.map(move |half| Cube {
        corner: std::array::from_fn(|axis| ((low[axis] >> log2) + (half >> axis & 1)) << log2),
        log2,
    })
}

struct Scene<'a> {
    grid: &'a Grid,
    positions: &'a [Vec3],
    triangles: &'a [[u32; 3]],
}

impl Scene<'_> {
    fn triangle(&self, number: usize) -> Option<Triangle> {
        let corners = finite_corners(self.positions, &self.triangles[number])?;
        Some(Triangle::new(corners.map(|c| self.grid.in_cells(c))))
    }

    /// The cells from the first to the last that the bounding box touches; none if it lies outside.
    fn range(&self, triangle: &Triangle) -> Option<[[u32; 3]; 2]> {
        let side = f64::from(self.grid.side());
        let low = (triangle.low - self.grid.slack()).floor();
        let high = (triangle.high + self.grid.slack()).floor();
        let inside = high.min_element() >= 0.0 && low.max_element() < side;
        let clamped = |cell: DVec3| {
            cell.clamp(DVec3::ZERO, DVec3::splat(side - 1.0))
                .to_array()
                .map(|c| c as u32)
        };
        inside.then(|| [clamped(low), clamped(high)])
    }

    /// Halvings from a block to its cells in this grid.
    fn block_levels(&self) -> u32 {
        BLOCK_LEVELS.min(self.grid.levels())
    }

    /// The blocks of every triangle, sorted.
    fn pairs(&self) -> Vec<Pair> {
        let lists: Vec<Vec<Pair>> = (0..self.triangles.len())
            .into_par_iter()
            .with_min_len(1024)
            .fold(Vec::new, |mut pairs, number| {
                self.blocks_of(number, &mut pairs);
                pairs
            })
            .collect();
        let mut pairs = Vec::with_capacity(lists.iter().map(Vec::len).sum());
        for list in lists {
            pairs.extend(list);
        }
        pairs.par_sort_unstable();
        pairs
    }

    fn blocks_of(&self, number: usize, pairs: &mut Vec<Pair>) {
        let Some(triangle) = self.triangle(number) else {
            return;
        };
        let Some([low, high]) = self.range(&triangle) else {
            return;
        };
        let levels = self.block_levels();
        let mut open: Vec<Cube> = covering(low, high, levels).collect();
        while let Some(cube) = open.pop() {
            if !cube.is_touched(&triangle, self.grid.slack()) {
                continue;
            }
            if cube.log2 > levels {
                open.extend(cube.halves());
            } else {
                pairs.push(Pair {
                    block: morton(cube.corner) >> (3 * levels),
                    triangle: number as u32,
                });
            }
        }
    }

    /// The cells of a block that the triangles of its pairs touch.
    fn block(&self, pairs: &[Pair]) -> Block {
        let levels = self.block_levels();
        let mut block = Block {
            key: pairs[0].block,
            bits: [0; WORDS],
        };
        let first = coordinates(block.key).map(|c| c << levels);
        let last = first.map(|c| c + (1 << levels) - 1);
        for pair in pairs {
            let triangle = self.triangle(pair.triangle as usize).expect("finite");
            let [low, high] = self.range(&triangle).expect("it touches the block");
            let within = |cell: [u32; 3]| {
                std::array::from_fn(|axis| cell[axis].clamp(first[axis], last[axis]))
            };
            for cube in covering(within(low), within(high), 0) {
                block.mark(cube, &triangle, self.grid.slack());
            }
        }
        block
    }
}

impl Block {
    /// Marks the cells of a cube that the triangle touches.
    fn mark(&mut self, cube: Cube, triangle: &Triangle, slack: f64) {
        // Only the lowest bits say where it is in the block.
        let index = (morton(cube.corner) & 0xfff) as usize;
        let (word, bit) = (index / 64, index % 64);
        let full = match cube.log2 {
            0 => self.bits[word] >> bit & 1 == 1,
            1 => self.bits[word] >> bit & 0xff == 0xff,
            2 => self.bits[word] == u64::MAX,
            _ => false,
        };
        if full || !cube.is_touched(triangle, slack) {
            return;
        }
        if cube.log2 == 0 {
            self.bits[word] |= 1 << bit;
        } else {
            for half in cube.halves() {
                self.mark(half, triangle, slack);
            }
        }
    }

    fn count(&self) -> usize {
        self.bits
            .iter()
            .map(|word| word.count_ones() as usize)
            .sum()
    }

    /// Writes the keys of its cells in ascending order to the beginning of `keys`, and gives how many.
    fn write(&self, levels: u32, keys: &mut [u64]) -> usize {
        let mut written = 0;
        for (word, &bits) in self.bits.iter().enumerate() {
            let mut rest = bits;
            while rest != 0 {
                let index = 64 * word as u64 + u64::from(rest.trailing_zeros());
                keys[written] = self.key << (3 * levels) | index;
                written += 1;
                rest &= rest - 1;
            }
        }
        written
    }
}

/// The keys of the cells of sorted blocks.
fn keys_of(blocks: &[Block], levels: u32) -> Vec<u64> {
    let groups: Vec<&[Block]> = blocks.chunks(TOGETHER).collect();
    let counts: Vec<usize> = groups
        .par_iter()
        .map(|group| group.iter().map(Block::count).sum())
        .collect();
    let mut keys = vec![0; counts.iter().sum()];
    let mut rest = keys.as_mut_slice();
    let mut parts = Vec::with_capacity(groups.len());
    for (group, count) in groups.into_iter().zip(counts) {
        let part = rest.split_off_mut(..count).expect("counted");
        parts.push((group, part));
    }
    parts.into_par_iter().for_each(|(group, part)| {
        let mut written = 0;
        for block in group {
            written += block.write(levels, &mut part[written..]);
        }
    });
    keys
}

#[cfg(test)]
#[path = "occupied_tests.rs"]
mod tests;
