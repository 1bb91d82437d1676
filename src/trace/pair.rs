//! Two trees that answer as one: what stands still, and what moves and is built anew each frame.

use std::sync::Arc;

use super::query::{Bundle, RayTree, Scratch};
use super::{Hit, Ray};

/// A tree that is kept, and one that is replaced when its triangles move.
pub struct Pair {
    pub still: Arc<dyn RayTree>,
    pub moving: Box<dyn RayTree>,
}

impl RayTree for Pair {
    fn bytes(&self) -> usize {
        self.still.bytes() + self.moving.bytes()
    }

    fn scratch(&self) -> Scratch {
        self.still.scratch().united(self.moving.scratch())
    }

    fn closest(&self, ray: &Ray, scratch: &mut Scratch) -> Option<Hit> {
        let known = self.still.closest(ray, scratch);
        self.moving.closer(ray, known, scratch)
    }

    fn occluded(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
        self.still.occluded(ray, scratch) || self.moving.occluded(ray, scratch)
    }

    fn occluded_bundle(&self, bundle: &Bundle, scratch: &mut Scratch, occluded: &mut [u64]) {
        self.still.occluded_bundle(bundle, scratch, occluded);
        self.moving
            .occluded_bundle(&bundle.continued(), scratch, occluded);
    }

    fn closest_bundle(&self, bundle: &Bundle, scratch: &mut Scratch, hits: &mut [Option<Hit>]) {
        self.still.closest_bundle(bundle, scratch, hits);
        self.moving
            .closest_bundle(&bundle.continued(), scratch, hits);
    }
}
