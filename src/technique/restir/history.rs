//! What a viewer saw in the pass before, and where a surface of now was in it.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::receiver::{Surface, Tolerances};
use super::reservoir::Reservoir;
use crate::scene::View;

/// A pass as it is remembered.
#[derive(Serialize, Deserialize)]
pub struct History {
    pub view: View,
    /// Pixels.
    pub size: [usize; 2],
    /// Of each pixel, row-major.
    pub surfaces: Vec<Option<Surface>>,
    /// Of each pixel as many as it has, one pixel after another.
    pub reservoirs: Vec<Reservoir>,
}

/// Where a surface was in the pass before.
pub enum Then {
    /// Row-major index of the pixel that showed it.
    Pixel(usize),
    /// That pixel showed another surface.
    Other,
    /// It was out of sight.
    Outside,
}

impl History {
    /// Heap that it holds.
    pub fn bytes(&self) -> usize {
        size_of_val(self.surfaces.as_slice()) + size_of_val(self.reservoirs.as_slice())
    }

    /// Where the point `position` (then) of a surface with this normal (now) was.
    pub fn showing(&self, position: Vec3, normal: Vec3, tolerances: Tolerances) -> Then {
        let position = position.as_dvec3();
        let Some([x, y]) = self.view.project(position, self.size) else {
            return Then::Outside;
        };
        let pixel = y as usize * self.size[0] + x as usize;
        let depth = position.distance(self.view.origin) as f32;
        match &self.surfaces[pixel] {
            Some(surface) if surface.resembles(normal, depth, tolerances) => Then::Pixel(pixel),
            _ => Then::Other,
        }
    }
}
