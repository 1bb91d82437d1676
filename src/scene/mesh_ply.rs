//! Stanford PLY through `ply-rs-bw`, ascii and binary.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::mesh::FileMesh;
use super::ply_text::{plain_ply, plainly};
use super::polygon::triangles_of;
use super::text::file_error;
use super::{Mesh, SceneError};

/// Loads the vertices, faces and triangle strips of a PLY file; polygons become triangles.
///
/// Normals (`nx ny nz`) and texture coordinates (`u v`, `s t`, `texture_u texture_v`, or the list `texcoord` of faces, which
/// comes first) are optional. Damage is reported with the line (ascii) or the byte offset (binary).
pub(super) fn load_ply(path: &Path) -> Result<FileMesh, SceneError> {
    let bytes = std::fs::read(path).map_err(|e| file_error(path, e.to_string()))?;
    parse_ply(&bytes, path)
}

/// [`load_ply`] of the bytes of a file; messages name `path`.
pub(super) fn parse_ply(bytes: &[u8], path: &Path) -> Result<FileMesh, SceneError> {
    let bytes = plain_ply(bytes);
    let mut reader = Reader::new(Cursor::new(bytes.as_ref()));
    let header = Parser::<Vertex>::new()
        .read_header(&mut reader)
        .map_err(|e| located(path, &e, None))?;
    let mut file = PlyFile {
        header: &header,
        path,
        read: FileMesh::default(),
        faces: None,
    };
    for (name, element) in &header.elements {
        file.check(name, element, bytes.len())?;
        file.element(&mut reader, name, element)?;
    }
    let read = reader.get_ref().position() as usize;
    file.note_trailing(bytes.get(read..).unwrap_or(&[]));
    file.finish()
}

/// A file that is being read.
struct PlyFile<'a> {
    header: &'a Header,
    path: &'a Path,
    read: FileMesh,
    /// Those of faces, then of strips; none before either was met.
    faces: Option<Vec<Face>>,
}

type Bytes<'a> = Reader<Cursor<&'a [u8]>>;

impl PlyFile<'_> {
    fn check(&self, name: &str, element: &ElementDef, bytes: usize) -> Result<(), SceneError> {
        let (count, most) = (element.count as u64, bytes as u64);
        let message = if count > 0 && element.properties.is_empty() {
            format!("element `{name}` has entries and no properties")
        } else if count > most {
            format!("{count} entries of `{name}` are promised in {most} bytes")
        } else {
            let lacks = |axis: &&&str| !element.properties.contains_key(**axis);
            match ["x", "y", "z"].iter().find(lacks) {
                Some(axis) if name == "vertex" => {
                    format!("element `vertex` has no property `{axis}`")
                }
                _ => return Ok(()),
            }
        };
        Err(file_error(self.path, message))
    }

    fn element(
        &mut self,
        reader: &mut Bytes,
        name: &str,
        element: &ElementDef,
    ) -> Result<(), SceneError> {
        match name {
            "vertex" => {
                let vertices: Vec<Vertex> = self.entries(reader, element)?;
                add_vertices(&mut self.read.mesh, &vertices, element);
                if let Some(odd) = odd_colour(element) {
                    let path = self.path.display();
                    let note = format!(
                        "{path}: colours of vertices of type {odd} are left out: they are read of uchar, ushort, float and double"
                    );
                    self.read.notes.push(note);
                }
            }
            "face" => {
                let faces = self.entries(reader, element)?;
                self.faces.get_or_insert_default().extend(faces);
            }
            "tristrips" => {
                let strips: Vec<Strip> = self.entries(reader, element)?;
                let triangles = strips.iter().flat_map(|strip| triangles_of_strip(&strip.0));
                self.faces.get_or_insert_default().extend(triangles);
            }
            _ => {
                self.entries::<Skipped>(reader, element)?;
                if element.count > 0 {
                    let (path, count) = (self.path.display(), element.count);
                    let note = format!("{path}: element `{name}` is left out, {count} entries");
                    self.read.notes.push(note);
                }
            }
        }
        Ok(())
    }

    fn entries<E: PropertyAccess>(
        &self,
        reader: &mut Bytes,
        element: &ElementDef,
    ) -> Result<Vec<E>, SceneError> {
        let read = Parser::<E>::new().read_payload_for_element(reader, element, self.header);
        let binary = self.header.encoding != Encoding::Ascii;
        let offset = binary.then(|| reader.get_ref().position());
        read.map_err(|e| located(self.path, &e, offset))
    }

    /// Says what stands behind the last element that the header declares.
    fn note_trailing(&mut self, rest: &[u8]) {
        let end = rest.trim_ascii_end().len();
        if end > 0 {
            let path = self.path.display();
            let note = format!("{path}: {end} bytes behind the last element are left out");
            self.read.notes.push(note);
        }
    }

    fn finish(mut self) -> Result<FileMesh, SceneError> {
        let error = |message: &str| file_error(self.path, message);
        let faces = self.faces.as_ref();
        let faces = faces.ok_or_else(|| error("no `face` element; is it a point cloud?"))?;
        let pictures = faces.iter().filter_map(|face| face.picture);
        let first = pictures.clone().next();
        if pictures.clone().any(|picture| Some(picture) != first) {
            let path = self.path.display();
            let note = format!("{path}: faces of several textures (`texnumber`) get the same one");
            self.read.notes.push(note);
        }
        add_faces(&mut self.read.mesh, faces).map_err(|message| error(&message))?;
        if faces.iter().any(|face| !face.uvs.is_empty()) {
            split_at_seams(&mut self.read.mesh, faces);
        }
        Ok(self.read)
    }
}

