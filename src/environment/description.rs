//! What a scene says of its light from infinity.

use std::path::PathBuf;

use glam::{DMat4, DVec3};

use super::EnvironmentRows;

/// Light from infinity.
#[derive(Clone, Debug)]
pub enum EnvironmentDescription {
    Constant {
        radiance: [f32; 3],
    },
    /// A latitude–longitude map: u = 0.5, v = 0.5 looks along +z, the top row along +y before
    /// `to_world` turns it.
    Map {
        path: PathBuf,
        scale: f32,
        to_world: DMat4,
        rows: EnvironmentRows,
    },
    /// One of [`super::embedded_maps`].
    Embedded {
        name: String,
        scale: f32,
        to_world: DMat4,
    },
    /// Hosek–Wilkie sky with or without the solar disc.
    SunSky {
        /// Unit vector towards the sun, world space.
        sun_direction: DVec3,
        /// Unit vector straight up from the ground, world space.
        zenith: DVec3,
        turbidity: f32,
        albedo: f32,
        sun: bool,
        sky: bool,
        scale: f32,
    },
}
