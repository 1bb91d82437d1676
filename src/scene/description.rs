//! What a scene file declares, before any mesh, texture or map is read.

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::{DMat4, DVec3};

use super::clip::Clip;
use super::motion::MotionDescription;
use super::path::CameraPath;
use super::{GltfFile, Material, View, Wrap};
use crate::environment::EnvironmentDescription;

/// A parsed scene. Lengths are in scene units, right-handed, y up; colours are linear Rec.709.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// The name that rows and result folders carry.
    pub name: String,
    /// One line for people: what is seen and what it provokes.
    pub title: String,
    /// The file it came from, for messages and content keys (`None` when embedded).
    pub file: Option<PathBuf>,
    /// Length of a scene unit in metres (formulas of the papers that are in metres use it); `None`
    /// where nothing says it, as in Mitsuba files: see [`super::ASSUMED_DIAGONAL_M`].
    pub metres_per_unit: Option<f64>,
    /// Maximum length of ambient-occlusion rays in scene units; `None` means 0.1 × the diagonal of
    /// the bounding box.
    pub ao_distance: Option<f64>,
    /// Factor from radiance to display-referred linear values.
    pub exposure: f32,
    /// Path edges after the camera: 1 emission only, 2 direct light, 3 one indirect bounce.
    pub max_depth: u32,
    /// Whether path tracing keeps what shines out of the camera's sight (Mitsuba's `hide_emitters`).
    pub hides_lights: bool,
    /// Cameras by name; the first one is the default.
    pub views: Vec<View>,
    /// What the cameras of other programs would cut away.
    pub clips: Vec<Clip>,
    /// Everything with triangles, emitters of light included.
    pub shapes: Vec<ShapeDescription>,
    /// Index 0 is used by shapes that name no material.
    pub materials: Vec<Material>,
    /// Material libraries that cannot be read, of which faces use materials; a grey stands for these.
    pub absent_libraries: Vec<PathBuf>,
    /// What materials, emission and opacity masks look up; named by index.
    pub textures: Vec<TextureDescription>,
    /// Lights without extent.
    pub lights: Vec<LightDescription>,
    /// Camera paths by name.
    pub paths: Vec<CameraPath>,
    /// What moves; of the same thing the first one listed is applied first.
    pub motions: Vec<MotionDescription>,
    /// Light from infinity; `None` is black.
    pub environment: Option<EnvironmentDescription>,
    /// What the loader dropped or approximated, a sentence each.
    pub notes: Vec<String>,
}

/// One shape of a scene.
#[derive(Clone, Debug)]
pub struct ShapeDescription {
    /// What messages and motions call it; shapes may share a name.
    pub name: String,
    /// What motions call it, where one object of a file became several shapes.
    pub object: Option<String>,
    /// Where its triangles come from.
    pub source: ShapeSource,
    /// From the coordinates of the source to those of the scene file.
    pub to_world: DMat4,
    /// Index into [`SceneDescription::materials`].
    pub material: usize,
    /// Emitted radiance (W/(m² sr), linear RGB) on the side of the geometric normal.
    pub emission: Option<[f32; 3]>,
    /// Texture whose colours, times the emission, are emitted: index into [`SceneDescription::textures`].
    pub emission_texture: Option<usize>,
    /// Turns the winding, and so the emitting side, round.
    pub flip_normals: bool,
    /// The same, but only where there are no vertex normals: mirrors turn such faces in Mitsuba, whose winding is that
    /// of the transformed corners.
    pub turn_bare: bool,
    /// Ignores vertex normals.
    pub face_normals: bool,
    /// Computes vertex normals where the file has none, as Mitsuba does; otherwise such a mesh is
    /// faceted.
    pub smooth_normals: bool,
    /// Replaces v by 1 − v: for sources that count v from the top row of the image.
    pub flip_v: bool,
}

impl ShapeDescription {
    /// A shape as its source gives it: no transform, first material, no emission.
    pub fn new(name: &str, source: ShapeSource) -> Self {
        Self {
            name: name.to_owned(),
            object: None,
            source,
            to_world: DMat4::IDENTITY,
            material: 0,
            emission: None,
            emission_texture: None,
            flip_normals: false,
            turn_bare: false,
            face_normals: false,
            smooth_normals: false,
            flip_v: false,
        }
    }

    /// The name of the object that it is, or is part of.
    pub fn object(&self) -> &str {
        self.object.as_deref().unwrap_or(&self.name)
    }
}

/// Where the triangles of a shape come from.
#[derive(Clone, Debug)]
pub enum ShapeSource {
    /// A Wavefront OBJ file; `part` selects one object or group by name, or, as `usemtl NAME`, the
    /// faces of one material.
    Obj {
        /// The file.
        path: PathBuf,
        /// `None` takes all of the file.
        part: Option<String>,
        /// Of these faces those of one material by name; `None` takes them all.
        material: Option<String>,
    },
    /// A Stanford PLY file.
    Ply {
        /// The file.
        path: PathBuf,
    },
    /// Mitsuba's compressed binary mesh; a file holds several.
    Serialized {
        /// The file.
        path: PathBuf,
        /// Number of the mesh in the file, from 0.
        index: usize,
    },
    /// One primitive of a mesh of a glTF file, with one of its sets of texture coordinates.
    Gltf {
        /// The document with its buffers.
        file: GltfFile,
        /// Number of the mesh in the document, from 0.
        mesh: usize,
        /// Number of the primitive in the mesh, from 0.
        primitive: usize,
        /// The `n` of `TEXCOORD_n`.
        uv_set: u32,
    },
    /// `[-1,1]²` in the xy plane, normal +z.
    Rectangle,
    /// `[-1,1]³`.
    Cube,
    /// Analytic spheres are tessellated with smooth normals.
    Sphere {
        /// Before `to_world`.
        centre: DVec3,
        /// Before `to_world`.
        radius: f64,
    },
    /// Unit disk in the xy plane, normal +z.
    Disk,
    /// Open at both ends, outward normals.
    Cylinder {
        /// Centre of one end, before `to_world`.
        from: DVec3,
        /// Centre of the other end, before `to_world`.
        to: DVec3,
        /// Before `to_world`.
        radius: f64,
    },
    /// A shape generated in code: see [`crate::scene::shapes`].
    Generated {
        /// Its name in the table of generators.
        generator: String,
        /// One named part of the generator's output (its materials differ by part).
        part: Option<String>,
        /// Values by name; those that are left out have the generator's defaults.
        parameters: BTreeMap<String, f64>,
    },
}

