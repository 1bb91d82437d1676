//! Scattering, direct light and path tracing: the truths.
//!
//! [`PathTracer`] estimates radiance along a ray, [`render`] makes images of it.

pub mod bsdf;
mod film;
mod light;
mod path;
mod surface;

pub use film::{NonFinite, RenderOptions, Rendering, render};
pub use light::{LightSample, Lights};
pub use path::{DIRECT_LIGHTING, Depths, PathTracer};
pub use surface::{Interaction, Surfaces};
