//! Scenes: what they declare ([`SceneDescription`]) and what a technique gets ([`Scene`]).
//!
//! A loader (`scene.toml`, Mitsuba XML, glTF) only fills a description: no mesh or texture is kept for
//! it. [`Scene::build`] then reads what the technique [`Needs`], moves everything to world space
//! around the centre of the bounding box (in f64), and repairs or refuses what is broken.

mod build;
mod build_looks;
mod build_report;
mod check;
mod clip;
mod description;
mod error;
mod extent;
mod files;
mod find;
mod find_environment;
mod geometry;
mod gltf;
mod light;
mod load_toml;
mod material;
mod mesh;
mod mesh_mtl;
mod mesh_obj;
mod mesh_ply;
mod mesh_serialized;
mod mitsuba;
pub mod motion;
mod obj_text;
pub mod path;
mod ply_text;
mod polygon;
mod primitive;
mod readers;
pub mod shapes;
mod spline;
mod text;
mod texture;
mod texture_file;
mod textured_light;
pub mod track;
mod transform;
mod view;

pub use build::{ASSUMED_DIAGONAL_M, Scene, Shape};
pub use build_report::{BuildReport, CategoryBytes};
pub use check::{CheckedPath, CheckedView, SceneCheck, check_scene};
pub use clip::Clip;
pub use description::{
    Alpha, LightDescription, LightKind, SceneDescription, ShapeDescription, ShapeSource,
    TextureDescription, TextureSource,
};
pub use error::SceneError;
pub use find::{find_scene, find_scene_in, shipped_scenes};
pub use find_environment::{find_environment, find_environment_in};
pub use gltf::GltfFile;
pub use light::{Cone, PointLight};
pub use material::{Blend, Bsdf, ColourSource, Material, MicrofacetDistribution, Roughness};
pub use mesh::Mesh;
pub(crate) use readers::{READERS, Reader};
pub use texture::{Texture, Wrap};
pub use view::{FovAxis, View};

/// What a technique reads of a scene besides its triangles; nothing else is loaded or built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// Vertex normals (absent ones fall back to the geometric normal).
    pub normals: bool,
    /// Materials and, through them, texture coordinates.
    pub materials: bool,
    /// Texture images; without them a textured value is its mean colour as declared, or 0.5.
    pub textures: bool,
    /// Emitting shapes, point, spot and directional lights.
    pub emitters: bool,
    /// The environment map.
    pub environment: bool,
}

impl Needs {
    /// Positions and triangles alone.
    pub const POSITIONS: Needs = Needs {
        normals: false,
        ..Self::GEOMETRY
    };

    /// Geometry with shading normals: what ambient occlusion needs.
    pub const GEOMETRY: Needs = Needs {
        normals: true,
        materials: false,
        textures: false,
        emitters: false,
        environment: false,
    };

    /// Everything: what the path-traced truths need.
    pub const ALL: Needs = Needs {
        normals: true,
        materials: true,
        textures: true,
        emitters: true,
        environment: true,
    };
}
