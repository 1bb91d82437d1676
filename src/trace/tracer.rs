//! The tree behind the project's interface.

use std::sync::Arc;
use std::time::Duration;

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ploc::PlocSearchDistance;
use obvhs::triangle::Triangle;

use super::pair::Pair;
use super::portable::PortableTree;
use super::query::RayTree;
use super::soup::Soup;
use super::{Caster, Kernel, RayCounter};

/// A ray-tracing structure over triangles, of which some may move; share it between threads by
/// reference.
pub struct Tracer {
    /// `None` for a scene without triangles.
    pub(super) tree: Option<Box<dyn RayTree>>,
    kernel: Kernel,
    /// `None` where all triangles stand still.
    moving: Option<Moving>,
}

/// What it takes to follow the triangles that move.
struct Moving {
    /// The tree of the others, if there are any.
    still: Option<Arc<dyn RayTree>>,
    /// Vertex indices and the caller's index of each that moves.
    triangles: Vec<[u32; 3]>,
    indices: Vec<u32>,
}

impl Tracer {
    /// Builds the tree for [`Kernel::best`]. Triangles must be finite; degenerate ones are never
    /// hit.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        Self::with_kernel(positions, triangles, Kernel::best())
    }

    /// Builds the tree for a kernel, or for [`Kernel::Portable`] where that one is unavailable.
    pub fn with_kernel(positions: &[Vec3], triangles: &[[u32; 3]], kernel: Kernel) -> Self {
        let kernel = answering(kernel);
        Self {
            tree: tree(&Soup::new(positions, triangles, &[]), kernel),
            kernel,
            moving: None,
        }
    }

    /// As [`Tracer::new`], with a flag a triangle that says whether it can move: see
    /// [`Tracer::moved`]. Hits are those of a tracer over all triangles in their places.
    ///
    /// # Panics
    /// If there are fewer flags than triangles.
    pub fn with_moving(positions: &[Vec3], triangles: &[[u32; 3]], moving: &[bool]) -> Self {
        Self::with_moving_for(Kernel::best(), positions, triangles, moving)
    }

    pub(super) fn with_moving_for(
        kernel: Kernel,
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        moving: &[bool],
    ) -> Self {
        let kernel = answering(kernel);
        let (moved, kept): (Vec<u32>, Vec<u32>) =
            (0..triangles.len() as u32).partition(|&i| moving[i as usize]);
        if moved.is_empty() {
            return Self::with_kernel(positions, triangles, kernel);
        }
        let of = |indices: &[u32]| -> Vec<[u32; 3]> {
            indices.iter().map(|&i| triangles[i as usize]).collect()
        };
        let still = tree(&Soup::new(positions, &of(&kept), &kept), kernel);
        let mut tracer = Self {
            tree: None,
            kernel,
            moving: Some(Moving {
                still: still.map(Arc::from),
                triangles: of(&moved),
                indices: moved,
            }),
        };
        tracer.moved(positions);
        tracer
    }

    /// Follows the triangles that can move to new positions, at the cost of building their tree only.
    /// `positions` are those of all vertices; only vertices of triangles that can move are read.
    pub fn moved(&mut self, positions: &[Vec3]) {
        let Some(moving) = &self.moving else {
            return;
        };
        let soup = Soup::new(positions, &moving.triangles, &moving.indices);
        self.tree = match (&moving.still, tree(&soup, self.kernel)) {
            (Some(still), Some(moving)) => {
                let still = still.clone();
                Some(Box::new(Pair { still, moving }))
            }
            (_, alone) => alone,
        };
    }

    /// The kernel that answers, for provenance: results of different kernels may differ in the
    /// last bit.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Bytes held by the tree and its triangles.
    pub fn bytes(&self) -> usize {
        self.tree.as_ref().map_or(0, |tree| tree.bytes())
    }

    /// A handle for one thread that counts into `counter` when it is dropped. Make one per task,
    /// not one per ray: it owns the traversal stacks.
    pub fn caster<'a>(&'a self, counter: &'a RayCounter) -> Caster<'a> {
        Caster::new(self, counter)
    }
}

/// The kernel itself, or the portable one where this processor cannot run it.
fn answering(kernel: Kernel) -> Kernel {
    match kernel.is_available() {
        true => kernel,
        false => Kernel::Portable,
    }
}

/// The tree of some triangles; `None` where there are none.
fn tree(soup: &Soup, kernel: Kernel) -> Option<Box<dyn RayTree>> {
    if soup.corners.is_empty() {
        return None;
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(tree) = super::entry::tree(soup, kernel) {
        return Some(tree);
    }
    Some(Box::new(PortableTree::new(soup)))
}

/// obvhs' parameters for trees with one triangle a leaf: its `medium_build`.
pub(super) const MEDIUM: BvhBuildParams = BvhBuildParams {
    max_prims_per_leaf: 1,
    post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
    ..BvhBuildParams::medium_build()
};

/// Three times as many nodes that obvhs tries to reinsert and a wider search for pairs: rays are 5–10 %
/// faster and the tree 6 % smaller for half as much again of build time.
#[cfg(target_arch = "x86_64")]
pub(super) const THOROUGH: BvhBuildParams = BvhBuildParams {
    reinsertion_batch_ratio: 0.15,
    ploc_search_distance: PlocSearchDistance::High,
    search_depth_threshold: 2,
    ..MEDIUM
};

/// obvhs' binary tree.
pub(super) fn binary_tree(corners: &[Triangle], parameters: BvhBuildParams) -> Bvh2 {
    build_bvh2_from_tris(corners, parameters, &mut Duration::default())
}
