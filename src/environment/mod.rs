//! Light from infinity: maps, skies and (later) their samplers.

mod map;
mod sky;
mod table;

pub use map::{Environment, EnvironmentOptions, EnvironmentRows, EnvironmentSample, Sanitised};
pub use sky::{SunSky, sun_sky_image};

use std::path::PathBuf;

/// Why there is no environment.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentError {
    #[error("{}: {message}", path.display())]
    Read { path: PathBuf, message: String },
    #[error("an environment map needs at least one pixel, this one has {width}×{height}")]
    Empty { width: usize, height: usize },
    #[error(
        "the environment's to_world must be a rotation (mirrored or uniformly scaled at most): {matrix}"
    )]
    NotARotation { matrix: String },
    #[error("{message}")]
    Sky { message: String },
}
