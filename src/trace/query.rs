//! What every kernel answers.

use glam::Vec3;

use super::{Hit, Ray};

/// Rays of one origin, limited to `(0, t_max]`. Origin and directions are finite.
pub struct Bundle<'a> {
    pub origin: Vec3,
    pub directions: &'a [Vec3],
    pub t_max: f32,
    /// Whether another tree was asked first: rays that it found blocked are done with, and its hits
    /// are limits.
    pub continues: bool,
}

impl Bundle<'_> {
    /// The same rays for a second tree.
    pub fn continued(&self) -> Self {
        Self {
            continues: true,
            ..*self
        }
    }

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

impl Scratch {
    /// Stacks for either of two trees.
    pub fn united(self, other: Self) -> Self {
        fn longer<T>(a: Vec<T>, b: Vec<T>) -> Vec<T> {
            if a.len() < b.len() { b } else { a }
        }
        Self {
            children: longer(self.children, other.children),
            sorted: longer(self.sorted, other.sorted),
            tiles: longer(self.tiles, other.tiles),
        }
    }
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

    /// The closest hit of this tree and of another one, whose hit is known; of hits at the same distance
    /// the one with the smaller index.
    fn closer(&self, ray: &Ray, known: Option<Hit>, scratch: &mut Scratch) -> Option<Hit> {
        let t_max = known.map_or(ray.t_max, |hit| hit.t);
        let found = self.closest(&Ray { t_max, ..*ray }, scratch);
        let order = |hit: &Hit| (hit.t, hit.triangle);
        match (known, found) {
            (Some(known), Some(found)) if order(&known) < order(&found) => Some(known),
            (known, found) => found.or(known),
        }
    }

    /// Sets the bits of blocked directions; `occluded` comes in cleared, or with the answers of another
    /// tree where the bundle continues.
    fn occluded_bundle(&self, bundle: &Bundle, scratch: &mut Scratch, occluded: &mut [u64]) {
        for i in 0..bundle.directions.len() {
            if occluded[i / 64] >> (i % 64) & 1 == 0 {
                let bit = u64::from(self.occluded(&bundle.ray(i), scratch));
                occluded[i / 64] |= bit << (i % 64);
            }
        }
    }

    /// One hit a direction; `hits` come in empty, or with those of another tree where the bundle continues.
    fn closest_bundle(&self, bundle: &Bundle, scratch: &mut Scratch, hits: &mut [Option<Hit>]) {
        for (i, hit) in hits.iter_mut().enumerate() {
            *hit = self.closer(&bundle.ray(i), *hit, scratch);
        }
    }
}
