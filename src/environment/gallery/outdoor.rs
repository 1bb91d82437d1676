//! Skies over a ground.

use glam::{DVec3, Vec3};

use super::paint::{filled, smoothstep, towards};
use crate::environment::{SunSky, sun_sky_image};
use crate::image::Image;
use crate::sample::hash;

const GROUND: Vec3 = Vec3::new(0.24, 0.22, 0.18);

/// A clear sky with the sun at this elevation; the ground reflects its light diffusely.
pub fn sky(elevation_deg: f64, turbidity: f32, disc: bool) -> Image {
    let sky = SunSky {
        sun_direction: towards(55.0, elevation_deg),
        turbidity,
        albedo: [0.22; 3],
        sun: disc,
        sun_irradiance: None,
        sun_aperture_deg: None,
        sky: true,
    };
    // Every entry of the gallery has a sun above the horizon and a turbidity in range.
    let mut image = sun_sky_image(&sky).unwrap_or_default();
    add_ground(&mut image);
    image
}

/// Fills the lower half with what the ground reflects of the upper one.
fn add_ground(image: &mut Image) {
    let (width, height) = (image.width, image.height);
    let mut irradiance = Vec3::ZERO.as_dvec3();
    for y in 0..height / 2 {
        let angle = |row: usize| std::f64::consts::PI * row as f64 / height as f64;
        let cell = std::f64::consts::TAU / width as f64 * (angle(y).cos() - angle(y + 1).cos());
        let up = (0.5 * (angle(y) + angle(y + 1))).cos();
        for pixel in &image.pixels[y * width..(y + 1) * width] {
            irradiance += Vec3::from(*pixel).as_dvec3() * (cell * up);
        }
    }
    let radiance = irradiance.as_vec3() * GROUND / std::f32::consts::PI;
    let ground: Image = filled(1, |d| {
        // A little texture: patches of grass and path.
        let wave = (7.0 * d.x / (0.2 - d.y)).sin() * (5.0 * d.z / (0.2 - d.y)).cos();
        radiance * (1.0 + 0.15 * wave as f32)
    });
    let horizon = height / 2 * width;
    image.pixels[horizon..].copy_from_slice(&ground.pixels[horizon..]);
}

/// The overcast sky of the CIE, brightest at the zenith.
pub fn overcast() -> Image {
    let mut image = filled(1, |d| {
        let clouds = 1.0
            + 0.12 * (4.0 * d.x + 2.0 * (3.0 * d.z).sin()).sin()
            + 0.08 * (11.0 * d.z + 5.0 * d.x * d.y).sin();
        Vec3::new(0.93, 0.97, 1.03) * ((1.0 + 2.0 * d.y.max(0.0)) / 3.0 * clouds) as f32
    });
    add_ground(&mut image);
    image
}

/// Leaves before a bright sky: light through many small gaps of all sizes.
pub fn canopy() -> Image {
    let leaves = |d: DVec3| {
        let density = 0.5 * noise(d * 9.0) + 0.3 * noise(d * 23.0) + 0.2 * noise(d * 57.0);
        let open = 0.34 + 0.1 * d.y.max(0.0);
        smoothstep(open + 0.012, open - 0.012, density)
    };
    let mut image = filled(2, |d| {
        let clouds = 0.6 + 0.8 * noise(d * 2.2 + DVec3::splat(7.3));
        let sky = Vec3::new(0.75, 0.95, 1.2) * (9.0 * clouds) as f32;
        let foliage = Vec3::new(0.1, 0.16, 0.05) * (0.5 + 0.8 * noise(d * 31.0)) as f32;
        let gap = leaves(d) as f32 * smoothstep(0.0, 0.25, d.y) as f32;
        foliage + (sky - foliage) * gap
    });
    add_ground(&mut image);
    image
}

/// Smooth value noise in [0, 1].
fn noise(p: DVec3) -> f64 {
    let (cell, t) = (p.floor(), p - p.floor());
    let t = t * t * (DVec3::splat(3.0) - 2.0 * t);
    let corner = |i: i64, j: i64, k: i64| {
        let at = |v: f64, o: i64| (v as i64 + o) as u64;
        let bits = hash(hash(hash(at(cell.x, i)) ^ at(cell.y, j)) ^ at(cell.z, k));
        (bits >> 11) as f64 / (1u64 << 53) as f64
    };
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let along_x = |j, k| mix(corner(0, j, k), corner(1, j, k), t.x);
    let along_y = |k| mix(along_x(0, k), along_x(1, k), t.y);
    mix(along_y(0), along_y(1), t.z)
}
