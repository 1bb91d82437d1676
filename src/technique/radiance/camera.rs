//! Camera paths of the contenders.

use glam::Vec3;

use crate::sample::Rng;
use crate::shade::Leg;
use crate::technique::Shot;
use crate::trace::Ray;

/// Keeps the random numbers of viewers apart.
pub fn viewer_key(shot: &Shot) -> u64 {
    u64::from(shot.viewer) << 48
}

/// Unit direction through a random place of a pixel, of an image of this width and height.
pub fn jittered(shot: &Shot, pixel: [usize; 2], size: [usize; 2], rng: &mut Rng) -> Vec3 {
    let [x, y] = pixel.map(|p| p as f64 + rng.next_f64());
    shot.view.direction(x, y, size)
}

/// The first leg of a path through a random place of a pixel.
pub fn first_leg(shot: &Shot, pixel: [usize; 2], rng: &mut Rng) -> Leg {
    let direction = jittered(shot, pixel, [shot.width, shot.height], rng);
    Leg::from_camera(Ray::new(shot.view.origin.as_vec3(), direction))
}
