//! Scattering, direct light and path tracing: the truths.
//!
//! [`PathTracer`] estimates radiance along a ray, [`render`] makes images of it.

pub mod bsdf;
mod film;
mod light;
mod masks;
mod path;
mod surface;
mod vpl;
mod walk;

pub use film::{NonFinite, RenderOptions, Rendering, render};
pub use light::{
    Arriving, ChosenPlace, Emitted, EvenLights, LIGHT_GROUPS, LightPlace, LightSample, LightTile,
    Lights, Sent, SharedTiles, Source, TilePart, Unshadowed, Way,
};
pub use path::{DIRECT_LIGHTING, Depths, PathTracer};
pub use surface::{Interaction, Surfaces};
pub use vpl::{Gathering, Neighbourhood, Receiver, VirtualLights, VplOptions};
pub use walk::{Leg, Lit, Lobes, Met, Scattered, Vertex};
