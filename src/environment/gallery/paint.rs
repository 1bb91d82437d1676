//! Filling maps by direction, and the maps that are only tests.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::image::Image;

pub const WIDTH: usize = 1024;
pub const HEIGHT: usize = 512;

/// Direction of a point of the map, in texels.
pub fn direction(x: f64, y: f64) -> DVec3 {
    let (sin, cos) = (PI * y / HEIGHT as f64).sin_cos();
    let (sin_phi, cos_phi) = (TAU * x / WIDTH as f64).sin_cos();
    DVec3::new(sin_phi * sin, cos, -cos_phi * sin)
}

/// A direction by azimuth (0 is +z, 90 is +x) and elevation.
pub fn towards(azimuth_deg: f64, elevation_deg: f64) -> DVec3 {
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    let (up, flat) = elevation_deg.to_radians().sin_cos();
    DVec3::new(sin * flat, up, cos * flat)
}

/// Radiance by direction, the mean of `side`² points in each texel.
pub fn filled(side: usize, radiance: impl Fn(DVec3) -> Vec3 + Sync) -> Image {
    let mut image = Image::new(WIDTH, HEIGHT);
    image
        .pixels
        .par_chunks_mut(WIDTH)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let mut sum = Vec3::ZERO;
                for k in 0..side * side {
                    let at = |i: usize| (i as f64 + 0.5) / side as f64;
                    let (u, v) = (x as f64 + at(k % side), y as f64 + at(k / side));
                    sum += radiance(direction(u, v));
                }
                *pixel = (sum / (side * side) as f32).into();
            }
        });
    image
}

/// Share of a disc's radiance in a direction: 1 inside its angular radius, falling to 0 over a fifth
/// of it.
pub fn disc(direction: DVec3, centre: DVec3, radius_rad: f64) -> f32 {
    let angle = 2.0 * (0.5 * (direction - centre).length()).min(1.0).asin();
    ((1.1 - angle / radius_rad) / 0.2).clamp(0.0, 1.0) as f32
}

/// From 0 to 1 between two values, smoothly.
pub fn smoothstep(low: f64, high: f64, value: f64) -> f64 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

pub fn constant() -> Image {
    Image {
        width: WIDTH,
        height: HEIGHT,
        pixels: vec![[1.0; 3]; WIDTH * HEIGHT],
    }
}

pub fn black() -> Image {
    Image::new(WIDTH, HEIGHT)
}

/// Half of the light comes from one texel.
pub fn texel() -> Image {
    let mut image = Image {
        width: WIDTH,
        height: HEIGHT,
        pixels: vec![[0.05; 3]; WIDTH * HEIGHT],
    };
    image.pixels[150 * WIDTH + 610] = [21_000.0, 20_000.0, 18_000.0];
    image
}
