//! Stanford PLY through `ply-rs-bw`, ascii and binary.

mod entries;

use std::collections::{HashMap, HashSet};
use std::io::Cursor;
use std::path::Path;

use glam::Vec2;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyAccess, PropertyType, ScalarType};

use self::entries::{Face, Skipped, Strip, Vertex};
use super::mesh::FileMesh;
use super::ply_text::{PlainPly, line_of_file, plain_ply, plainly};
use super::polygon::triangles_of;
use super::text::file_error;
use super::{Mesh, SceneError};
use crate::other_kind::other_kind;

/// Loads the vertices, faces and triangle strips of a PLY file; polygons become triangles.
///
/// Normals (`nx ny nz`) and texture coordinates (`u v`, `s t`, `texture_u texture_v`, or the list `texcoord` of faces, which
/// comes first) are optional. Damage is reported with the line (ascii) or the byte offset (binary).
pub(super) fn load_ply(path: &Path) -> Result<FileMesh, SceneError> {
    let bytes = crate::files::read(path).map_err(|e| file_error(path, e.to_string()))?;
    parse_ply(&bytes, path)
}

/// [`load_ply`] of the bytes of a file; messages name `path`.
pub(super) fn parse_ply(bytes: &[u8], path: &Path) -> Result<FileMesh, SceneError> {
    if let Some(kind) = other_kind(bytes) {
        return Err(file_error(path, format!("this is no PLY file: {kind}")));
    }
    let PlainPly {
        bytes,
        notes,
        blank_lines,
    } = plain_ply(bytes).map_err(|why| file_error(path, why))?;
    let mut reader = Reader::new(Cursor::new(bytes.as_ref()));
    let header = Parser::<Vertex>::new()
        .read_header(&mut reader)
        .map_err(|e| located(path, &e, None, &[]))?;
    let mut file = PlyFile {
        header: &header,
        path,
        blank_lines: &blank_lines,
        read: FileMesh::default(),
        faces: None,
    };
    notes.into_iter().for_each(|note| file.note(note));
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
    /// Of the text, those that the parser does not see.
    blank_lines: &'a [usize],
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
                None if name == "vertex" && count > 0 => match list_for_number(element) {
                    Some(property) => {
                        format!(
                            "property `{property}` of `vertex` is a list: it must be one number"
                        )
                    }
                    None => return Ok(()),
                },
                _ if matches!(name, "face" | "tristrips") && count > 0 => {
                    match wrong_corners(element) {
                        Some(why) => format!("element `{name}`: {why}"),
                        None => return Ok(()),
                    }
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
                for lacking in lacking_parts(element) {
                    self.note(lacking);
                }
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
                let known = ["vertex_indices", "vertex_index", "texcoord", "texnumber"];
                let names = element.properties.keys().map(String::as_str);
                let others: Vec<&str> = names.filter(|name| !known.contains(name)).collect();
                if !others.is_empty() {
                    let others = others.join(", ");
                    self.note(format!("properties of faces are left out: {others}"));
                }
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
        read.map_err(|e| located(self.path, &e, offset, self.blank_lines))
    }

    fn note(&mut self, what: String) {
        let path = self.path.display();
        self.read.notes.push(format!("{path}: {what}"));
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
        let small = faces.iter().filter(|face| face.corners.len() < 3).count();
        add_faces(&mut self.read.mesh, faces).map_err(|message| error(&message))?;
        if faces.iter().any(|face| !face.uvs.is_empty()) {
            split_at_seams(&mut self.read.mesh, faces);
        }
        let unused = unused_non_finite(&self.read.mesh);
        if unused > 0 {
            self.note(format!(
                "vertices that are not finite and that no face has are left out: {unused}"
            ));
        }
        if small > 0 {
            self.note(format!(
                "faces of fewer than three vertices are left out: {small}"
            ));
        }
        Ok(self.read)
    }
}

/// A coordinate, part of a normal or texture coordinate that is declared as a list. (Colours are told of elsewhere.)
fn list_for_number(element: &ElementDef) -> Option<&'static str> {
    let is_list = |name: &&str| {
        let property = element.properties.get(*name);
        property.is_some_and(|p| matches!(p.data_type, PropertyType::List(..)))
    };
    let numbers = ["x", "y", "z", "nx", "ny", "nz"].into_iter();
    numbers.chain(UV_NAMES.into_iter().flatten()).find(is_list)
}

