//! Wavefront OBJ through `tobj`, with the checks and line numbers that it lacks.

use std::borrow::Cow;
use std::cell::Cell;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Write;
use std::io::Read;
use std::path::{Path, PathBuf};

use glam::{DVec3, Vec2, Vec3};

use super::mesh::FileMesh;
use super::mesh_mtl::used_materials;
use super::obj_text::{PlainObj, plain_obj};
use super::polygon::{fan_covers, is_large, triangles_of};
use super::text::{advice, file_error};
use super::{Mesh, SceneError};
use crate::other_kind::other_kind;

/// An OBJ file that was read, to be divided among the shapes that are made of it.
pub(super) struct ObjFile {
    path: PathBuf,
    models: Vec<tobj::Model>,
    /// Where the faces of each object, of each group and of each material (`usemtl stone`) are in `models`.
    parts: HashMap<String, Vec<usize>>,
    /// What of the file is left out.
    notes: Vec<String>,
}

impl ObjFile {
    /// Reads all faces of a file.
    ///
    /// Polygons become triangles, relative indices are resolved; material libraries are [`super::mesh_mtl`]'s. Corners
    /// without normal get a zero one, corners without texture coordinate (0, 0). Fails with the line on
    /// anything that cannot be read, on indices out of range, and on files without a face (truncated).
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let bytes = crate::files::read(path).map_err(|e| file_error(path, e.to_string()))?;
        Self::parse(&bytes, path)
    }

    /// The bytes of a file; `path` is for messages.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self, SceneError> {
        let PlainObj {
            text: plain,
            left_out,
        } = plain_obj(bytes);
        let at = |(line, message): (usize, String)| SceneError::At {
            file: path.to_owned(),
            line,
            column: 1,
            message,
        };
        let survey = Survey::of(&plain).map_err(|(line, message)| {
            let (line, message) = match message == NO_FACES {
                true => (line, no_faces(bytes, &left_out)),
                false => (line, message),
            };
            at((line, message))
        })?;
        let hollow = survey.polygons > 0 && has_hollow(&plain, &survey.positions);
        let text = if survey.is_mixed() || hollow {
            Cow::Owned(survey.rewritten(&plain))
        } else {
            Cow::Borrowed(plain.as_str())
        };
        let options = tobj::LoadOptions {
            single_index: true,
            triangulate: true,
            ignore_points: true,
            ignore_lines: true,
        };
        // Stands for all libraries: every material by its name, so that models are split by material.
        let names = used_materials(&text);
        let asked = Cell::new(false);
        let library = |_: &Path| {
            let names: &[&str] = if asked.replace(true) { &[] } else { &names };
            let material = |name: &&str| tobj::Material {
                name: (*name).to_owned(),
                ..Default::default()
            };
            let indices = names
                .iter()
                .enumerate()
                .map(|(i, name)| ((*name).to_owned(), i));
            Ok((names.iter().map(material).collect(), indices.collect()))
        };
        let mut reader = "mtllib all\n".as_bytes().chain(text.as_bytes());
        let (models, _) = tobj::load_obj_buf(&mut reader, &options, library).map_err(|error| {
            match unreadable_line(&plain) {
                Some(found) => at(found),
                None => file_error(path, error.to_string()),
            }
        })?;
        let mut parts: HashMap<String, Vec<usize>> = HashMap::new();
        let several = names_of_several_groups(&text);
        for (index, model) in models.iter().enumerate() {
            if model.mesh.indices.is_empty() {
                continue;
            }
            let material = model.mesh.material_id.and_then(|i| names.get(i).copied());
            let material = format!("usemtl {}", material.unwrap_or(""));
            let mut of = vec![model.name.as_str(), &material];
            if several.contains(model.name.as_str()) {
                of.extend(model.name.split_whitespace());
            }
            of.sort_unstable();
            of.dedup();
            for name in of {
                parts.entry(name.to_owned()).or_default().push(index);
            }
        }
        Ok(Self {
            path: path.to_owned(),
            models,
            parts,
            notes: notes_of(path, left_out, &survey),
        })
    }

    /// All faces, or those of the object or group called `part`, or, for a `part` like `usemtl stone`, those of one
    /// material. With a `material`, of these those that have it.
    pub fn mesh(&self, part: Option<&str>, material: Option<&str>) -> Result<FileMesh, SceneError> {
        let mut mesh = Mesh::default();
        let notes = self.notes.clone();
        let Some(name) = part else {
            let all = self.models.iter();
            all.for_each(|model| mesh.append(&convert(&model.mesh)));
            return Ok(FileMesh { mesh, notes });
        };
        let Some(chosen) = self.parts.get(name) else {
            let mut known: Vec<&str> = self.parts.keys().map(String::as_str).collect();
            known.sort_unstable();
            let message = format!("no object or group `{name}`; {}", advice(name, &known));
            return Err(file_error(&self.path, message));
        };
        let of_material = material.map(|name| {
            let known = self.parts.get(&format!("usemtl {name}"));
            known.map_or(&[][..], Vec::as_slice)
        });
        let has_it = |index: &&usize| of_material.is_none_or(|all| all.contains(index));
        for &index in chosen.iter().filter(has_it) {
            mesh.append(&convert(&self.models[index].mesh));
        }
        Ok(FileMesh { mesh, notes })
    }
}

