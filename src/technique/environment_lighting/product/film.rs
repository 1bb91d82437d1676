//! What the pixels gathered, in planes: rows of one number for all pixels.

use glam::Vec3;

use crate::environment::product_ratio::ProductRatio;
use crate::image::luminance;

/// Planes that the filter compares pixels by.
pub(super) const OBJECT: usize = 0;
pub(super) const NORMAL: usize = 1;
pub(super) const POSITION: usize = 4;
/// 1 / (tolerance · distance from the camera).
pub(super) const NEARNESS: usize = 7;
/// Planes of the groups: shadowed (3) and unshadowed (3) over U, own ratio, and whether there is one.
pub(super) const GROUPS: [usize; 2] = [8, 16];
pub(super) const SHADOWED: usize = 0;
pub(super) const UNSHADOWED: usize = 3;
pub(super) const OWN: usize = 6;
pub(super) const HAS_OWN: usize = 7;
const PLANES: usize = 24;
/// No object.
pub(super) const NOTHING: f32 = -1.0;

/// A pixel after its rays.
#[derive(Clone, Copy, Default)]
pub(super) struct Gathered {
    /// Light that no ratio is applied to: the background, or all of it.
    pub plain: Vec3,
    pub throughput: Vec3,
    /// U by group.
    pub unshadowed: [Vec3; 2],
}

/// Where and what a pixel sees, and its sums.
pub(super) struct Site {
    pub object: u32,
    pub normal: Vec3,
    pub position: Vec3,
    pub depth: f32,
    /// Σ a · contribution · visibility, by group.
    pub shadowed: [Vec3; 2],
    /// Σ a · contribution, by group.
    pub sampled: [Vec3; 2],
}

/// All pixels.
pub(super) struct Film {
    pub size: [usize; 2],
    /// Pixels beside each row, which hold nothing.
    pub margin: usize,
    pub stride: usize,
    plane_tolerance: f32,
    pub pixels: Vec<Gathered>,
    planes: Vec<f32>,
}

/// Pixels of the filter's blocks; rows are padded to a multiple.
pub(super) const BLOCK: usize = 16;

impl Film {
    pub fn new([width, height]: [usize; 2], parameters: &ProductRatio) -> Self {
        let margin = parameters.direct_reach.max(parameters.indirect_reach);
        let stride = width.next_multiple_of(BLOCK) + 2 * margin;
        Self {
            size: [width, height],
            margin,
            stride,
            plane_tolerance: parameters.plane_tolerance,
            pixels: vec![Gathered::default(); width * height],
            planes: vec![0.0; PLANES * stride * height],
        }
    }

    /// A row of a plane, with its margins.
    pub fn plane(&self, y: usize, plane: usize) -> &[f32] {
        let start = (y * PLANES + plane) * self.stride;
        &self.planes[start..start + self.stride]
    }

    /// Bands of rows for threads to fill.
    pub fn bands(&mut self, rows: usize) -> Vec<Band<'_>> {
        let (width, stride) = (self.size[0], self.stride);
        let pixels = self.pixels.chunks_mut(width * rows);
        let planes = self.planes.chunks_mut(PLANES * stride * rows);
        pixels
            .zip(planes)
            .enumerate()
            .map(|(band, (pixels, planes))| Band {
                first: band * rows,
                width,
                margin: self.margin,
                stride,
                plane_tolerance: self.plane_tolerance,
                pixels,
                planes,
            })
            .collect()
    }
}

/// Some rows.
pub(super) struct Band<'a> {
    /// The first row.
    pub first: usize,
    pub width: usize,
    margin: usize,
    stride: usize,
    plane_tolerance: f32,
    pixels: &'a mut [Gathered],
    planes: &'a mut [f32],
}

impl Band<'_> {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.pixels.len() / self.width
    }

    /// Nothing anywhere.
    pub fn clear(&mut self) {
        for row in self.planes.chunks_mut(PLANES * self.stride) {
            row[OBJECT * self.stride..(OBJECT + 1) * self.stride].fill(NOTHING);
        }
    }

    /// Sets a pixel of a row of the band.
    pub fn set(&mut self, [x, row]: [usize; 2], gathered: Gathered, site: Option<&Site>) {
        self.pixels[row * self.width + x] = gathered;
        let Some(site) = site else { return };
        let start = row * PLANES * self.stride + self.margin + x;
        let mut put = |plane: usize, value: f32| {
            // What is not finite must not reach the neighbours.
            let value = if value.is_finite() { value } else { 0.0 };
            self.planes[start + plane * self.stride] = value;
        };
        put(OBJECT, site.object as f32);
        for axis in 0..3 {
            put(NORMAL + axis, site.normal[axis]);
            put(POSITION + axis, site.position[axis]);
        }
        put(
            NEARNESS,
            1.0 / (self.plane_tolerance * site.depth.max(f32::MIN_POSITIVE)),
        );
        for (group, &first) in GROUPS.iter().enumerate() {
            let y = luminance(gathered.unshadowed[group].into());
            let scale = if y > 0.0 { 1.0 / y } else { 0.0 };
            let scale = if scale.is_finite() { scale } else { 0.0 };
            let (shadowed, sampled) = (site.shadowed[group], site.sampled[group]);
            for c in 0..3 {
                put(first + SHADOWED + c, shadowed[c] * scale);
                put(first + UNSHADOWED + c, sampled[c] * scale);
            }
            let all = luminance(sampled.into());
            let some = scale > 0.0 && all > 0.0;
            let own = if some {
                luminance(shadowed.into()) / all
            } else {
                0.0
            };
            put(first + OWN, own);
            put(first + HAS_OWN, f32::from(u8::from(some)));
        }
    }
}
