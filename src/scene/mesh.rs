//! An indexed triangle mesh in f64 object space, as loaders and generators hand it over.

use glam::{DVec3, Vec2, Vec3};

/// Triangles with optional vertex attributes. Attribute vectors are empty or parallel to
/// `positions`. Counter-clockwise winding is the front side.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Corners, in the mesh's own coordinates.
    pub positions: Vec<DVec3>,
    /// Unit vectors; a zero vector means "use the geometric normal".
    pub normals: Vec<Vec3>,
    /// Texture coordinates, v upwards.
    pub uvs: Vec<Vec2>,
    /// Linear RGB.
    pub colours: Vec<[f32; 3]>,
    /// Indices of the corners.
    pub triangles: Vec<[u32; 3]>,
}

/// A mesh as a file gives it, and what of the file was left out or replaced.
#[derive(Debug, Default)]
pub(super) struct FileMesh {
    pub mesh: Mesh,
    /// Sentences that name the file.
    pub notes: Vec<String>,
}

impl From<Mesh> for FileMesh {
    fn from(mesh: Mesh) -> Self {
        Self {
            mesh,
            notes: Vec::new(),
        }
    }
}

impl Mesh {
    /// Appends another mesh. Attributes that only one of the two has are padded with zeros,
    /// colours with grey.
    pub fn append(&mut self, other: &Mesh) {
        let base = self.positions.len();
        let pad = |mine: bool, theirs: bool| mine || theirs;
        if pad(!self.normals.is_empty(), !other.normals.is_empty()) {
            self.normals.resize(base, Vec3::ZERO);
            self.normals.extend_from_slice(&other.normals);
            self.normals
                .resize(base + other.positions.len(), Vec3::ZERO);
        }
        if pad(!self.uvs.is_empty(), !other.uvs.is_empty()) {
            self.uvs.resize(base, Vec2::ZERO);
            self.uvs.extend_from_slice(&other.uvs);
            self.uvs.resize(base + other.positions.len(), Vec2::ZERO);
        }
        if pad(!self.colours.is_empty(), !other.colours.is_empty()) {
            self.colours.resize(base, [0.5; 3]);
            self.colours.extend_from_slice(&other.colours);
            self.colours.resize(base + other.positions.len(), [0.5; 3]);
        }
        self.positions.extend_from_slice(&other.positions);
        self.triangles
            .extend(other.triangles.iter().map(|t| t.map(|i| i + base as u32)));
    }
}
