//! The shading points of an image: one primary hit at each pixel's centre, in structure of arrays.

use glam::Vec3;
use rayon::prelude::*;

use crate::trace::Hit;

/// Marks a pixel that sees the background.
pub const NO_POINT: u32 = u32::MAX;

/// The spot of a shading point on its surface, and how the camera came to it: what shading it takes, without another
/// camera ray.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sight {
    /// Triangle and barycentric weights.
    pub hit: Hit,
    /// Unit direction of the last ray.
    pub direction: Vec3,
    /// Product of the specular reflections and transmissions on the way.
    pub throughput: Vec3,
}

/// What placements work on: points seen by the camera, scene units, in row-major pixel order.
#[derive(Clone, Debug, Default)]
pub struct ShadingPoints {
    /// On the surface, relative to the scene's centre.
    pub position: Vec<Vec3>,
    /// Unit shading normal, turned to the viewer's side.
    pub normal: Vec<Vec3>,
    /// Unit geometric normal, on the same side as `normal`.
    pub geometric_normal: Vec<Vec3>,
    /// Distance along the camera ray.
    pub depth: Vec<f32>,
    /// Row-major pixel index of each point.
    pub pixel: Vec<u32>,
    /// Empty where nothing is shaded.
    pub sight: Vec<Sight>,
    /// Film size in pixels.
    pub width: usize,
    /// See `width`.
    pub height: usize,
    /// Index of the point of each pixel, or [`NO_POINT`].
    pub point_of_pixel: Vec<u32>,
    /// Diagonal of the scene's bounding box, scene units (the papers' L).
    pub diagonal: f32,
    /// Metres per scene unit, for formulas that are in metres.
    pub metres_per_unit: f32,
    /// Whether nothing declares the unit, so that `metres_per_unit` follows from the diagonal.
    pub unit_is_assumed: bool,
}

impl ShadingPoints {
    /// How many points there are; all vectors but `point_of_pixel` and `sight` have this length.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let points = self.len() * (3 * size_of::<Vec3>() + 2 * size_of::<u32>());
        points + size_of_val(self.sight.as_slice()) + size_of_val(self.point_of_pixel.as_slice())
    }

    /// Whether the camera sees no surface.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Sorts points by blocks of 32 × 32 pixels: what is evaluated in this order finds the scene in
    /// the processor's caches.
    pub fn sort_by_block(&self, points: &mut [u32]) {
        const BLOCK: usize = 32;
        points.par_sort_unstable_by_key(|&point| {
            let pixel = self.pixel[point as usize] as usize;
            let (x, y) = (pixel % self.width, pixel / self.width);
            (y / BLOCK, x / BLOCK, point)
        });
    }

    /// Values by point as a picture, 0 where there is none.
    pub fn picture(&self, value: impl Fn(usize) -> f32 + Sync) -> Vec<f32> {
        let of_pixel = |&point: &u32| match point {
            NO_POINT => 0.0,
            point => value(point as usize),
        };
        self.point_of_pixel.par_iter().map(of_pixel).collect()
    }
}
