//! Which material a ray meets where a shape has several: that of its back, or one of a blend.

use glam::Vec3;

use super::materials::{Place, Surfaces};
use crate::sample::Rng;
use crate::trace::Hit;

/// Keys the choice among blended materials.
const STREAM: u64 = 0x626c_656e_6465;

/// How a ray meets a surface.
pub(super) struct Met<'a> {
    pub hit: &'a Hit,
    pub direction: Vec3,
    /// Whether it comes from the back.
    pub behind: bool,
    pub place: &'a Place,
}

impl Surfaces<'_> {
    /// Index of the material that a ray meets on a shape of this one. Backs and blends may hold others in turn.
    pub(super) fn material_met(&self, mut index: usize, met: &Met) -> usize {
        while let Some(other) = self.in_place_of(index, met) {
            index = other;
        }
        index
    }

    fn in_place_of(&self, index: usize, met: &Met) -> Option<usize> {
        let material = self.scene.materials.get(index)?;
        if let (Some(back), true) = (material.back, met.behind) {
            return Some(back);
        }
        let blend = material.blend?;
        let takes_second = met.chance(index) < self.share(blend.second, met.place);
        Some(blend.materials[usize::from(takes_second)])
    }
}

impl Met<'_> {
    /// Decides which part of material number `index` is met: a number in [0, 1), the same for the same ray at the same place,
    /// and as if by chance among others.
    fn chance(&self, index: usize) -> f32 {
        let pair = |a: f32, b: f32| u64::from(a.to_bits()) << 32 | u64::from(b.to_bits());
        let place = pair(self.hit.u, self.hit.v) ^ u64::from(self.hit.triangle);
        let way = pair(self.direction.x, self.direction.y);
        Rng::new(place, STREAM, way, index as u64).next_f32()
    }
}
