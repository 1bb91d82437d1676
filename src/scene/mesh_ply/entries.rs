//! Entries of the elements of a PLY file, filled by their properties.

use glam::{DVec3, Vec2, Vec3};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

/// A vertex, as its properties are read.
#[derive(Default)]
pub(super) struct Vertex {
    pub position: DVec3,
    pub normal: Vec3,
    pub uv: Vec2,
    pub colour: [f32; 3],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(value) = number(&property) else {
            return PropertyAccessResult::Ignored;
        };
        match name {
            "x" => self.position.x = value,
            "y" => self.position.y = value,
            "z" => self.position.z = value,
            "nx" => self.normal.x = value as f32,
            "ny" => self.normal.y = value as f32,
            "nz" => self.normal.z = value as f32,
            "u" | "s" | "texture_u" => self.uv.x = value as f32,
            "v" | "t" | "texture_v" => self.uv.y = value as f32,
            "red" | "r" => self.colour[0] = value as f32 / full(&property),
            "green" | "g" => self.colour[1] = value as f32 / full(&property),
            "blue" | "b" => self.colour[2] = value as f32 / full(&property),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// What stands for 1 in a channel of this type.
fn full(property: &Property) -> f32 {
    match property {
        Property::UChar(_) => 255.0,
        Property::UShort(_) => 65_535.0,
        _ => 1.0,
    }
}

fn number(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(x) => x.into(),
        Property::UChar(x) => x.into(),
        Property::Short(x) => x.into(),
        Property::UShort(x) => x.into(),
        Property::Int(x) => x.into(),
        Property::UInt(x) => x.into(),
        Property::Float(x) => x.into(),
        Property::Double(x) => x,
        _ => return None,
    })
}

/// A face, as its properties are read.
#[derive(Default)]
pub(super) struct Face {
    /// Indices of vertices, as the file has them.
    pub corners: Vec<i64>,
    /// Texture coordinates of its corners, u and v in turn, or empty.
    pub uvs: Vec<f32>,
    /// Which of the textures of the file it has.
    pub picture: Option<i64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "vertex_indices" | "vertex_index" => match whole_numbers(property) {
                Some(corners) => self.corners = corners,
                None => return PropertyAccessResult::UnsupportedType,
            },
            "texcoord" => match property {
                Property::ListFloat(uvs) => self.uvs = uvs,
                Property::ListDouble(uvs) => self.uvs = uvs.iter().map(|&x| x as f32).collect(),
                _ => return PropertyAccessResult::UnsupportedType,
            },
            "texnumber" => self.picture = number(&property).map(|n| n as i64),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// Vertices of triangles that share edges, and −1 between strips.
#[derive(Default)]
pub(super) struct Strip(pub Vec<i64>);

impl PropertyAccess for Strip {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        match whole_numbers(property) {
            Some(list) => self.0 = list,
            None => return PropertyAccessResult::UnsupportedType,
        }
        PropertyAccessResult::Set
    }
}

/// A list of whole numbers, of whatever type.
fn whole_numbers(property: Property) -> Option<Vec<i64>> {
    Some(match property {
        Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
        Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
        Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
        unsigned => unsigned.to_u32_list()?.into_iter().map(i64::from).collect(),
    })
}

/// An element that does not matter here.
pub(super) struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Skipped
    }
}
