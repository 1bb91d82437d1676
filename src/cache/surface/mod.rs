//! A cache on surfaces: texels of charts, mapped block by block where viewers look (Weinrauch et al. 2023, "Effect-based
//! multi-viewer caching", as Stadlbauer et al. 2024 use it).
//!
//! [`Charts`] split each mesh into islands of connected triangles that lie flat in a plane of their own (`islands`); copies of a
//! mesh share its charts (`copies`). A [`Grid`]
//! divides charts into texels of sixteen sizes, and those into blocks of 8 × 8; a [`BlockKey`] names a block of one
//! side of an island at one level. [`Blocks`] holds those that somebody asked for, with the surface point of
//! each texel (`lookup`) and as many words of contents as its user wants. Viewers ask with [`Requests`], which merge
//! into one, so that what several see is worked on once.
//!
//! Texels are places on triangles, not in space: what moves carries its texels along.

mod blocks;
mod charts;
mod copies;
mod grid;
mod islands;
mod lookup;
mod requests;

pub use blocks::{Asked, Block, BlockMemory, Blocks, Layout, Limits};
pub use charts::{ChartPlace, Charts};
pub use grid::{BLOCK_SIDE, BLOCK_TEXELS, BlockKey, Grid, LEVELS, Surface, Texel};
pub use islands::{MOST_TRIANGLES, STEEPEST_DEG};
pub use lookup::{SurfacePoint, surface_points};
pub use requests::Requests;
