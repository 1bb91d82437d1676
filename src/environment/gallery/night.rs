//! Nights with many small lights.

use glam::{DVec3, Vec3};

use super::paint::{disc, filled, towards};
use crate::image::Image;
use crate::sample::Rng;

struct Lamp {
    direction: DVec3,
    radius_rad: f64,
    radiance: Vec3,
}

/// Lamps of a street: the far ones are many, small and near the horizon.
pub fn street() -> Image {
    let mut rng = Rng::new(11, 0x6e69_6768, 0, 0);
    let lamps: Vec<Lamp> = (0..70)
        .map(|i| {
            let distance_m = 4.0 * 40f64.powf((f64::from(i) + rng.next_f64()) / 70.0);
            let height_m = 3.0 + 2.0 * rng.next_f64();
            let elevation_deg = (height_m / distance_m).atan().to_degrees();
            let warm = rng.next_f32();
            Lamp {
                direction: towards(360.0 * rng.next_f64(), elevation_deg),
                radius_rad: (0.16 / distance_m).max(0.004),
                radiance: Vec3::new(1.0, 0.62 + 0.3 * warm, 0.25 + 0.6 * warm)
                    * (90.0 * (0.4 + rng.next_f32())),
            }
        })
        .collect();
    filled(2, |d| {
        let glow = (-(d.y.abs() * 6.0)).exp() as f32;
        let ground = if d.y < 0.0 { 0.06 } else { 0.012 };
        let base = Vec3::new(0.7, 0.75, 1.0) * ground + Vec3::new(0.1, 0.07, 0.04) * glow;
        lamps.iter().fold(base, |sum, lamp| {
            sum + lamp.radiance * disc(d, lamp.direction, lamp.radius_rad)
        })
    })
}

/// Lamps of a wide place, about 20° apart all around: the mean of any two is dark.
pub fn lamps() -> Image {
    let mut rng = Rng::new(15, 0x6c61_6d70, 0, 0);
    let lamps: Vec<Lamp> = (0..36)
        .map(|i| Lamp {
            direction: towards(
                20.0 * f64::from(i) + 8.0 * rng.next_f64(),
                [12.0, 34.0][i as usize / 18] + 5.0 * rng.next_f64(),
            ),
            radius_rad: 0.012,
            radiance: Vec3::new(1.0, 0.8, 0.5) * (60.0 * (0.5 + rng.next_f32())),
        })
        .collect();
    filled(2, |d| {
        let base = Vec3::new(0.8, 0.9, 1.0) * if d.y < 0.0 { 0.02 } else { 0.005 };
        lamps.iter().fold(base, |sum, lamp| {
            sum + lamp.radiance * disc(d, lamp.direction, lamp.radius_rad)
        })
    })
}

/// Facades of lit windows, and signs.
pub fn city() -> Image {
    let mut rng = Rng::new(12, 0x6369_7479, 0, 0);
    let signs: Vec<(f64, f64, Vec3)> = (0..9)
        .map(|_| {
            let colour = Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32());
            (
                360.0 * rng.next_f64(),
                4.0 + 18.0 * rng.next_f64(),
                colour * colour * 24.0,
            )
        })
        .collect();
    filled(2, |d| {
        let azimuth_deg = d.x.atan2(d.z).to_degrees().rem_euclid(360.0);
        let elevation_deg = d.y.clamp(-1.0, 1.0).asin().to_degrees();
        if elevation_deg < 0.0 {
            return Vec3::new(0.05, 0.05, 0.06) * (1.0 + 0.5 * d.y as f32);
        }
        for (sign_azimuth, sign_elevation, radiance) in &signs {
            let across = (azimuth_deg - sign_azimuth + 540.0).rem_euclid(360.0) - 180.0;
            if across.abs() < 5.0 && (elevation_deg - sign_elevation).abs() < 1.6 {
                return *radiance;
            }
        }
        facade(azimuth_deg, elevation_deg)
    })
}

/// Buildings of 15° width and different heights; a third of their windows is lit.
fn facade(azimuth_deg: f64, elevation_deg: f64) -> Vec3 {
    let building = (azimuth_deg / 15.0) as u64;
    let mut own = Rng::new(13, building, 0, 0);
    let top_deg = 12.0 + 40.0 * own.next_f64();
    if elevation_deg > top_deg {
        return Vec3::new(0.012, 0.014, 0.025);
    }
    let (column, row) = (azimuth_deg / 1.5, elevation_deg / 2.0);
    let mut window = Rng::new(14, column as u64, row as u64, 0);
    let inside = (column.fract() - 0.5).abs() < 0.3 && (row.fract() - 0.5).abs() < 0.32;
    if !inside || window.next_f64() > 0.34 {
        return Vec3::new(0.03, 0.03, 0.035);
    }
    let warm = window.next_f32();
    Vec3::new(1.0, 0.7 + 0.2 * warm, 0.4 + 0.5 * warm) * (2.0 + 6.0 * window.next_f32())
}
