//! Ray queries. The rest of the program sees [`Tracer`], [`Caster`], [`Ray`] and [`Hit`] only, and
//! never an instruction set: the kernels behind them are chosen at run time ([`Kernel`]).
//!
//! obvhs builds a binary tree, `binary` improves its lower levels, `collapse` makes it as wide as the registers
//! (`lanes`: sixteen with AVX-512, eight with AVX2), `single` traverses it with one ray, `bundle` with 64 rays of
//! one origin; both use the test of `triangle` and agree to the last bit, whatever the width. `entry` is where
//! they are compiled for an instruction set. `portable` is obvhs' own traversal for processors with neither.
//! Where some triangles move, `pair` asks two trees, of which one is built anew when they have moved.
//!
//! `unsafe` is a call of an instruction whose presence is proven, an unchecked index or the place of a node or
//! block in the tree (both checked all the same in builds with debug assertions, as those of the tests), vector
//! loads and stores, prefetches, and advice to the system (`crate::memory`). Checked besides with valgrind (interface and bundle tests, without a
//! finding), with AddressSanitizer (all tests of this module, without a finding:
//! `RUSTFLAGS=-Zsanitizer=address cargo +nightly test --lib --target x86_64-unknown-linux-gnu trace::`)
//! and, for the smaller closed meshes, with Miri, which knows these instructions:
//! `RUSTFLAGS=-Ctarget-feature=+avx2,+fma,+bmi1,+bmi2,+lzcnt,+popcnt cargo +nightly miri test --lib
//! trace::tests::watertight` with `MIRIFLAGS="-Zmiri-permissive-provenance -Zmiri-ignore-leaks
//! -Zmiri-tree-borrows -Zmiri-deterministic-floats"` (the last because obvhs asserts that powers
//! of two are exact).

mod caster;
mod counter;
mod kernel;
mod pair;
mod portable;
mod query;
mod soup;
mod tracer;

#[cfg(target_arch = "x86_64")]
mod binary;
#[cfg(target_arch = "x86_64")]
mod bundle;
#[cfg(target_arch = "x86_64")]
mod collapse;
#[cfg(target_arch = "x86_64")]
mod entry;
#[cfg(target_arch = "x86_64")]
mod lanes;
#[cfg(target_arch = "x86_64")]
mod single;
#[cfg(target_arch = "x86_64")]
mod tile;
#[cfg(target_arch = "x86_64")]
mod triangle;
#[cfg(target_arch = "x86_64")]
mod wide;

#[cfg(test)]
mod tests;

pub use crate::instructions::Instructions;
pub use crate::instructions::hidden_instructions;
pub use caster::Caster;
pub use counter::{RayCounter, RayCounts};
pub use kernel::Kernel;
pub use tracer::Tracer;

use glam::Vec3;

/// A ray in scene units. `direction` has unit length, so parameters are distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes.
    pub direction: Vec3,
    /// Hits count in `(t_min, t_max]`; a negative `t_min` counts as 0.
    pub t_min: f32,
    /// Farthest distance that counts; infinite for rays without an end.
    pub t_max: f32,
}

impl Ray {
    /// An unlimited ray.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self {
            origin,
            direction,
            t_min: 0.0,
            t_max: f32::INFINITY,
        }
    }
}

/// The closest intersection of a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Hit {
    /// Distance from the origin, scene units.
    pub t: f32,
    /// Barycentric weights of the second and third vertex.
    pub u: f32,
    /// See `u`.
    pub v: f32,
    /// Index into the triangles the tracer was built from.
    pub triangle: u32,
}

/// Moves a surface point off its surface, to the side of `direction_side` (a unit geometric normal),
/// by an amount that follows the rounding of its coordinates: 2⁻¹⁸ of their magnitude plus 10⁻⁷ of
/// the scene's diagonal.
pub fn offset_origin(point: Vec3, direction_side: Vec3, diagonal: f32) -> Vec3 {
    let magnitude = point.abs().max_element();
    point + direction_side * (magnitude * (1.0 / 262_144.0) + diagonal * 1e-7)
}
