//! The tree behind the project's interface.

use std::time::Duration;

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ploc::PlocSearchDistance;
use obvhs::triangle::Triangle;

use super::portable::PortableTree;
use super::query::RayTree;
use super::{Caster, Kernel, RayCounter};

/// An immutable ray-tracing structure over triangles; share it between threads by reference.
pub struct Tracer {
    /// `None` for a scene without triangles.
    pub(super) tree: Option<Box<dyn RayTree>>,
    kernel: Kernel,
}

impl Tracer {
    /// Builds the tree for [`Kernel::best`]. Triangles must be finite; degenerate ones are never
    /// hit.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        Self::with_kernel(positions, triangles, Kernel::best())
    }

    /// Builds the tree for a kernel, or for [`Kernel::Portable`] where that one is unavailable.
    pub fn with_kernel(positions: &[Vec3], triangles: &[[u32; 3]], kernel: Kernel) -> Self {
        let corners: Vec<Triangle> = triangles
            .iter()
            .map(|t| {
                let [v0, v1, v2] = t.map(|i| positions[i as usize].into());
                Triangle { v0, v1, v2 }
            })
            .collect();
        let kernel = if kernel.is_available() {
            kernel
        } else {
            Kernel::Portable
        };
        Self {
            tree: (!corners.is_empty()).then(|| tree(&corners, kernel)),
            kernel,
        }
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

fn tree(corners: &[Triangle], kernel: Kernel) -> Box<dyn RayTree> {
    #[cfg(target_arch = "x86_64")]
    if let Some(tree) = super::entry::tree(corners, kernel) {
        return tree;
    }
    Box::new(PortableTree::new(corners))
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
