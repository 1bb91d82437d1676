//! The visibility pass: what the camera samples of a viewer see, and which texels they ask for.

use glam::Vec3;
use rayon::prelude::*;

use super::options::{Filter, Parameters};
use super::texels::{Surfaces, normal_of, twice_area};
use crate::cache::surface::{Grid, Requests, Surface, Texel};
use crate::memory::room_for;
use crate::sample::Rng;
use crate::scene::Scene;
use crate::shade::{Leg, Met};
use crate::technique::Shot;
use crate::trace::{Caster, Hit, Ray, RayCounter};

/// What a viewer sees.
pub(super) struct Sight {
    /// Pixel by pixel, and sample by sample in each; `None` where no surface is seen.
    pub looks: Vec<Option<Look>>,
    /// Texels that it asks for.
    pub requests: Requests,
    /// Camera samples for which there are no texels of the size that suits them.
    pub other_sizes: u64,
}

/// What a camera sample meets.
#[derive(Clone, Copy)]
pub(super) struct Look {
    pub hit: Hit,
    /// Of the camera ray, unit.
    pub direction: Vec3,
    /// `None` on surfaces that no light shines on: mirrors and glass.
    pub address: Option<Address>,
}

/// Where a camera sample lies among texels.
#[derive(Clone, Copy)]
pub(super) struct Address {
    surface: Surface,
    place: glam::Vec2,
    /// A whole number, but for filters that read two levels.
    level: f32,
    /// Whether another size of texels would have suited it.
    other_size: bool,
}

/// Finds the addresses of a viewer's camera samples.
struct Addresses<'a> {
    shot: &'a Shot<'a>,
    surfaces: &'a Surfaces,
    parameters: &'a Parameters,
    /// Of the places of camera samples in pixels.
    seed: u64,
    /// Side of a pixel at distance 1.
    pixel_angle: f32,
}

/// Pixels along a side of the tiles whose camera rays are cast together.
const TILE: usize = 8;

impl Sight {
    /// Casts the camera samples of a shot.
    pub fn new(
        shot: &Shot,
        surfaces: &Surfaces,
        parameters: &Parameters,
        seed: u64,
        counter: &RayCounter,
    ) -> Self {
        let samples = shot.spp as usize;
        let [_, half] = shot.view.half_tangents(shot.width, shot.height);
        let addresses = Addresses {
            shot,
            surfaces,
            parameters,
            seed,
            pixel_angle: (2.0 * half / shot.height as f64) as f32,
        };
        // Written by all threads: one alone would wait for each page of it.
        let mut looks = room_for(shot.pixels() * samples);
        looks.par_extend(rayon::iter::repeat_n(None, shot.pixels() * samples));
        let band = (shot.width * TILE * samples).max(1);
        let bands: Vec<(Requests, u64)> = looks
            .par_chunks_mut(band)
            .enumerate()
            .map_init(
                || shot.tracer.caster(counter),
                |caster, (band, looks)| {
                    addresses.look(caster, band * TILE, looks);
                    addresses.requests(looks)
                },
            )
            .collect();
        let other_sizes = bands.iter().map(|(_, others)| others).sum();
        let requests = bands.into_iter().map(|(requests, _)| requests).collect();
        Self {
            looks,
            requests: Requests::merged(requests),
            other_sizes,
        }
    }
}

/// Keys the places of camera samples in pixels.
const STREAM: u64 = 0x636f_6e65_6361;
/// Keys which masks they pass.
const MASKS: u64 = 0x636f_6e65_6d61;

/// The camera ray through sample `sample` of a pixel: evenly spread ones, moved together to another place of the pixel in
/// each frame, so that a mean over frames has smooth edges. Viewers who see the same cast the same.
pub(super) fn camera_ray(shot: &Shot, seed: u64, pixel: u32, sample: u32) -> Ray {
    let mut rng = Rng::new(seed, STREAM, u64::from(pixel), u64::from(shot.frame));
    let [dx, dy] = Shot::sub_pixel(sample).map(|part| (part + rng.next_f64()).fract());
    let x = (pixel as usize % shot.width) as f64 + dx;
    let y = (pixel as usize / shot.width) as f64 + dy;
    shot.ray_through(x, y)
}

/// What a camera sample meets behind the opacity masks that it passes.
pub(super) fn meet<'s>(
    shot: &'s Shot,
    caster: &Caster,
    seed: u64,
    [pixel, sample]: [u32; 2],
) -> Met<'s> {
    let item = u64::from(pixel) << 32 | u64::from(sample);
    let mut rng = Rng::new(seed, MASKS, item, u64::from(shot.frame));
    let ray = camera_ray(shot, seed, pixel, sample);
    shot.paths.meet(caster, Leg::from_camera(ray), &mut rng)
}