const NO_FACES: &str = "the file has no faces";

/// What to say of a file without faces: what it is, or what it has in their place.
fn no_faces(bytes: &[u8], left_out: &BTreeMap<String, usize>) -> String {
    if let Some(kind) = other_kind(bytes) {
        return format!("{NO_FACES}; {kind}");
    }
    let found = left_out
        .iter()
        .take(3)
        .map(|(what, count)| format!("{what}, {count} times"));
    match left_out.is_empty() {
        true => format!("{NO_FACES}; is it truncated?"),
        false => format!(
            "{NO_FACES}, but {}: is it an OBJ file?",
            found.collect::<Vec<_>>().join(" and ")
        ),
    }
}

/// A sentence for each kind of thing that is left out.
fn notes_of(path: &Path, left_out: BTreeMap<String, usize>, survey: &Survey) -> Vec<String> {
    let path = path.display();
    let left_out = left_out.into_iter();
    let mut notes: Vec<String> = left_out
        .map(|(what, count)| format!("{path}: {what} are left out ({count} times)"))
        .collect();
    if survey.large > 0 {
        let count = survey.large;
        notes.push(format!(
            "{path}: faces of so many corners that they become fans, whether convex or not: {count}"
        ));
    }
    notes
}

fn convert(mesh: &tobj::Mesh) -> Mesh {
    Mesh {
        positions: mesh
            .positions
            .chunks_exact(3)
            .map(DVec3::from_slice)
            .collect(),
        normals: mesh
            .normals
            .chunks_exact(3)
            .map(|n| DVec3::from_slice(n).as_vec3())
            .collect::<Vec<Vec3>>(),
        uvs: mesh
            .texcoords
            .chunks_exact(2)
            .map(|t| Vec2::new(t[0] as f32, t[1] as f32))
            .collect(),
        colours: Vec::new(),
        triangles: mesh
            .indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
    }
}

/// What the faces of a file refer to: position, texture coordinate, normal.
#[derive(Default)]
struct Survey {
    with: [bool; 3],
    without: [bool; 3],
    /// Largest index (from 1) of each kind and its line.
    largest: [(i64, usize); 3],
    faces: usize,
    /// Faces of more than three corners, and those of them that are too large to look at.
    polygons: usize,
    large: usize,
    /// Of the vertices, if there are such faces; NaN where they cannot be read.
    positions: Vec<DVec3>,
}

const ATTRIBUTES: [&str; 3] = ["vertex", "texture coordinate", "normal"];