fn located(path: &Path, error: &ParseError, offset: Option<u64>) -> SceneError {
    let text = error.to_string();
    let message = text.split_once(": ").filter(|_| error.line().is_some());
    let message = message.map_or(text.as_str(), |(_, rest)| rest);
    let message = plainly(message);
    match (offset, error.line()) {
        (None, Some(line)) => SceneError::At {
            file: path.to_owned(),
            line,
            column: 1,
            message,
        },
        (None, None) => file_error(path, message),
        (Some(offset), _) => file_error(path, format!("byte offset {offset}: {message}")),
    }
}

fn add_vertices(mesh: &mut Mesh, vertices: &[Vertex], element: &ElementDef) {
    let has = |name: &str| element.properties.contains_key(name);
    mesh.positions = vertices.iter().map(|v| v.position).collect();
    if has("nx") {
        mesh.normals = vertices.iter().map(|v| v.normal).collect();
    }
    if UV_NAMES.iter().any(|name| has(name)) {
        mesh.uvs = vertices.iter().map(|v| v.uv).collect();
    }
    let mut colours = COLOUR_NAMES.iter();
    let has_colours = colours.any(|names| names.iter().all(|name| has(name)));
    if has_colours && odd_colour(element).is_none() {
        mesh.colours = vertices.iter().map(|v| v.colour).collect();
    }
}

/// The type of a channel of a colour for which nothing says what stands for 1.
fn odd_colour(element: &ElementDef) -> Option<&'static str> {
    let names = COLOUR_NAMES.iter().flatten();
    let mut channels = names.filter_map(|name| element.properties.get(*name));
    channels.find_map(|channel| match &channel.data_type {
        PropertyType::Scalar(kind) => match kind {
            ScalarType::Char => Some("char"),
            ScalarType::Short => Some("short"),
            ScalarType::Int => Some("int"),
            ScalarType::UInt => Some("uint"),
            ScalarType::UChar | ScalarType::UShort | ScalarType::Float | ScalarType::Double => None,
        },
        PropertyType::List(..) => Some("list"),
    })
}

