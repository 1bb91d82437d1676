//! Texels and blocks of charts, of several sizes.

use glam::Vec2;
use serde::{Deserialize, Serialize};

/// Sizes of texels, each twice the one before.
pub const LEVELS: u32 = 16;
/// Texels along a side of a block.
pub const BLOCK_SIDE: u32 = 8;
/// Texels of a block.
pub const BLOCK_TEXELS: usize = (BLOCK_SIDE * BLOCK_SIDE) as usize;
/// Bits of a coordinate of a block.
const COORDINATE_BITS: u32 = 12;
/// Bits of a level.
const LEVEL_BITS: u32 = 4;

/// One side of an island.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Surface {
    /// Index into the islands of the charts.
    pub island: u32,
    /// The side from which its triangles are clockwise.
    pub back: bool,
}

/// A block of texels, in 60 bits: twice the island (and one for its back) 32, level 4, column and row 12 each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct BlockKey(u64);

/// A texel: its block, and its place therein, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texel {
    /// The square of texels that holds it.
    pub block: BlockKey,
    /// Below [`BLOCK_TEXELS`].
    pub index: u32,
}

impl BlockKey {
    fn new(surface: Surface, level: u32, [column, row]: [u32; 2]) -> Self {
        let side = u64::from(surface.island) << 1 | u64::from(surface.back);
        let place = u64::from(column) << COORDINATE_BITS | u64::from(row);
        Self((side << LEVEL_BITS | u64::from(level)) << (2 * COORDINATE_BITS) | place)
    }

    /// The side of the island that it lies on.
    pub fn surface(self) -> Surface {
        let side = self.0 >> (2 * COORDINATE_BITS + LEVEL_BITS);
        Surface {
            island: (side >> 1) as u32,
            back: side & 1 == 1,
        }
    }

    /// 0 has the finest texels.
    pub fn level(self) -> u32 {
        (self.0 >> (2 * COORDINATE_BITS)) as u32 & (LEVELS - 1)
    }

    /// Column and row of the block.
    pub fn place(self) -> [u32; 2] {
        let mask = (1 << COORDINATE_BITS) - 1;
        [self.0 >> COORDINATE_BITS, self.0].map(|place| place as u32 & mask)
    }

    /// A number that blocks of the same side of an island and level share, and no others.
    pub fn sheet(self) -> u64 {
        self.0 >> (2 * COORDINATE_BITS)
    }

    /// For hashing and random numbers.
    pub fn bits(self) -> u64 {
        self.0
    }
}

impl Texel {
    /// Column and row among all texels of its level.
    pub fn position(self) -> [u32; 2] {
        let [column, row] = self.block.place();
        [
            column * BLOCK_SIDE + self.index % BLOCK_SIDE,
            row * BLOCK_SIDE + self.index / BLOCK_SIDE,
        ]
    }
}

/// Sizes of texels in charts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Side of a texel of level 0, scene units.
    pub finest: f32,
}

impl Grid {
    /// Side of a texel, scene units.
    pub fn side(&self, level: u32) -> f32 {
        self.finest * (1u64 << level) as f32
    }

    /// The level whose texels have a size (scene units), between two levels as well.
    pub fn level(&self, size: f32) -> f32 {
        (size / self.finest).log2()
    }

    /// The nearest level that a chart of this extent can have: an island has at most 32,768 texels along a side.
    pub fn within(&self, level: f32, extent: Vec2) -> f32 {
        let most = ((1 << COORDINATE_BITS) * BLOCK_SIDE - 3) as f32;
        let texels = extent.max_element() / (self.finest * most);
        let least = texels.max(1.0).log2().ceil();
        level.max(least).clamp(0.0, (LEVELS - 1) as f32)
    }

    /// Where a place of a chart (scene units) lies among the texels of a level: whole numbers are their corners, and the
    /// chart begins at 1, so that each place has neighbours.
    pub fn among_texels(&self, place: Vec2, level: u32) -> Vec2 {
        place / self.side(level) + 1.0
    }