fn located(
    path: &Path,
    error: &ParseError,
    offset: Option<u64>,
    blank_lines: &[usize],
) -> SceneError {
    let text = error.to_string();
    let message = text.split_once(": ").filter(|_| error.line().is_some());
    let message = message.map_or(text.as_str(), |(_, rest)| rest);
    let message = plainly(message);
    match (offset, error.line()) {
        (None, Some(line)) => SceneError::At {
            file: path.to_owned(),
            line: line_of_file(line, blank_lines),
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
    if ["nx", "ny", "nz"].into_iter().all(has) {
        mesh.normals = vertices.iter().map(|v| v.normal).collect();
    }
    if UV_NAMES
        .iter()
        .any(|pair| pair.iter().all(|name| has(name)))
    {
        mesh.uvs = vertices.iter().map(|v| v.uv).collect();
    }
    let mut colours = COLOUR_NAMES.iter();
    let has_colours = colours.any(|names| names.iter().all(|name| has(name)));
    if has_colours && odd_colour(element).is_none() {
        mesh.colours = vertices.iter().map(|v| v.colour).collect();
    }
}

/// How many vertices that are not finite no triangle has; those of triangles are counted with these.
fn unused_non_finite(mesh: &Mesh) -> usize {
    let is_odd = |i: &u32| !mesh.positions[*i as usize].is_finite();
    let odd: HashSet<u32> = (0..mesh.positions.len() as u32).filter(is_odd).collect();
    if odd.is_empty() {
        return 0;
    }
    let corners = mesh.triangles.iter().flatten().copied();
    let used: HashSet<u32> = corners.filter(|i| odd.contains(i)).collect();
    odd.len() - used.len()
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
        let corners = match &face.corners[..] {
            corners @ [_, _, _, ..] => corners,
            _ => continue,
        };
        if let Some(bad) = corners.iter().find(|&&i| i < 0 || i as usize >= count) {
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
            .extend(triangles.iter().map(|t| t.map(|i| corners[i] as u32)));
    }
    match mesh.triangles.is_empty() {
        true => Err("the file has no faces of three vertices; is it truncated?".into()),
        false => Ok(()),
    }
}

/// Triangles of a face, as places in its corners.
fn triangles_of_face(mesh: &Mesh, corners: &[i64]) -> Vec<[usize; 3]> {
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
            corners: corners.to_vec(),
            ..Face::default()
        }
    })
}

/// Gives every corner the texture coordinates of its face: vertices that have several are repeated.
fn split_at_seams(mesh: &mut Mesh, faces: &[Face]) {
    let whole = std::mem::take(mesh);
    let mut known = HashMap::new();
    for face in faces {
        let corners = &face.corners[..];
        if corners.len() < 3 {
            continue;
        }
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

const UV_NAMES: [[&str; 2]; 3] = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"]];

/// What is left out of vertices: parts of normals, of texture coordinates and of colours.
fn lacking_parts(element: &ElementDef) -> Vec<String> {
    let has = |name: &&str| element.properties.contains_key(*name);
    let uvs = UV_NAMES.iter().map(|pair| pair.as_slice());
    let normal = ["nx", "ny", "nz"];
    let groups = std::iter::once(normal.as_slice()).chain(uvs);
    let mut told = Vec::new();
    for group in groups {
        let there: Vec<&str> = group.iter().copied().filter(|name| has(name)).collect();
        if !there.is_empty() && there.len() < group.len() {
            let (there, group) = (there.join(", "), group.join(", "));
            told.push(format!(
                "`{there}` of vertices is left out: of {group} some are absent"
            ));
        }
    }
    if let Some(alpha) = ["alpha", "a"].iter().find(|name| has(name)) {
        let colours = |names: &&[&str; 3]| names.iter().all(has);
        if COLOUR_NAMES.iter().any(|names| colours(&names)) {
            told.push(format!(
                "`{alpha}` of vertices is left out: they are opaque"
            ));
        }
    }
    told
}

/// Why the corners of faces cannot be read.
fn wrong_corners(element: &ElementDef) -> Option<String> {
    let named = ["vertex_indices", "vertex_index"];
    let list = named.iter().find_map(|name| element.properties.get(*name));
    let Some(list) = list else {
        let names: Vec<&str> = element.properties.keys().map(String::as_str).collect();
        let names = names.join(", ");
        return Some(format!(
            "a list `vertex_indices` was expected, its properties are: {names}"
        ));
    };
    match &list.data_type {
        PropertyType::List(_, ScalarType::Float | ScalarType::Double) => {
            Some("`vertex_indices` must be whole numbers, not float or double".into())
        }
        PropertyType::List(..) => None,
        PropertyType::Scalar(_) => Some("`vertex_indices` must be a list".into()),
    }
}

#[cfg(test)]
mod tests;
