//! The shading points of a shot: what the centres of its pixels see.

use rayon::prelude::*;

use super::shot::{TILE, tile_pixels};
use super::{Seen, Shot};
use crate::cache::{NO_POINT, ShadingPoints, Sight};
use crate::trace::{Caster, RayCounter};

/// What the centres of a band of pixels see, in row-major order.
fn look_band(shot: &Shot, caster: &Caster, top: usize) -> Vec<Seen> {
    let mut tiled = Vec::with_capacity(shot.width * TILE);
    for left in (0..shot.width).step_by(TILE) {
        let tile = tile_pixels(shot, [left, top], shot.height);
        shot.look_tile(caster, &tile, 0..1, &mut tiled);
    }
    tiled.sort_unstable_by_key(|seen| seen.pixel);
    tiled
}

/// One shading point at the centre of each pixel that sees a surface, in row-major order.
pub fn shading_points(shot: &Shot, counter: &RayCounter) -> ShadingPoints {
    let bands: Vec<Vec<Seen>> = (0..shot.height.div_ceil(TILE))
        .into_par_iter()
        .map_init(
            || shot.tracer.caster(counter),
            |caster, band| look_band(shot, caster, band * TILE),
        )
        .collect();
    let starts: Vec<usize> = bands
        .iter()
        .scan(0, |next, band| {
            let start = *next;
            *next += band.len();
            Some(start)
        })
        .collect();
    let count = bands.iter().map(Vec::len).sum();
    let seen = Ordered {
        bands: &bands,
        starts: &starts,
        count,
    };
    let mut point_of_pixel = Vec::new();
    point_of_pixel.par_extend(rayon::iter::repeat_n(NO_POINT, shot.pixels()));
    point_of_pixel
        .par_chunks_mut((shot.width * TILE).max(1))
        .enumerate()
        .for_each(|(band, points)| {
            let first_pixel = band * TILE * shot.width;
            for (point, seen) in (starts[band]..).zip(&bands[band]) {
                points[seen.pixel as usize - first_pixel] = point as u32;
            }
        });
    let points = ShadingPoints {
        position: seen.each(|seen| seen.site.position),
        normal: seen.each(|seen| seen.site.normal),
        geometric_normal: seen.each(|seen| seen.site.geometric_normal),
        depth: seen.each(|seen| seen.depth),
        pixel: seen.each(|seen| seen.pixel),
        sight: seen.each(|seen| Sight {
            hit: seen.hit,
            direction: seen.direction,
            throughput: seen.throughput,
        }),
        width: shot.width,
        height: shot.height,
        point_of_pixel,
        diagonal: shot.scene.diagonal,
        metres_per_unit: shot.scene.metres_per_unit as f32,
        unit_is_assumed: shot.scene.unit_is_assumed,
    };
    // One thread alone would give back their memory page by page.
    bands.into_par_iter().for_each(drop);
    points
}

/// What bands saw, one after another.
struct Ordered<'a> {
    bands: &'a [Vec<Seen>],
    /// Index of the first item of each band among all.
    starts: &'a [usize],
    count: usize,
}

impl Ordered<'_> {
    /// A value of each item, by all threads.
    fn each<T: Send>(&self, value: impl Fn(&Seen) -> T + Sync) -> Vec<T> {
        let item = |i: usize| {
            let band = self.starts.partition_point(|start| *start <= i) - 1;
            value(&self.bands[band][i - self.starts[band]])
        };
        let indices = (0..self.count).into_par_iter().with_min_len(4096);
        indices.map(item).collect()
    }
}