impl Addresses<'_> {
    /// Casts the camera samples of a band of pixels from row `top` on.
    fn look(&self, caster: &Caster, top: usize, looks: &mut [Option<Look>]) {
        let shot = self.shot;
        let samples = shot.spp as usize;
        let rows = looks.len() / (shot.width * samples).max(1);
        let origin = shot.view.origin.as_vec3();
        let mut directions = Vec::with_capacity(TILE * TILE);
        let mut hits = vec![None; TILE * TILE];
        for left in (0..shot.width).step_by(TILE) {
            let columns = left..(left + TILE).min(shot.width);
            let pixels =
                || (0..rows).flat_map(|y| columns.clone().map(move |x| y * shot.width + x));
            for sample in 0..samples {
                directions.clear();
                directions.extend(pixels().map(|pixel| {
                    let pixel = (top * shot.width + pixel) as u32;
                    camera_ray(shot, self.seed, pixel, sample as u32).direction
                }));
                let hits = &mut hits[..directions.len()];
                caster.closest_bundle(origin, &directions, f32::INFINITY, hits);
                for ((pixel, hit), direction) in pixels().zip(hits).zip(&directions) {
                    let number = [(top * shot.width + pixel) as u32, sample as u32];
                    let hit = self.behind_masks(caster, *hit, number);
                    looks[pixel * samples + sample] = hit.map(|hit| Look {
                        hit,
                        direction: *direction,
                        address: self.of(&hit, *direction),
                    });
                }
            }
        }
    }

    /// What stops the ray of a camera sample, of which the first hit is known.
    fn behind_masks(&self, caster: &Caster, hit: Option<Hit>, number: [u32; 2]) -> Option<Hit> {
        if hit.is_none() || !self.shot.paths.surfaces().has_masks() {
            return hit;
        }
        match meet(self.shot, caster, self.seed, number) {
            Met::Sky { .. } => None,
            Met::Surface(vertex) => Some(vertex.hit),
        }
    }

    /// Where a hit lies among texels; `None` on surfaces that no light shines on, mirrors and glass, and on what had no area
    /// when the charts were made.
    fn of(&self, hit: &Hit, direction: Vec3) -> Option<Address> {
        let scene = self.shot.scene;
        let front = normal_of(scene, hit.triangle, false);
        let back = direction.dot(front) > 0.0;
        if is_delta(scene, hit.triangle, back) || !self.surfaces.charts.has_extent(hit.triangle) {
            return None;
        }
        let found = self.surfaces.charts.place(hit.triangle, [hit.u, hit.v]);
        // Texels have the lengths of the charts.
        let grown = self
            .surfaces
            .charts
            .grown(hit.triangle, twice_area(scene, hit.triangle));
        let size = hit.t * self.pixel_angle / grown;
        let extent = self.surfaces.charts.size(found.island);
        let wanted = self.surfaces.grid.level(size) + self.parameters.bias;
        let wanted = match self.parameters.filter {
            Filter::Trilinear => wanted,
            Filter::Nearest | Filter::Bilinear => wanted.round(),
        };
        let level = self.surfaces.grid.within(wanted, extent);
        Some(Address {
            surface: Surface {
                island: found.island,
                back,
            },
            place: found.place,
            level,
            other_size: level != wanted,
        })
    }

    /// What camera samples ask for, and for how many another size of texels would have been better.
    fn requests(&self, looks: &[Option<Look>]) -> (Requests, u64) {
        let mut requests = Requests::default();
        let mut other_sizes = 0;
        for address in looks.iter().flatten().filter_map(|look| look.address) {
            let (grid, filter) = (&self.surfaces.grid, self.parameters.filter);
            address.for_each_texel(grid, filter, |texel, _| requests.ask(texel));
            other_sizes += u64::from(address.other_size);
        }
        requests.merge();
        (requests, other_sizes)
    }
}

impl Address {
    /// In the chart, scene units.
    pub fn place(&self) -> glam::Vec2 {
        self.place
    }

    /// Calls `each` with the texels that are read there and their weights, none of which is 0.
    pub fn for_each_texel(&self, grid: &Grid, filter: Filter, mut each: impl FnMut(Texel, f32)) {
        let (finer, coarser) = (self.level as u32, self.level.fract());
        for (level, share) in [(finer, 1.0 - coarser), (finer + 1, coarser)] {
            if share <= 0.0 {
                continue;
            }
            let texels = match filter {
                Filter::Nearest => {
                    let texel = grid.nearest(self.surface, self.place, level);
                    [1.0, 0.0, 0.0, 0.0].map(|weight| (texel, weight))
                }
                Filter::Bilinear | Filter::Trilinear => {
                    grid.around(self.surface, self.place, level)
                }
            };
            for (texel, weight) in texels {
                if weight > 0.0 {
                    each(texel, weight * share);
                }
            }
        }
    }
}

/// Whether the side of a triangle is that of a mirror or glass.
fn is_delta(scene: &Scene, triangle: u32, back: bool) -> bool {
    let shape = scene.triangle_shape.get(triangle as usize);
    let shape = shape.and_then(|&shape| scene.shapes.get(shape as usize));
    let front = shape.and_then(|shape| scene.materials.get(shape.material as usize));
    let material = front.and_then(|front| match front.back {
        Some(behind) if back => scene.materials.get(behind),
        _ => Some(front),
    });
    material.is_some_and(|material| material.bsdf.is_delta())
}