impl Survey {
    /// Checks every face of the file; the error is a line and what is wrong there.
    fn of(text: &str) -> Result<Survey, (usize, String)> {
        let mut survey = Survey::default();
        let mut counts = [0_i64; 3];
        let mut last_line = 1;
        for (index, line) in text.lines().enumerate() {
            last_line = index + 1;
            match keyword(line) {
                "v" => counts[0] += 1,
                "vt" => counts[1] += 1,
                "vn" => counts[2] += 1,
                "f" => survey.face(line, last_line, &counts)?,
                _ => {}
            }
        }
        for (kind, &(largest, line)) in survey.largest.iter().enumerate() {
            if largest > counts[kind] {
                let what = ATTRIBUTES[kind];
                let message = format!(
                    "{what} {largest} does not exist, the file has {}",
                    counts[kind]
                );
                return Err((line, message));
            }
        }
        if survey.faces == 0 {
            return Err((last_line, NO_FACES.into()));
        }
        if survey.polygons > 0 {
            let vertices = text.lines().filter(|line| keyword(line) == "v");
            survey.positions = vertices.map(position).collect();
        }
        Ok(survey)
    }

    fn face(
        &mut self,
        line: &str,
        number: usize,
        counts: &[i64; 3],
    ) -> Result<(), (usize, String)> {
        let mut corners = 0;
        for corner in line.split_whitespace().skip(1) {
            let indices = resolve_corner(corner, counts).map_err(|message| (number, message))?;
            for (kind, index) in indices.into_iter().enumerate() {
                match index {
                    Some(i) => {
                        self.with[kind] = true;
                        if i > self.largest[kind].0 {
                            self.largest[kind] = (i, number);
                        }
                    }
                    None => self.without[kind] = true,
                }
            }
            corners += 1;
        }
        if corners < 3 {
            let message = format!("a face needs 3 corners, this one has {corners}; truncated?");
            return Err((number, message));
        }
        self.faces += 1;
        self.polygons += usize::from(corners > 3);
        self.large += usize::from(is_large(corners));
        Ok(())
    }

    /// Whether some corners have a normal or texture coordinate and others have not.
    fn is_mixed(&self) -> bool {
        (1..3).any(|kind| self.with[kind] && self.without[kind])
    }
}

/// What `g` statements say that put faces into several groups. (Names of objects may have blanks.)
pub(super) fn names_of_several_groups(text: &str) -> HashSet<&str> {
    let named = |word: &'static str| {
        let lines = text.lines().filter(move |line| keyword(line) == word);
        let names = lines.map(|line| line.trim_start()[1..].trim());
        names.filter(|name| name.contains(char::is_whitespace))
    };
    let objects: HashSet<&str> = named("o").collect();
    named("g").filter(|name| !objects.contains(name)).collect()
}

fn keyword(line: &str) -> &str {
    line.split_whitespace().next().unwrap_or("")
}

/// Indices from 1 of a corner like `7`, `7/1`, `7//3`, `-1/-1/-1`.
fn resolve_corner(corner: &str, counts: &[i64; 3]) -> Result<[Option<i64>; 3], String> {
    let mut indices = [None; 3];
    for (kind, token) in corner.split('/').enumerate() {
        if kind > 2 {
            return Err(format!(
                "face corner `{corner}` has more than three indices"
            ));
        }
        if token.is_empty() {
            continue;
        }
        let index: i64 = token
            .parse()
            .map_err(|_| format!("face corner `{corner}`: `{token}` is not a whole number"))?;
        let resolved = if index < 0 {
            counts[kind] + 1 + index
        } else {
            index
        };
        if resolved < 1 || resolved > i64::from(u32::MAX) {
            let what = ATTRIBUTES[kind];
            return Err(format!(
                "face corner `{corner}`: {what} {index} does not exist"
            ));
        }
        indices[kind] = Some(resolved);
    }
    if indices[0].is_none() {
        return Err(format!("face corner `{corner}` names no vertex"));
    }
    Ok(indices)
}

/// The three numbers of a vertex, NaN for what is none.
fn position(line: &str) -> DVec3 {
    let mut words = line.split_whitespace().skip(1);
    let mut number = || {
        words
            .next()
            .and_then(|w| w.parse().ok())
            .unwrap_or(f64::NAN)
    };
    DVec3::new(number(), number(), number())
}

