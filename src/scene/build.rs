//! From a description to triangles in f32 around the origin.

use glam::{DVec3, Vec2, Vec3};

use super::{Material, Needs, SceneDescription, SceneError, Texture, View};
use crate::environment::Environment;

/// A loaded scene: world-space triangles around the centre of the bounding box, and what the
/// technique asked for. Attribute vectors that were not needed are empty.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub name: String,
    pub positions: Vec<Vec3>,
    /// Parallel to `positions` or empty; zero means "use the geometric normal".
    pub normals: Vec<Vec3>,
    /// Parallel to `positions` or empty.
    pub uvs: Vec<Vec2>,
    /// Vertex indices, all triangles finite and of positive area.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `shapes`, parallel to `triangles`.
    pub triangle_shape: Vec<u32>,
    pub shapes: Vec<Shape>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    /// Directions in which parallel light travels, with the irradiance of a facing surface.
    pub directional_lights: Vec<(Vec3, [f32; 3])>,
    pub environment: Option<Environment>,
    /// Views with origins moved like the geometry.
    pub views: Vec<View>,
    /// Diagonal of the bounding box of all triangles, scene units.
    pub diagonal: f32,
    /// What was subtracted from all positions.
    pub origin: DVec3,
    pub metres_per_unit: f64,
    /// Scene units.
    pub ao_distance: f32,
    pub exposure: f32,
    pub max_depth: u32,
    pub report: BuildReport,
}

/// A shape after loading.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    pub name: String,
    pub material: u32,
    pub emission: Option<[f32; 3]>,
    pub first_triangle: u32,
    pub triangle_count: u32,
}

/// What loading found, repaired, dropped and cost.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct BuildReport {
    pub triangles: usize,
    pub vertices: usize,
    pub dropped_degenerate: usize,
    pub dropped_non_finite: usize,
    pub repaired_normals: usize,
    /// Shapes whose file is absent or unreadable, with the reason.
    pub absent: Vec<String>,
    /// Dropped or approximated features, from the loader and from building.
    pub notes: Vec<String>,
    pub geometry_bytes: usize,
    pub texture_bytes: usize,
    pub environment_bytes: usize,
}

impl Scene {
    /// Reads what `needs` asks for. Absent mesh or texture files are reported and left out (the
    /// texture becomes reflectance 0.5); a file that exists but is damaged is an error.
    pub fn build(description: &SceneDescription, needs: Needs) -> Result<Scene, SceneError> {
        let _ = (description, needs);
        Ok(Scene::default())
    }
}
