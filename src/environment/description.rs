//! What a scene says of its light from infinity.

use std::path::PathBuf;

use glam::{DMat4, DVec3};

use super::EnvironmentRows;

/// Light from infinity.
#[derive(Clone, Debug)]
pub enum EnvironmentDescription {
    /// The same from all directions.
    Constant {
        /// Linear RGB.
        radiance: [f32; 3],
    },
    /// A latitude–longitude map: u = 0.5, v = 0.5 looks along +z, the top row along +y before
    /// `to_world` turns it.
    Map {
        /// The image file.
        path: PathBuf,
        /// Factor on its pixels.
        scale: f32,
        /// Rotation from the map's directions to those of the scene; it may mirror.
        to_world: DMat4,
        /// Where its rows lie.
        rows: EnvironmentRows,
    },
    /// One of [`super::embedded_maps`].
    Embedded {
        /// Of the map, as `lightbench list` shows it.
        name: String,
        /// Factor on its pixels.
        scale: f32,
        /// Rotation from the map's directions to those of the scene; it may mirror.
        to_world: DMat4,
    },
    /// Hosek–Wilkie sky with or without the solar disc.
    SunSky {
        /// Unit vector towards the sun, world space.
        sun_direction: DVec3,
        /// Unit vector straight up from the ground, world space.
        zenith: DVec3,
        /// 1 (pure air) to 10 (haze).
        turbidity: f32,
        /// Of the ground, linear RGB in [0, 1].
        albedo: [f32; 3],
        /// Whether the solar disc shines.
        sun: bool,
        /// Of a surface that faces the sun, before the factor; `None` follows from the turbidity.
        sun_irradiance: Option<[f32; 3]>,
        /// How wide its disc is, degrees; `None` as from the earth.
        sun_aperture_deg: Option<f64>,
        /// Whether the sky shines.
        sky: bool,
        /// Factor on the model's radiance.
        scale: f32,
    },
}
