//! The handle that casts and counts rays.

use std::cell::{Cell, RefCell};

use glam::Vec3;

use super::query::{Bundle, Scratch};
use super::{Hit, Ray, RayCounter, RayCounts, Tracer};

/// Casts rays of one thread. Rays with a member that is not finite (`t_max` may be infinite) are
/// refused: they hit nothing and are counted as rays and as refused ones.
pub struct Caster<'a> {
    tracer: &'a Tracer,
    counter: &'a RayCounter,
    counts: Cell<RayCounts>,
    scratch: RefCell<Scratch>,
}

impl<'a> Caster<'a> {
    pub(super) fn new(tracer: &'a Tracer, counter: &'a RayCounter) -> Self {
        let scratch = tracer.tree.as_ref().map(|tree| tree.scratch());
        Self {
            tracer,
            counter,
            counts: Cell::default(),
            scratch: RefCell::new(scratch.unwrap_or_default()),
        }
    }

    /// The closest hit in `(t_min, t_max]`; of hits at the same distance, the one with the
    /// smallest triangle index.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.count(|c| c.closest += 1);
        let tree = self.tracer.tree.as_ref()?;
        if !self.accepts(ray) {
            return None;
        }
        tree.closest(ray, &mut self.scratch.borrow_mut())
    }

    /// Whether anything lies in `(t_min, t_max]`.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.count(|c| c.shadow += 1);
        let Some(tree) = self.tracer.tree.as_ref() else {
            return false;
        };
        self.accepts(ray) && tree.occluded(ray, &mut self.scratch.borrow_mut())
    }

    /// Occlusion of many rays of one origin in `(0, t_max]`: bit `i % 64` of `occluded[i / 64]` is
    /// set when direction `i` is blocked. `occluded` must hold `directions.len()` bits. The answers
    /// are those of [`Caster::occluded`]; fastest for the row-major grids of
    /// [`crate::sample::equal_area_hemisphere`] and for runs of 64 similar directions.
    pub fn occluded_bundle(
        &self,
        origin: Vec3,
        directions: &[Vec3],
        t_max: f32,
        occluded: &mut [u64],
    ) {
        occluded.fill(0);
        self.count(|c| c.shadow += directions.len() as u64);
        let bundle = Bundle {
            origin,
            directions,
            t_max,
            continues: false,
        };
        let Some(tree) = self.tracer.tree.as_ref() else {
            return;
        };
        if self.accepts_all(&bundle) {
            tree.occluded_bundle(&bundle, &mut self.scratch.borrow_mut(), occluded);
            return;
        }
        for i in (0..directions.len()).filter(|&i| self.accepts(&bundle.ray(i))) {
            let blocked = tree.occluded(&bundle.ray(i), &mut self.scratch.borrow_mut());
            occluded[i / 64] |= u64::from(blocked) << (i % 64);
        }
    }

    /// Closest hits of many rays of one origin in `(0, t_max]`, one for each direction. `hits` must
    /// be as long as `directions`, which have unit length. The answers are those of [`Caster::closest`].
    pub fn closest_bundle(
        &self,
        origin: Vec3,
        directions: &[Vec3],
        t_max: f32,
        hits: &mut [Option<Hit>],
    ) {
        hits.fill(None);
        self.count(|c| c.closest += directions.len() as u64);
        let bundle = Bundle {
            origin,
            directions,
            t_max,
            continues: false,
        };
        let Some(tree) = self.tracer.tree.as_ref() else {
            return;
        };
        if self.accepts_all(&bundle) {
            tree.closest_bundle(&bundle, &mut self.scratch.borrow_mut(), hits);
            return;
        }
        for i in (0..directions.len()).filter(|&i| self.accepts(&bundle.ray(i))) {
            hits[i] = tree.closest(&bundle.ray(i), &mut self.scratch.borrow_mut());
        }
    }

    fn count(&self, change: impl FnOnce(&mut RayCounts)) {
        let mut counts = self.counts.get();
        change(&mut counts);
        self.counts.set(counts);
    }

    /// Whether a ray can hit anything; counts it when it is refused.
    fn accepts(&self, ray: &Ray) -> bool {
        if !is_sound(ray) {
            self.count(|c| c.refused += 1);
            return false;
        }
        ray.t_max > ray.t_min.max(0.0)
    }

    /// Whether every ray of a bundle is accepted; counts nothing.
    fn accepts_all(&self, bundle: &Bundle) -> bool {
        bundle.origin.is_finite()
            && bundle.t_max > 0.0
            && bundle.directions.iter().all(|d| d.is_finite())
    }
}

impl Drop for Caster<'_> {
    fn drop(&mut self) {
        self.counter.add(self.counts.get());
    }
}

fn is_sound(ray: &Ray) -> bool {
    ray.origin.is_finite()
        && ray.direction.is_finite()
        && ray.t_min.is_finite()
        && !ray.t_max.is_nan()
}
