//! obvhs' compressed wide tree behind the project's interface.

use std::cell::Cell;
use std::time::Duration;

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::{Ray as ObvhsRay, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;

use super::{Hit, Ray, RayCounter, RayCounts};

/// An immutable ray-tracing structure over triangles; share it between threads by reference.
pub struct Tracer {
    /// `None` for a scene without triangles.
    tree: Option<CwBvh>,
    /// In the order of the tree's leaves.
    triangles: Vec<RtTriangle>,
}

impl Tracer {
    /// Builds the tree. Triangles must be finite; degenerate ones are never hit.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        if triangles.is_empty() {
            return Self {
                tree: None,
                triangles: Vec::new(),
            };
        }
        let corners: Vec<Triangle> = triangles
            .iter()
            .map(|t| {
                let [v0, v1, v2] = t.map(|i| positions[i as usize].into());
                Triangle { v0, v1, v2 }
            })
            .collect();
        let mut elapsed = Duration::ZERO;
        let tree = build_cwbvh_from_tris(&corners, BvhBuildParams::medium_build(), &mut elapsed);
        let ordered = tree
            .primitive_indices
            .iter()
            .map(|&i| RtTriangle::from(&corners[i as usize]))
            .collect();
        Self {
            tree: Some(tree),
            triangles: ordered,
        }
    }

    /// Bytes held by the tree and its triangles.
    pub fn bytes(&self) -> usize {
        let tree = self.tree.as_ref().map_or(0, |t| {
            std::mem::size_of_val(t.nodes.as_slice())
                + std::mem::size_of_val(t.primitive_indices.as_slice())
        });
        tree + std::mem::size_of_val(self.triangles.as_slice())
    }

    /// A handle for one thread that counts into `counter` when it is dropped.
    pub fn caster<'a>(&'a self, counter: &'a RayCounter) -> Caster<'a> {
        Caster {
            tracer: self,
            counter,
            closest: Cell::new(0),
            shadow: Cell::new(0),
        }
    }
}

/// Casts rays of one thread. Rays with non-finite members hit nothing.
pub struct Caster<'a> {
    tracer: &'a Tracer,
    counter: &'a RayCounter,
    closest: Cell<u64>,
    shadow: Cell<u64>,
}

impl Caster<'_> {
    /// The closest hit in `[t_min, t_max]`.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.closest.set(self.closest.get() + 1);
        let tree = self.tracer.tree.as_ref()?;
        let ray = convert(ray)?;
        let mut found = RayHit::none();
        tree.ray_traverse(ray, &mut found, |ray, id| {
            self.tracer.triangles[id].intersect(ray)
        });
        if found.t > ray.tmax || !found.t.is_finite() {
            return None;
        }
        let slot = found.primitive_id as usize;
        let weights = barycentric(&self.tracer.triangles[slot], &ray);
        Some(Hit {
            t: found.t,
            u: weights[0],
            v: weights[1],
            triangle: tree.primitive_indices[slot],
        })
    }

    /// Whether anything lies in `[t_min, t_max]`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.shadow.set(self.shadow.get() + 1);
        let (Some(tree), Some(ray)) = (self.tracer.tree.as_ref(), convert(ray)) else {
            return false;
        };
        !tree.ray_traverse_miss(ray, |ray, id| self.tracer.triangles[id].intersect(ray))
    }

    /// Occlusion of many rays of one origin: bit `i % 64` of `occluded[i / 64]` is set when
    /// direction `i` is blocked before `t_max`. `occluded` must hold `directions.len()` bits.
    pub fn occluded_bundle(
        &self,
        origin: Vec3,
        directions: &[Vec3],
        t_max: f32,
        occluded: &mut [u64],
    ) {
        occluded.fill(0);
        for (i, &direction) in directions.iter().enumerate() {
            let ray = Ray {
                t_max,
                ..Ray::new(origin, direction)
            };
            occluded[i / 64] |= u64::from(self.occluded(&ray)) << (i % 64);
        }
    }
}

impl Drop for Caster<'_> {
    fn drop(&mut self) {
        self.counter.add(RayCounts {
            closest: self.closest.get(),
            shadow: self.shadow.get(),
        });
    }
}

fn convert(ray: &Ray) -> Option<ObvhsRay> {
    if !ray.origin.is_finite() || !ray.direction.is_finite() || !(ray.t_max >= ray.t_min) {
        return None;
    }
    Some(ObvhsRay::new(
        ray.origin.into(),
        ray.direction.into(),
        ray.t_min,
        ray.t_max,
    ))
}

/// Weights of the second and third vertex at the ray's intersection with the triangle's plane.
fn barycentric(triangle: &RtTriangle, ray: &ObvhsRay) -> [f32; 2] {
    let c = triangle.v0 - ray.origin;
    let r = ray.direction.cross(c);
    let inverse = 1.0 / triangle.ng.dot(ray.direction);
    [r.dot(triangle.e2) * inverse, r.dot(triangle.e1) * inverse]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad() -> Tracer {
        let positions = [
            Vec3::new(-1.0, -1.0, 0.0),
            Vec3::new(1.0, -1.0, 0.0),
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::new(-1.0, 1.0, 0.0),
        ];
        Tracer::new(&positions, &[[0, 1, 2], [0, 2, 3]])
    }

    #[test]
    fn barycentric_weights_give_the_hit_point() {
        let tracer = quad();
        let counter = RayCounter::default();
        let origin = Vec3::new(0.3, -0.4, 2.0);
        let hit = tracer
            .caster(&counter)
            .closest(&Ray::new(origin, -Vec3::Z))
            .expect("hit");
        assert!((hit.t - 2.0).abs() < 1e-6);
        assert_eq!(hit.triangle, 0);
        let point = Vec3::new(-1.0, -1.0, 0.0)
            + hit.u * Vec3::new(2.0, 0.0, 0.0)
            + hit.v * Vec3::new(2.0, 2.0, 0.0);
        assert!(
            (point - Vec3::new(0.3, -0.4, 0.0)).length() < 1e-5,
            "{point}"
        );
    }

    #[test]
    fn limits_counts_and_hard_rays() {
        let tracer = quad();
        let counter = RayCounter::default();
        let caster = tracer.caster(&counter);
        let down = Ray::new(Vec3::new(0.1, 0.2, 2.0), -Vec3::Z);
        assert!(caster.occluded(&down));
        assert!(!caster.occluded(&Ray { t_max: 1.0, ..down }));
        assert!(!caster.occluded(&Ray { t_min: 3.0, ..down }));
        assert!(!caster.occluded(&Ray {
            direction: Vec3::NAN,
            ..down
        }));
        let mut bits = [u64::MAX];
        caster.occluded_bundle(down.origin, &[-Vec3::Z, Vec3::Z], 10.0, &mut bits);
        assert_eq!(bits[0], 1);
        drop(caster);
        assert_eq!(counter.read().shadow, 6);
    }

    #[test]
    fn an_empty_scene_is_never_hit() {
        let tracer = Tracer::new(&[], &[]);
        let counter = RayCounter::default();
        assert!(
            tracer
                .caster(&counter)
                .closest(&Ray::new(Vec3::ZERO, Vec3::X))
                .is_none()
        );
    }
}
