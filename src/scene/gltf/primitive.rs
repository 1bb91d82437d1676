//! One primitive of a mesh: vertices and triangles.

use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::{DVec3, Vec2, Vec3};

use super::accessor::Accessors;
use super::document::{GltfFile, named, valid};
use super::material::has_colour_texture;
use crate::scene::{Mesh, SceneError};

/// The attributes of a primitive that a mesh has.
pub(super) fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<usize> {
    let accessor = primitive.attributes.get(&Checked::Valid(semantic));
    accessor.map(|index| index.value())
}

/// Whether a primitive has triangles, as opposed to points and lines; an unknown mode is `None`.
pub(super) fn has_triangles(primitive: &Primitive) -> Option<bool> {
    let with = [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan];
    valid(&primitive.mode).map(|mode| with.contains(&mode))
}

impl GltfFile {
    /// The triangles of a primitive, with its texture coordinates of set `uv_set`, all (0, 0) where it has a texture
    /// and no coordinates; v counts from the top row of the image. Everything is checked: accessors, counts, indices, and that positions are finite.
    pub(crate) fn mesh(
        &self,
        [mesh, primitive]: [usize; 2],
        uv_set: u32,
    ) -> Result<Mesh, SceneError> {
        let buffers = self.buffers()?;
        let accessors = Accessors {
            file: self,
            buffers: &buffers,
        };
        let declared = self.root().meshes.get(mesh);
        let place = named("mesh", mesh, declared.and_then(|m| m.name.as_deref()));
        let place = format!("{place}, primitive {primitive}");
        let Some(declared) = declared.and_then(|m| m.primitives.get(primitive)) else {
            return Err(self.error(place, "is not there"));
        };
        let reader = Reader {
            accessors,
            declared,
            place,
        };
        let mesh = reader.vertices(uv_set)?;
        reader.triangles(mesh)
    }
}

struct Reader<'a> {
    accessors: Accessors<'a>,
    declared: &'a Primitive,
    place: String,
}

impl Reader<'_> {
    fn error(&self, message: impl std::fmt::Display) -> SceneError {
        self.accessors.file.error(&self.place, message)
    }

    fn vertices(&self, uv_set: u32) -> Result<Mesh, SceneError> {
        let positions = self.read::<3>(Semantic::Positions, "POSITION", None)?;
        let count = Some(positions.len());
        if let Some(at) = positions
            .iter()
            .position(|p| !p.iter().all(|c| c.is_finite()))
        {
            let accessor = attribute(self.declared, Semantic::Positions).unwrap_or(0);
            return Err(self.error(format!(
                "POSITION {at} of accessor {accessor} is not finite"
            )));
        }
        let normals = self.read::<3>(Semantic::Normals, "NORMAL", count)?;
        let name = format!("TEXCOORD_{uv_set}");
        if let Some(index) = attribute(self.declared, Semantic::TexCoords(uv_set))
            && self.accessors.is_out_of_scale(index)
        {
            return Err(self.error(format!(
                "{name} (accessor {index}) holds whole numbers that are not normalised: \
                 only KHR_mesh_quantization allows that"
            )));
        }
        let mut uvs = self.read::<2>(Semantic::TexCoords(uv_set), &name, count)?;
        if uvs.is_empty() && self.has_colour_texture() {
            uvs = vec![[0.0; 2]; positions.len()];
        }
        Ok(Mesh {
            positions: positions
                .into_iter()
                .map(|p| DVec3::from(p.map(f64::from)))
                .collect(),
            normals: normals.into_iter().map(Vec3::from).collect(),
            uvs: uvs.into_iter().map(Vec2::from).collect(),
            colours: Vec::new(),
            triangles: Vec::new(),
        })
    }

    fn has_colour_texture(&self) -> bool {
        let materials = &self.accessors.file.root().materials;
        let material = self
            .declared
            .material
            .and_then(|m| materials.get(m.value()));
        material.is_some_and(has_colour_texture)
    }

    /// An attribute, none if the primitive has it not.
    fn read<const N: usize>(
        &self,
        semantic: Semantic,
        name: &str,
        count: Option<usize>,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let Some(index) = attribute(self.declared, semantic) else {
            return match count {
                None => Err(self.error(format!("has no {name}"))),
                Some(_) => Ok(Vec::new()),
            };
        };
        let values = self.accessors.vectors(index)?;
        match count {
            Some(count) if count != values.len() => Err(self.error(format!(
                "{name} (accessor {index}) has {} elements, POSITION {count}",
                values.len()
            ))),
            _ => Ok(values),
        }
    }

    fn triangles(&self, mut mesh: Mesh) -> Result<Mesh, SceneError> {
        let count = mesh.positions.len();
        let corners = match self.declared.indices {
            Some(index) => {
                let indices = self.accessors.indices(index.value())?;
                if let Some(at) = indices.iter().position(|&i| i as usize >= count) {
                    return Err(self.error(format!(
                        "index {at} of accessor {} is vertex {}, there are {count}",
                        index.value(),
                        indices[at]
                    )));
                }
                indices
            }
            None => match u32::try_from(count) {
                Ok(count) => (0..count).collect(),
                Err(_) => return Err(self.error("has more than 2³² vertices")),
            },
        };
        mesh.triangles = match valid(&self.declared.mode) {
            Some(Mode::Triangles) => corners
                .chunks_exact(3)
                .map(|c| [c[0], c[1], c[2]])
                .collect(),
            Some(Mode::TriangleStrip) => strip(&corners),
            Some(Mode::TriangleFan) => fan(&corners),
            _ => return Err(self.error("has no triangles")),
        };
        Ok(mesh)
    }
}

/// Every vertex makes a triangle with the two before it; every other one is turned.
fn strip(corners: &[u32]) -> Vec<[u32; 3]> {
    let windows = corners.windows(3).enumerate();
    let turned = |(i, c): (usize, &[u32])| match i % 2 {
        0 => [c[0], c[1], c[2]],
        _ => [c[0], c[2], c[1]],
    };
    windows.map(turned).collect()
}

/// Every edge after the first vertex makes a triangle with it.
fn fan(corners: &[u32]) -> Vec<[u32; 3]> {
    let edges = corners.get(1..).unwrap_or_default().windows(2);
    edges.map(|edge| [edge[0], edge[1], corners[0]]).collect()
}
