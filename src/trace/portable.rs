//! obvhs' own compressed tree and traversal: the fallback for processors without AVX2 and FMA.
//!
//! obvhs skips boxes nearer than 10⁻⁴ units whatever the scene's size, so the scene is scaled by a
//! power of two (which rounds nothing) until that is below the resolution of its coordinates.

use std::ops::Range;

use glam::Vec3;
use obvhs::bvh2::Bvh2;
use obvhs::cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh};
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;

use super::query::{RayTree, Scratch};
use super::soup::Soup;
use super::tracer::{MEDIUM, binary_tree};
use super::{Hit, Ray};

/// Levels of a compressed tree that obvhs' fixed stack holds.
const COMPRESSED_LEVELS: usize = 31;

/// obvhs' tree with its triangles in the order of its leaves.
pub struct PortableTree {
    tree: Either,
    indices: Vec<u32>,
    scale: f32,
    triangles: Vec<RtTriangle>,
}

enum Either {
    Compressed(CwBvh),
    /// For scenes so degenerate that the compressed tree is too deep for its stack, such as
    /// hundreds of copies of one triangle.
    Binary(Bvh2),
}

impl PortableTree {
    /// `soup` must have at least one triangle.
    pub fn new(soup: &Soup) -> Self {
        let scale = power_of_two_scale(&soup.corners);
        let scaled = |t: &Triangle| Triangle {
            v0: t.v0 * scale,
            v1: t.v1 * scale,
            v2: t.v2 * scale,
        };
        let corners: Vec<Triangle> = soup.corners.iter().map(scaled).collect();
        let mut binary = binary_tree(&corners, MEDIUM);
        let compressed = bvh2_to_cwbvh(&binary, 3, true, false);
        let (tree, indices) = if compressed_levels(&compressed) <= COMPRESSED_LEVELS {
            let indices = compressed.primitive_indices.clone();
            (Either::Compressed(compressed), indices)
        } else {
            binary.max_depth = binary_levels(&binary) + 1;
            let indices = binary.primitive_indices.clone();
            (Either::Binary(binary), indices)
        };
        let ordered = |&i: &u32| RtTriangle::from(&corners[i as usize]);
        Self {
            tree,
            triangles: indices.iter().map(ordered).collect(),
            indices: indices.into_iter().map(|i| soup.index(i)).collect(),
            scale,
        }
    }

    /// obvhs takes −0 for a negative direction in one place and for a positive one in another, so
    /// it gets +0.
    fn convert(&self, ray: &Ray) -> ObvhsRay {
        ObvhsRay::new(
            (ray.origin * self.scale).into(),
            (ray.direction + Vec3::ZERO).into(),
            ray.t_min.max(0.0) * self.scale,
            ray.t_max * self.scale,
        )
    }

    /// obvhs counts hits at `t_min`; this project does not.
    fn intersect(&self, ray: &ObvhsRay, id: usize) -> f32 {
        let t = self.triangles[id].intersect(ray);
        if t > ray.tmin { t } else { f32::INFINITY }
    }
}

impl RayTree for PortableTree {
    fn bytes(&self) -> usize {
        let nodes = match &self.tree {
            Either::Compressed(tree) => size_of_val(tree.nodes.as_slice()),
            Either::Binary(tree) => size_of_val(tree.nodes.as_slice()),
        };
        nodes + size_of_val(self.indices.as_slice()) + size_of_val(self.triangles.as_slice())
    }

    fn scratch(&self) -> Scratch {
        Scratch::default()
    }

    fn closest(&self, ray: &Ray, _: &mut Scratch) -> Option<Hit> {
        let ray = self.convert(ray);
        let mut found = RayHit::none();
        let test = |ray: &ObvhsRay, id| self.intersect(ray, id);
        match &self.tree {
            Either::Compressed(tree) => tree.ray_traverse(ray, &mut found, test),
            Either::Binary(tree) => tree.ray_traverse(ray, &mut found, test),
        };
        let slot = found.primitive_id as usize;
        // The slot of a miss is out of range.
        let weights = barycentric(self.triangles.get(slot)?, &ray);
        Some(Hit {
            t: found.t / self.scale,
            u: weights[0],
            v: weights[1],
            triangle: self.indices[slot],
        })
    }

    fn occluded(&self, ray: &Ray, _: &mut Scratch) -> bool {
        let test = |ray: &ObvhsRay, id| self.intersect(ray, id);
        !match &self.tree {
            Either::Compressed(tree) => tree.ray_traverse_miss(self.convert(ray), test),
            Either::Binary(tree) => tree.ray_traverse_miss(self.convert(ray), test),
        }
    }
}

fn compressed_levels(tree: &CwBvh) -> usize {
    let children = |index: usize| {
        let node = &tree.nodes[index];
        let first = node.child_base_idx as usize;
        first..first + node.imask.count_ones() as usize
    };
    levels(children)
}

fn binary_levels(tree: &Bvh2) -> usize {
    levels(|index| {
        let node = &tree.nodes[index];
        let first = node.first_index as usize;
        if node.is_leaf() {
            0..0
        } else {
            first..first + 2
        }
    })
}

/// Levels of a tree below node 0.
fn levels(children: impl Fn(usize) -> Range<usize>) -> usize {
    let mut open = vec![(0, 1)];
    let mut deepest = 0;
    while let Some((index, level)) = open.pop() {
        deepest = deepest.max(level);
        open.extend(children(index).map(|child| (child, level + 1)));
    }
    deepest
}

/// Brings the largest coordinate to 2048…4096 units.
fn power_of_two_scale(corners: &[Triangle]) -> f32 {
    let largest = corners
        .iter()
        .flat_map(|t| [t.v0, t.v1, t.v2])
        .fold(0.0f32, |largest, v| largest.max(v.abs().max_element()));
    if largest == 0.0 {
        return 1.0;
    }
    2f32.powi((4096.0 / largest).log2().floor().clamp(-100.0, 100.0) as i32)
}

/// Weights of the second and third vertex at the ray's intersection with the triangle's plane.
fn barycentric(triangle: &RtTriangle, ray: &ObvhsRay) -> [f32; 2] {
    let c = triangle.v0 - ray.origin;
    let r = ray.direction.cross(c);
    let inverse = 1.0 / triangle.ng.dot(ray.direction);
    [r.dot(triangle.e2) * inverse, r.dot(triangle.e1) * inverse]
}