/// A texture and how it is read.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureDescription {
    /// Where its texels come from.
    pub source: TextureSource,
    /// Whether the stored values are sRGB-coded (8-bit colour) or linear (raw data, HDR).
    pub srgb: bool,
    /// Whether the nearest texel is taken, rather than the four around bilinearly.
    pub nearest: bool,
    /// What lies outside the unit square.
    pub wrap: Wrap,
    /// `uv * scale`, sheared, turned, `+ offset` is looked up.
    pub uv_scale: [f32; 2],
    /// How much of v is added to u.
    pub uv_shear: f32,
    /// From u to v, radians.
    pub uv_turn_rad: f32,
    /// Added last: see `uv_scale`.
    pub uv_offset: [f32; 2],
    /// On the colours looked up.
    pub factor: [f32; 3],
    /// Added to the colours after the factor; then they are clamped to [0, 1]. `None`: neither.
    pub base: Option<[f32; 3]>,
    /// Gives the alpha channel (1 where the file has none) instead of the colours.
    pub alpha: Option<Alpha>,
}

/// What is made of an alpha channel.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Alpha {
    /// On the values of the channel, before the cutoff.
    pub factor: f32,
    /// At least this much is 1, less is 0; without a cutoff alpha stays as it is.
    pub cutoff: Option<f32>,
}

impl Alpha {
    /// Opacity of a value of the channel.
    pub fn of(&self, value: f32) -> f32 {
        let alpha = value * self.factor;
        match self.cutoff {
            Some(cutoff) => f32::from(u8::from(alpha >= cutoff)),
            None => alpha,
        }
    }
}

/// Where texels come from.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureSource {
    /// An image file, of any format that is read.
    File(PathBuf),
    /// An image inside a glTF file: in a buffer or a data URI.
    Gltf {
        /// The document with its buffers.
        file: GltfFile,
        /// Number of the image in the document, from 0.
        image: usize,
    },
    /// Two colours (linear) in a 2×2 pattern over the unit square; the first one is at the top left.
    Checkerboard([[f32; 3]; 2]),
}

impl TextureDescription {
    /// A file read as its type suggests: sRGB for 8-bit images, linear for `.hdr`, `.exr`, `.pfm`.
    pub fn file(path: PathBuf) -> Self {
        let file = crate::image::file_of(&path);
        let extension = file.extension().map(|e| e.to_ascii_lowercase());
        let hdr = extension.is_some_and(|e| e == "hdr" || e == "exr" || e == "pfm");
        Self {
            source: TextureSource::File(path),
            srgb: !hdr,
            nearest: false,
            wrap: Wrap::Repeat,
            uv_scale: [1.0; 2],
            uv_shear: 0.0,
            uv_turn_rad: 0.0,
            uv_offset: [0.0; 2],
            factor: [1.0; 3],
            base: None,
            alpha: None,
        }
    }

    /// The file, if it is one.
    pub fn path(&self) -> Option<&std::path::Path> {
        match &self.source {
            TextureSource::File(path) => Some(path),
            TextureSource::Gltf { file, .. } => Some(file.path()),
            TextureSource::Checkerboard(_) => None,
        }
    }
}

/// A light without extent.
#[derive(Clone, Debug, serde::Serialize)]
#[serde(transparent)]
pub struct LightDescription {
    /// What motions call it; empty where it has none.
    #[serde(skip)]
    pub name: String,
    /// Where it is, and how it shines.
    pub kind: LightKind,
}

/// Where a light without extent is and how it shines. Positions and directions are in world space, colours
/// linear Rec.709.
#[derive(Clone, Debug, serde::Serialize)]
pub enum LightKind {
    /// Parallel light from infinity.
    Directional {
        /// In which it travels.
        direction: DVec3,
        /// Of a surface that faces it, W/m².
        irradiance: [f32; 3],
    },
    /// A point that shines evenly in all directions.
    Point {
        /// Where it is, scene units.
        position: DVec3,
        /// Radiant intensity, W/sr: a facing surface at a distance d, in scene units, receives
        /// intensity / d².
        intensity: [f32; 3],
    },
    /// A point that shines around a direction: with all its intensity up to `beam_width_deg` from it,
    /// then falling linearly with the angle to zero at `cutoff_deg`.
    Spot {
        /// Where it is, scene units.
        position: DVec3,
        /// From the light into the middle of its beam.
        direction: DVec3,
        /// Radiant intensity in the middle of the beam, W/sr.
        intensity: [f32; 3],
        /// At most `cutoff_deg`.
        beam_width_deg: f64,
        /// At most 180.
        cutoff_deg: f64,
    },
}

impl From<LightKind> for LightDescription {
    /// A light without a name.
    fn from(kind: LightKind) -> Self {
        let name = String::new();
        Self { name, kind }
    }
}

impl LightKind {
    /// The irradiance or intensity.
    pub fn strength(&self) -> &[f32; 3] {
        match self {
            Self::Directional { irradiance, .. } => irradiance,
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => intensity,
        }
    }
}