fn add_faces(mesh: &mut Mesh, faces: &[Face]) -> Result<(), String> {
    let count = mesh.positions.len();
    for (number, face) in faces.iter().enumerate() {
        let Some(corners) = face.corners.as_deref().filter(|c| c.len() >= 3) else {
            return Err(format!(
                "face {number} (from 0) has fewer than three vertices"
            ));
        };
        if let Some(bad) = corners.iter().find(|&&i| i as usize >= count) {
            return Err(format!(
                "face {number} (from 0) names vertex {bad}, the file has {count}"
            ));
        }
        let coordinates = face.uvs.len();
        if coordinates != 0 && coordinates != 2 * corners.len() {
            return Err(format!(
                "face {number} (from 0) has {coordinates} texture coordinates for {} vertices",
                corners.len()
            ));
        }
        let triangles = triangles_of_face(mesh, corners);
        mesh.triangles
            .extend(triangles.iter().map(|t| t.map(|i| corners[i])));
    }
    match mesh.triangles.is_empty() {
        true => Err("the file has no faces; is it truncated?".into()),
        false => Ok(()),
    }
}

/// Triangles of a face, as places in its corners.
fn triangles_of_face(mesh: &Mesh, corners: &[u32]) -> Vec<[usize; 3]> {
    if let [_, _, _] = corners {
        return vec![[0, 1, 2]];
    }
    let corners = corners.iter().map(|&i| mesh.positions[i as usize]);
    triangles_of(&corners.collect::<Vec<_>>())
}

/// Triangles of a strip: every vertex makes one with the two before it, every other one is turned, and −1 begins anew.
fn triangles_of_strip(strip: &[i64]) -> impl Iterator<Item = Face> {
    let runs = strip.split(|&i| i < 0);
    let windows = runs.flat_map(|run| run.windows(3).enumerate());
    windows.map(|(i, c)| {
        let corners = if i % 2 == 0 {
            [c[0], c[1], c[2]]
        } else {
            [c[1], c[0], c[2]]
        };
        Face {
            // An index beyond 32 bits is none of a vertex.
            corners: Some(
                corners
                    .map(|i| u32::try_from(i).unwrap_or(u32::MAX))
                    .to_vec(),
            ),
            ..Face::default()
        }
    })
}

/// Gives every corner the texture coordinates of its face: vertices that have several are repeated.
fn split_at_seams(mesh: &mut Mesh, faces: &[Face]) {
    let whole = std::mem::take(mesh);
    let mut known = HashMap::new();
    for face in faces {
        let corners = face.corners.as_deref().unwrap_or_default();
        let split: Vec<u32> = (0..corners.len())
            .map(|i| {
                let uv = face.uvs.get(2 * i..2 * i + 2);
                let uv = uv.map_or(Vec2::ZERO, Vec2::from_slice);
                let key = (corners[i], uv.to_array().map(f32::to_bits));
                *known.entry(key).or_insert_with(|| {
                    let vertex = corners[i] as usize;
                    mesh.positions.push(whole.positions[vertex]);
                    mesh.normals.extend(whole.normals.get(vertex));
                    mesh.colours.extend(whole.colours.get(vertex));
                    mesh.uvs.push(uv);
                    mesh.positions.len() as u32 - 1
                })
            })
            .collect();
        let triangles = triangles_of_face(&whole, corners);
        mesh.triangles
            .extend(triangles.iter().map(|t| t.map(|i| split[i])));
    }
}

/// Names of the channels of colours.
const COLOUR_NAMES: [[&str; 3]; 2] = [["red", "green", "blue"], ["r", "g", "b"]];

const UV_NAMES: [&str; 6] = ["u", "v", "s", "t", "texture_u", "texture_v"];

#[derive(Default)]
struct Vertex {
    position: DVec3,
    normal: Vec3,
    uv: Vec2,
    colour: [f32; 3],
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

#[derive(Default)]
struct Face {
    corners: Option<Vec<u32>>,
    /// Texture coordinates of its corners, u and v in turn, or empty.
    uvs: Vec<f32>,
    /// Which of the textures of the file it has.
    picture: Option<i64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "vertex_indices" | "vertex_index" => match property.to_u32_list() {
                Some(corners) => self.corners = Some(corners),
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
struct Strip(Vec<i64>);

impl PropertyAccess for Strip {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            unsigned => match unsigned.to_u32_list() {
                Some(list) => list.into_iter().map(i64::from).collect(),
                None => return PropertyAccessResult::UnsupportedType,
            },
        };
        PropertyAccessResult::Set
    }
}

/// An element that does not matter here.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Skipped
    }
}

#[cfg(test)]
mod tests;
