//! What loading a scene found, repaired, dropped and cost.

use super::Needs;

/// What loading found, repaired, dropped and cost.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct BuildReport {
    /// Triangles of all shapes that were kept.
    pub triangles: usize,
    /// Vertices of all shapes.
    pub vertices: usize,
    /// Triangles without area, before or after positions were rounded to f32.
    pub dropped_degenerate: usize,
    /// Triangles with a corner that is infinite or not a number.
    pub dropped_non_finite: usize,
    /// Vertex normals that were no direction and were replaced.
    pub repaired_normals: usize,
    /// Triangles whose winding contradicted all three of their vertex normals.
    pub reoriented: usize,
    /// Shapes, textures and maps whose file is absent.
    pub absent: Vec<String>,
    /// Dropped or approximated features, from the loader and from building.
    pub notes: Vec<String>,
    /// Positions, indices and what is always loaded.
    pub geometry_bytes: usize,
    /// Texels of the textures that were read.
    pub texture_bytes: usize,
    /// The map with its tables for sampling.
    pub environment_bytes: usize,
    /// What each category takes or would take if it were asked for.
    pub cost: CategoryBytes,
}

/// Bytes by what a technique may or may not need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct CategoryBytes {
    /// Positions, indices and the table of shapes: always loaded.
    pub geometry: usize,
    /// Vertex normals.
    pub normals: usize,
    /// Texture coordinates.
    pub uvs: usize,
    /// The table of materials, without textures.
    pub materials: usize,
    /// Texels.
    pub textures: usize,
    /// The map with its tables for sampling; an estimate where it was not loaded.
    pub environment: usize,
}

impl CategoryBytes {
    /// Bytes that a technique with these needs has loaded.
    pub fn of(&self, needs: Needs) -> usize {
        let part = |wanted: bool, bytes: usize| if wanted { bytes } else { 0 };
        self.geometry
            + part(needs.normals, self.normals)
            + part(needs.materials, self.uvs + self.materials)
            + part(needs.textures, self.textures)
            + part(needs.environment, self.environment)
    }
}