    /// The texel of a level whose column and row these are.
    pub fn texel(&self, surface: Surface, level: u32, at: [u32; 2]) -> Texel {
        let [column, row] = at.map(|i| i % BLOCK_SIDE);
        Texel {
            block: BlockKey::new(surface, level, at.map(|i| i / BLOCK_SIDE)),
            index: row * BLOCK_SIDE + column,
        }
    }

    /// Where the centre of a texel lies in the chart, scene units.
    pub fn centre(&self, texel: Texel) -> Vec2 {
        let at = Vec2::from(texel.position().map(|i| i as f32)) - 0.5;
        at * self.side(texel.block.level())
    }

    /// The texel that a place of a chart lies in.
    pub fn nearest(&self, surface: Surface, place: Vec2, level: u32) -> Texel {
        let at = self.among_texels(place, level).max(Vec2::ZERO);
        self.texel(surface, level, at.to_array().map(|x| x as u32))
    }

    /// The four texels around a place, with the weights of bilinear interpolation.
    pub fn around(&self, surface: Surface, place: Vec2, level: u32) -> [(Texel, f32); 4] {
        let at = (self.among_texels(place, level) - 0.5).max(Vec2::ZERO);
        let corner = at.floor();
        let part = at - corner;
        let [column, row] = corner.to_array().map(|x| x as u32);
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]: [u32; 2]| {
            let weight = |part: f32, far: u32| if far == 1 { part } else { 1.0 - part };
            let texel = self.texel(surface, level, [column + right, row + down]);
            (texel, weight(part.x, right) * weight(part.y, down))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid { finest: 0.5 };
    const SURFACE: Surface = Surface {
        island: 1_234_567,
        back: true,
    };

    #[test]
    fn keys_hold_what_they_are_made_of() {
        let island = (1 << 31) - 1;
        for surface in [
            SURFACE,
            Surface {
                island,
                back: false,
            },
        ] {
            let key = BlockKey::new(surface, 15, [4095, 17]);
            assert_eq!(key.surface(), surface);
            assert_eq!((key.level(), key.place()), (15, [4095, 17]));
            assert!(key.bits() < 1 << 60);
        }
    }

    #[test]
    fn a_texel_is_the_nearest_to_its_centre_at_every_level() {
        for level in 0..LEVELS {
            for place in [Vec2::ZERO, Vec2::new(3.2, 40.0), Vec2::new(100.0, 0.01)] {
                let texel = GRID.nearest(SURFACE, place, level);
                let centre = GRID.centre(texel);
                assert_eq!(GRID.nearest(SURFACE, centre, level), texel);
                let off = (centre - place).abs().max_element();
                assert!(off <= 0.5001 * GRID.side(level), "{off}");
            }
        }
    }

    #[test]
    fn weights_of_neighbours_give_the_place_back() {
        for place in [Vec2::ZERO, Vec2::new(3.2, 40.0), Vec2::new(7.99, 8.01)] {
            let around = GRID.around(SURFACE, place, 2);
            let sum: f32 = around.iter().map(|(_, weight)| weight).sum();
            let mean =
                |mean: Vec2, (texel, weight): &(Texel, f32)| mean + *weight * GRID.centre(*texel);
            let mean = around.iter().fold(Vec2::ZERO, mean);
            assert!((sum - 1.0).abs() < 1e-6);
            assert!((mean - place).length() < 1e-4, "{mean} {place}");
        }
    }

    #[test]
    fn levels_follow_size_and_keep_charts_addressable() {
        let small = Vec2::splat(10.0);
        assert_eq!([0.5, 4.0].map(|size| GRID.level(size)), [0.0, 3.0]);
        assert!((GRID.level(3.1) - 2.63).abs() < 0.01);
        let within = |size| GRID.within(GRID.level(size), small);
        assert_eq!(
            [0.01, 1e9, 0.0, f32::NAN].map(within),
            [0.0, 15.0, 0.0, 0.0]
        );
        let large = Vec2::new(1.0, 20_000.0);
        assert_eq!(GRID.within(0.0, large), 1.0);
        let last = GRID.nearest(SURFACE, large, 1).block.place();
        assert!(last[1] < 4096);
    }
}
