//! The memory of the wide tree: nodes of as many boxes and blocks of as many triangles as a register
//! has lanes, both as structures of arrays, so that one instruction sees all of them. They lie in one
//! array of cache lines, in the order of visits.

use super::lanes::Floats;

/// Marks a child as a leaf; the other bits are the first line of its [`Block`].
pub const LEAF: u32 = 1 << 31;

/// A cache line of sixteen numbers, floats by their bits.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Line(pub [u32; Self::NUMBERS]);

impl Line {
    pub const NUMBERS: usize = 16;
    pub const ZERO: Self = Self([0; Self::NUMBERS]);
}

/// The row of a node's children, in rows of a number a lane.
pub const CHILDREN_ROW: usize = 6;
/// The row of a block's indices, in rows of a number a lane.
pub const IDS_ROW: usize = 9;

/// A node. An empty slot has an inverted box that no ray enters, and names line 0.
#[repr(C, align(64))]
pub struct Node<F: Floats> {
    /// Rows min x, max x, min y, max y, min z, max z: the near plane of axis `a` is row `2a` for a
    /// ray with positive direction and row `2a + 1` otherwise; the far plane is the other one.
    pub planes: [F::Row; 6],
    /// First line of a node, or of a block with [`LEAF`] set. Slots are in the order of any-hit visits.
    pub children: F::Ids,
}

impl<F: Floats> Node<F> {
    /// Cache lines of a node.
    pub const LINES: usize = size_of::<Self>() / size_of::<Line>();
}

/// A leaf. Unused lanes are zero and therefore never hit.
#[repr(C, align(64))]
pub struct Block<F: Floats> {
    /// For x, y and z: the first vertex `v0`, `e1 = v0 − v1` and `e2 = v2 − v0`; in a watertight tree
    /// the three vertices, because edges round them.
    pub rows: [[F::Row; 3]; 3],
    /// Index into the caller's triangles.
    pub id: F::Ids,
}

impl<F: Floats> Block<F> {
    /// Cache lines of a block.
    pub const LINES: usize = size_of::<Self>() / size_of::<Line>();
}

/// The tree. The root is the node at line 0. Every child of a slot that is not empty is the first line
/// of a whole node or block; the kernels rely on it, and [`super::collapse`] alone makes trees.
/// `TIGHT` says which triangle test its blocks are for.
pub struct WideTree<F: Floats, const TIGHT: bool> {
    pub(super) present: F::Present,
    pub(super) lines: Vec<Line>,
    /// Entries a traversal stack can ever hold.
    pub(super) stack_entries: usize,
}
