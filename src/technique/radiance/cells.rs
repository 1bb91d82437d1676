//! Which cell of a cache each pixel of an image shows, to be looked at.

use rayon::prelude::*;

use crate::sample::{Rng, hash};
use crate::shade::{Leg, Met, Vertex};
use crate::technique::Shot;
use crate::trace::{Ray, RayCounter};

/// Numbers that cells have.
const NUMBERS: u64 = 1023;
/// Keys the random numbers of surfaces that are there by chance.
const STREAM: u64 = 0x6365_6c6c;

/// A number in 1..=1023, by chance, for the cell of what the camera sees through the middle of each pixel, row by row;
/// 0 where `key` gives none. No ray is counted.
pub fn cell_numbers(shot: &Shot, key: impl Fn(&Vertex) -> Option<u64> + Sync) -> Vec<f32> {
    let uncounted = RayCounter::default();
    let [width, height] = [shot.width, shot.height];
    let origin = shot.view.origin.as_vec3();
    let number = |caster: &mut _, pixel: usize| {
        let [x, y] = [pixel % width, pixel / width].map(|place| place as f64 + 0.5);
        let leg = Leg::from_camera(Ray::new(origin, shot.view.direction(x, y, [width, height])));
        let mut rng = Rng::new(0, STREAM, pixel as u64, 0);
        let Met::Surface(seen) = shot.paths.meet(caster, leg, &mut rng) else {
            return 0.0;
        };
        key(&seen).map_or(0.0, |key| (1 + hash(key) % NUMBERS) as f32)
    };
    let pixels = (0..width * height).into_par_iter();
    pixels
        .map_init(|| shot.tracer.caster(&uncounted), number)
        .collect()
}