/// Whether a fan does not cover one of the faces of a surveyed file once.
fn has_hollow(text: &str, positions: &[DVec3]) -> bool {
    let mut counts = [0; 3];
    text.lines().any(|line| match keyword(line) {
        "f" => {
            line.split_whitespace().nth(4).is_some() && {
                let corners: Vec<_> = corners_of(line, &counts);
                !fan_covers(&places_of(&corners, positions))
            }
        }
        word => {
            count(word, &mut counts);
            false
        }
    })
}

/// Counts what a statement declares.
fn count(keyword: &str, counts: &mut [i64; 3]) {
    let kind = ["v", "vt", "vn"].iter().position(|kind| *kind == keyword);
    kind.into_iter().for_each(|kind| counts[kind] += 1);
}

type Corner = [Option<i64>; 3];

fn corners_of(face: &str, counts: &[i64; 3]) -> Vec<Corner> {
    let corners = face.split_whitespace().skip(1);
    corners
        .filter_map(|corner| resolve_corner(corner, counts).ok())
        .collect()
}

fn places_of(corners: &[Corner], positions: &[DVec3]) -> Vec<DVec3> {
    let place = |corner: &Corner| positions.get((corner[0]? - 1) as usize).copied();
    corners
        .iter()
        .map(|corner| place(corner).unwrap_or(DVec3::NAN))
        .collect()
}

impl Survey {
    /// A surveyed file with triangles for polygons. Where only some corners have a normal or texture coordinate every
    /// corner gets all three indices: those that were absent point to a zero one put in front.
    fn rewritten(&self, text: &str) -> String {
        let mut out = String::with_capacity(text.len() * 5 / 4);
        let complete = self.is_mixed();
        if complete {
            out.push_str("vt 0 0\nvn 0 0 0\n");
        }
        let mut counts = [0_i64; 3];
        for line in text.lines() {
            let word = keyword(line);
            count(word, &mut counts);
            if word != "f" {
                out.push_str(line);
                out.push('\n');
                continue;
            }
            let corners = corners_of(line, &counts);
            for triangle in triangles_of(&places_of(&corners, &self.positions)) {
                out.push('f');
                for corner in triangle.map(|i| corners[i]) {
                    out.push(' ');
                    push_corner(&mut out, corner, complete);
                }
                out.push('\n');
            }
        }
        out
    }
}

fn push_corner(out: &mut String, [v, vt, vn]: Corner, complete: bool) {
    let v = v.unwrap_or(1);
    // Writing to a string cannot fail.
    let _ = match (complete, vt, vn) {
        (true, _, _) => write!(out, "{v}/{}/{}", vt.unwrap_or(0) + 1, vn.unwrap_or(0) + 1),
        (false, None, None) => write!(out, "{v}"),
        (false, Some(vt), None) => write!(out, "{v}/{vt}"),
        (false, None, Some(vn)) => write!(out, "{v}//{vn}"),
        (false, Some(vt), Some(vn)) => write!(out, "{v}/{vt}/{vn}"),
    };
}

/// The first line whose numbers `tobj` refuses.
fn unreadable_line(text: &str) -> Option<(usize, String)> {
    for (index, line) in text.lines().enumerate() {
        let wanted = match keyword(line) {
            "v" | "vn" => 3,
            "vt" => 2,
            _ => continue,
        };
        let words: Vec<&str> = line.split_whitespace().skip(1).collect();
        let bad = words.iter().find(|w| w.parse::<f64>().is_err());
        let message = match bad {
            Some(word) => format!("`{word}` is not a number"),
            None if words.len() < wanted => {
                format!(
                    "expected {wanted} numbers, found {}; truncated?",
                    words.len()
                )
            }
            None if keyword(line) == "v" && words.len() != 3 => {
                format!("expected 3, 4, 6 or 7 numbers, found {}", words.len())
            }
            None => continue,
        };
        return Some((index + 1, message));
    }
    None
}

#[cfg(test)]
mod tests;
