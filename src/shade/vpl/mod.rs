//! Virtual point lights: light paths turned into a fixed set of small lights (Keller 1997).
//!
//! Paths start at the scene's lights in proportion to their power. The start of a path is a light
//! (direct light), and so is every non-specular surface point it meets (indirect light), which keeps
//! its incident power, its scattering and the direction the light came from, so that glossy surfaces
//! send light on as they do. All powers are divided by the number of *started* paths. That number is
//! fixed by a pilot with other random numbers before the first path is traced, so the set is unbiased;
//! its size comes out near the wanted one, not equal to it.
//!
//! Point, spot and parallel lights are in the set once each, exactly, whatever the number of paths. The
//! environment's lights are directions.
//!
//! The sum over all lights of what a surface point receives is the path tracer's result, but for
//! three things: the denominator of the geometry term is raised to the square of `clamp` × the
//! scene's diagonal, but for the scene's own point and spot lights; light that reaches the point by mirrors or glass alone is absent; radiance
//! inside glass keeps the scale of the index ratio.

mod connect;
mod gather;
mod generate;
#[cfg(test)]
mod tests;

use glam::Vec3;

pub use connect::{Neighbourhood, Receiver};
pub use gather::Gathering;

use super::PathTracer;
use super::surface::Interaction;
use crate::image::luminance;
use crate::scene::PointLight;

/// How many lights, and of what kind.
#[derive(Clone, Copy, Debug)]
pub struct VplOptions {
    /// Wanted number of lights.
    pub count: usize,
    /// Of the light paths.
    pub seed: u64,
    /// Longest path in edges from the light to the camera, as in [`super::PathTracer::radiance`]:
    /// 2 is direct light.
    pub max_depth: u32,
    /// Least distance between a light and a point in the geometry term, in diagonals of the scene.
    pub clamp: f32,
}

/// A set of virtual point lights, sorted so that neighbours in the list are neighbours in space:
/// first those on surfaces, then point and spot lights, then those at infinity.
pub struct VirtualLights<'a> {
    paths_of_scene: &'a PathTracer<'a>,
    lights: Vec<VirtualLight<'a>>,
    /// Positions and normals of the lights on surfaces, eight at a time.
    facing: Vec<Facing>,
    /// Number of lights on surfaces.
    on_surfaces: usize,
    /// Number of lights with a position.
    finite: usize,
    /// Paths that were started.
    pub paths: usize,
    /// Lights left out because their power was not finite.
    pub dropped: usize,
    /// Scene units.
    pub clamp_distance: f32,
    /// Area of a disk that covers the scene.
    disk: f32,
}

/// One light.
#[derive(Clone, Debug)]
struct VirtualLight<'a> {
    /// Of a light at infinity: unused.
    position: Vec3,
    /// `position` moved off its surface.
    end: Vec3,
    /// Geometric normal on the side that shines; of a light at infinity: the direction towards it; of
    /// a point light: unused.
    normal: Vec3,
    emission: Emission<'a>,
}

/// Positions and normals of eight lights on surfaces, by axis; surplus lanes are never faced.
#[derive(Clone, Debug)]
struct Facing {
    position: [[f32; LANES]; 3],
    normal: [[f32; LANES]; 3],
}

/// Lights of a [`Facing`].
const LANES: usize = 8;

/// What a light sends out.
#[derive(Clone, Debug)]
enum Emission<'a> {
    /// `intensity` × the cosine to the light's normal, on the sides of both normals.
    Cosine {
        intensity: Vec3,
        shading_normal: Vec3,
    },
    /// Scattering of `power` that arrived along the interaction's view.
    Glossy {
        /// Apart, so that the list of lights stays small.
        at: Box<Interaction<'a>>,
        power: Vec3,
    },
    /// A point or spot light of the scene.
    Point(&'a PointLight),
    /// Irradiance of a facing surface.
    Infinity { irradiance: Vec3 },
}

impl VirtualLights<'_> {
    /// How many lights there are.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether nothing shines.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// A rough measure of what each light can send out, luminance, above 0.
    pub fn powers(&self) -> Vec<f32> {
        let power = |light: &VirtualLight| {
            let value = match light.emission {
                Emission::Cosine { intensity, .. } => intensity * std::f32::consts::PI,
                Emission::Glossy { power, .. } => power * 0.5,
                Emission::Point(light) => Vec3::from(light.intensity) * light.solid_angle() as f32,
                // On a disk that covers the scene.
                Emission::Infinity { irradiance } => irradiance * self.disk,
            };
            luminance(value.into()).max(f32::MIN_POSITIVE)
        };
        self.lights.iter().map(power).collect()
    }
}
