//! The memory of the eight-wide tree: nodes of eight boxes and leaves of eight triangles, both as
//! structures of arrays, so that one vector instruction sees all eight. They lie in one array of
//! cache lines, in the order of visits.

use super::query::{Bundle, RayTree, Scratch, Waiting};
use super::{Hit, Ray, bundle, single};

/// Marks a child as a leaf; the other bits are the first line of its [`Block`].
pub const LEAF: u32 = 1 << 31;

/// A cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Line(pub [u32; 16]);

/// Eight children. An empty slot has an inverted box that no ray enters.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Node {
    /// Rows min x, max x, min y, max y, min z, max z: the near plane of axis `a` is row `2a` for a
    /// ray with positive direction and row `2a + 1` otherwise; the far plane is the other one.
    pub planes: [[f32; 8]; 6],
    /// First line of a node, or of a block with [`LEAF`] set. Slots are in the order of any-hit visits.
    pub children: [u32; 8],
    /// Makes it four whole lines.
    pub unused: [u32; 8],
}

impl Node {
    pub const EMPTY: Self = Self {
        planes: [
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
            [f32::INFINITY; 8],
            [f32::NEG_INFINITY; 8],
        ],
        children: [LEAF; 8],
        unused: [0; 8],
    };

    /// Cache lines of a node.
    pub const LINES: usize = 4;
    /// The line with the children, which are its first numbers.
    pub const CHILDREN: usize = 3;

    /// As it lies in the tree.
    pub fn lines(self) -> [Line; Self::LINES] {
        // SAFETY: both are 64 numbers of four bytes, without padding.
        unsafe { std::mem::transmute(self) }
    }
}

/// Up to eight triangles. Unused lanes are zero and therefore never hit.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Block {
    /// For x, y and z: the first vertex `v0`, `e1 = v0 − v1` and `e2 = v2 − v0`; in a watertight tree
    /// the three vertices, because edges round them.
    pub rows: [[[f32; 8]; 3]; 3],
    /// Index into the caller's triangles.
    pub id: [u32; 8],
}

impl Block {
    pub const EMPTY: Self = Self {
        rows: [[[0.0; 8]; 3]; 3],
        id: [u32::MAX; 8],
    };

    /// Cache lines of a block.
    pub const LINES: usize = 5;

    /// As it lies in the tree.
    pub fn lines(self) -> [Line; Self::LINES] {
        // SAFETY: both are 80 numbers of four bytes, without padding.
        unsafe { std::mem::transmute(self) }
    }
}

/// Proof that the processor has the instructions of the wide kernels.
#[derive(Clone, Copy, Debug)]
pub struct Features(());

impl Features {
    pub fn detect() -> Option<Self> {
        let present = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        present.then_some(Self(()))
    }
}

/// The tree. The root is the node at line 0. Every child of a slot that is not empty is the first line
/// of a whole node or block; the kernels rely on it, and [`super::collapse`] alone makes trees.
#[derive(Debug)]
pub struct WideTree {
    pub(super) _features: Features,
    /// Which triangle test its blocks are for.
    pub(super) is_watertight: bool,
    pub(super) lines: Vec<Line>,
    /// Entries a traversal stack can ever hold.
    pub(super) stack_entries: usize,
}

impl RayTree for WideTree {
    fn bytes(&self) -> usize {
        size_of_val(self.lines.as_slice())
    }

    fn scratch(&self) -> Scratch {
        Scratch {
            // A push writes eight entries, whatever it needs.
            children: vec![0; self.stack_entries + 8],
            sorted: vec![0; self.stack_entries],
            tiles: vec![Waiting::default(); self.stack_entries],
        }
    }

    fn closest(&self, ray: &Ray, scratch: &mut Scratch) -> Option<Hit> {
        // SAFETY: `_features` proves that the instructions exist.
        unsafe {
            if self.is_watertight {
                single::closest_ray::<true>(self, ray, &mut scratch.sorted)
            } else {
                single::closest_ray::<false>(self, ray, &mut scratch.sorted)
            }
        }
    }

    fn occluded(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
        // SAFETY: `_features` proves that the instructions exist.
        unsafe {
            if self.is_watertight {
                single::occluded_ray::<true>(self, ray, &mut scratch.children)
            } else {
                single::occluded_ray::<false>(self, ray, &mut scratch.children)
            }
        }
    }

    fn occluded_bundle(&self, bundle: &Bundle, scratch: &mut Scratch, occluded: &mut [u64]) {
        // SAFETY: `_features` proves that the instructions exist.
        unsafe {
            if self.is_watertight {
                bundle::occluded::<true>(self, bundle, scratch, occluded)
            } else {
                bundle::occluded::<false>(self, bundle, scratch, occluded)
            }
        }
    }

    fn closest_bundle(&self, bundle: &Bundle, scratch: &mut Scratch, hits: &mut [Option<Hit>]) {
        // SAFETY: `_features` proves that the instructions exist.
        unsafe {
            if self.is_watertight {
                bundle::closest::<true>(self, bundle, scratch, hits)
            } else {
                bundle::closest::<false>(self, bundle, scratch, hits)
            }
        }
    }
}
