//! What every kernel answers.

use glam::Vec3;

use super::{Hit, Ray};

/// Rays of one origin, limited to `(0, t_max]`. Origin and directions are finite.
pub struct Bundle<'a> {
    pub origin: Vec3,
    pub directions: &'a [Vec3],
    pub t_max: f32,
}

impl Bundle<'_> {
    pub fn ray(&self, i: usize) -> Ray {
        Ray {
            t_max: self.t_max,
            ..Ray::new(self.origin, self.directions[i])
        }
    }
}

/// Traversal stacks of one thread, as long as the tree says.
#[derive(Default)]
pub struct Scratch {
    /// Children waiting for a single any-hit ray.
    pub children: Vec<u32>,
    /// Entry distance and child waiting for a single closest-hit ray.
    pub sorted: Vec<u64>,
    /// Children waiting for a tile of rays.
    pub tiles: Vec<Waiting>,
}

/// A child waiting for the rays of a tile that enter it.
#[derive(Clone, Copy, Default)]
pub struct Waiting {
    pub rays: u64,
    pub child: u32,
    /// Squared distance from the origin to the box.
    pub distance_squared: f32,
}

/// A tree with its traversal. Rays are finite apart from `t_max`, and `t_min < t_max`.
pub trait RayTree: Send + Sync {
    fn bytes(&self) -> usize;
    fn scratch(&self) -> Scratch;
    fn closest(&self, ray: &Ray, scratch: &mut Scratch) -> Option<Hit>;
    fn occluded(&self, ray: &Ray, scratch: &mut Scratch) -> bool;

    /// Sets the bits of blocked directions; `occluded` comes in cleared.
    fn occluded_bundle(&self, bundle: &Bundle, scratch: &mut Scratch, occluded: &mut [u64]) {
        for i in 0..bundle.directions.len() {
            let bit = u64::from(self.occluded(&bundle.ray(i), scratch));
            occluded[i / 64] |= bit << (i % 64);
        }
    }

    /// One hit a direction.
    fn closest_bundle(&self, bundle: &Bundle, scratch: &mut Scratch, hits: &mut [Option<Hit>]) {
        for (i, hit) in hits.iter_mut().enumerate() {
            *hit = self.closest(&bundle.ray(i), scratch);
        }
    }
}
