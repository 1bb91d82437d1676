//! Stanford PLY through `ply-rs-bw`, ascii and binary.

use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Encoding, Property, PropertyAccess, PropertyAccessResult};

use super::text::file_error;
use super::{Mesh, SceneError};

/// Loads the vertices and faces of a PLY file; polygons become fans.
///
/// Normals (`nx ny nz`) and texture coordinates (`u v`, `s t`, `texture_u texture_v`) are optional.
/// Damage is reported with the line (ascii) or the byte offset (binary).
pub(super) fn load_ply(path: &Path) -> Result<Mesh, SceneError> {
    let bytes = std::fs::read(path).map_err(|e| file_error(path, e.to_string()))?;
    parse_ply(&bytes, path)
}

/// [`load_ply`] of the bytes of a file; messages name `path`.
pub(super) fn parse_ply(bytes: &[u8], path: &Path) -> Result<Mesh, SceneError> {
    let bytes = plain(bytes);
    let mut reader = Reader::new(Cursor::new(bytes.as_ref()));
    let header = Parser::<Vertex>::new()
        .read_header(&mut reader)
        .map_err(|e| located(path, &e, None))?;
    let binary = header.encoding != Encoding::Ascii;
    let mut mesh = Mesh::default();
    let mut faces = None;
    for (name, element) in &header.elements {
        let (count, most) = (element.count as u64, bytes.len() as u64);
        if count > 0 && element.properties.is_empty() {
            let message = format!("element `{name}` has entries and no properties");
            return Err(file_error(path, message));
        }
        if count > most {
            let message = format!("{count} entries of `{name}` are promised in {most} bytes");
            return Err(file_error(path, message));
        }
        let result = match name.as_str() {
            "vertex" => Parser::<Vertex>::new()
                .read_payload_for_element(&mut reader, element, &header)
                .map(|vertices| {
                    let has = |p: &str| element.properties.contains_key(p);
                    add_vertices(
                        &mut mesh,
                        &vertices,
                        has("nx"),
                        UV_NAMES.iter().any(|n| has(n)),
                    );
                    if COLOUR_NAMES
                        .iter()
                        .any(|names| names.iter().all(|n| has(n)))
                    {
                        mesh.colours = vertices.iter().map(|v| v.colour).collect();
                    }
                }),
            "face" => Parser::<Face>::new()
                .read_payload_for_element(&mut reader, element, &header)
                .map(|read| faces = Some(read)),
            _ => Parser::<Skipped>::new()
                .read_payload_for_element(&mut reader, element, &header)
                .map(|_| ()),
        };
        let offset = binary.then(|| reader.get_ref().position());
        result.map_err(|e| located(path, &e, offset))?;
    }
    let faces = faces.ok_or_else(|| file_error(path, "no `face` element; is it a point cloud?"))?;
    add_faces(&mut mesh, &faces).map_err(|message| file_error(path, message))?;
    Ok(mesh)
}

/// The file as the parser understands it, with as many lines: without characters beyond ASCII in the header (comments may
/// have them in any encoding), with line feeds where lines end in carriage returns alone, and in text with numbers for what
/// is none: vertices that are not finite are left to whoever uses them, as in OBJ files.
fn plain(bytes: &[u8]) -> Cow<'_, [u8]> {
    const END: &[u8] = b"end_header";
    let end = bytes.windows(END.len()).position(|window| window == END);
    let Some(end) = end.map(|start| start + END.len()) else {
        return Cow::Borrowed(bytes);
    };
    let (header, body) = bytes.split_at(end);
    let is_text = header.windows(12).any(|w| w == b"format ascii");
    let returns_alone = !header.contains(&b'\n');
    let feed = |byte: u8| match byte {
        b'\r' if returns_alone => b'\n',
        byte => byte,
    };
    let header = header.iter().map(|&byte| match byte.is_ascii() {
        true => feed(byte),
        false => b'?',
    });
    let mut plain: Vec<u8> = header.collect();
    match (is_text, body) {
        (true, _) => plain.extend(finite_words(body).into_iter().map(feed)),
        // The one that ends the header.
        (false, [first, rest @ ..]) => {
            plain.push(feed(*first));
            plain.extend(rest);
        }
        (false, []) => {}
    }
    Cow::Owned(plain)
}

/// A text in which `nan`, `inf` and what C libraries print for them are numbers beyond all that are finite.
fn finite_words(body: &[u8]) -> Vec<u8> {
    let is_number = |word: &[u8]| {
        let numeric = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
        word.iter().all(numeric)
    };
    let mut out = Vec::with_capacity(body.len());
    for word in body.split_inclusive(u8::is_ascii_whitespace) {
        let end = word.iter().position(u8::is_ascii_whitespace);
        let (word, blank) = word.split_at(end.unwrap_or(word.len()));
        let lower = String::from_utf8_lossy(word).to_lowercase();
        let odd = !is_number(word)
            && ["nan", "inf", "#ind", "#qnan"]
                .iter()
                .any(|n| lower.contains(n));
        out.extend(if odd { b"1e999".as_slice() } else { word });
        out.extend(blank);
    }
    out
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

/// A message of the parser without its own structures.
fn plainly(message: &str) -> String {
    let message: Vec<&str> = message.split_whitespace().collect();
    let message = message.join(" ");
    let Some((what, rest)) = message.split_once(" String: '") else {
        return message
            .split(" Error: ")
            .next()
            .unwrap_or_default()
            .to_owned();
    };
    let found = rest.split("' Error:").next().unwrap_or(rest).trim();
    let found: String = found.chars().take(60).collect();
    let what = what.trim_end_matches('.');
    match what.contains("element") {
        true => format!("`{found}` is not what the header declares"),
        false => format!("{what}: `{found}`"),
    }
}

fn add_vertices(mesh: &mut Mesh, vertices: &[Vertex], has_normals: bool, has_uvs: bool) {
    mesh.positions = vertices.iter().map(|v| v.position).collect();
    if has_normals {
        mesh.normals = vertices.iter().map(|v| v.normal).collect();
    }
    if has_uvs {
        mesh.uvs = vertices.iter().map(|v| v.uv).collect();
    }
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
        for pair in corners[1..].windows(2) {
            mesh.triangles.push([corners[0], pair[0], pair[1]]);
        }
    }
    match mesh.triangles.is_empty() {
        true => Err("the file has no faces; is it truncated?".into()),
        false => Ok(()),
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
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        match property.to_u32_list() {
            Some(corners) => {
                self.corners = Some(corners);
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
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
mod tests {
    use super::*;

    const ASCII: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\nelement edge 1\nproperty int a\nelement face 1\nproperty uchar flag\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n1 1 0 0 0 1 1 1\n0 1 0.5 0 0 1 0 1\n7\n9 4 0 1 2 3\n";

    fn parse(bytes: &[u8]) -> Result<Mesh, String> {
        parse_ply(bytes, Path::new("t.ply")).map_err(|e| e.to_string())
    }

    fn binary(big: bool) -> Vec<u8> {
        let order = if big { "big" } else { "little" };
        let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar uint vertex_index\nend_header\n").into_bytes();
        for x in [0.0_f32, 0., 0., 1., 0., 0., 0., 1., 0.] {
            bytes.extend(if big {
                x.to_be_bytes()
            } else {
                x.to_le_bytes()
            });
        }
        bytes.push(3);
        for i in [0_u32, 1, 2] {
            bytes.extend(if big {
                i.to_be_bytes()
            } else {
                i.to_le_bytes()
            });
        }
        bytes
    }

    #[test]
    fn ascii_with_everything() {
        let mesh = parse(ASCII.as_bytes()).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.positions[3], DVec3::new(0.0, 1.0, 0.5));
        assert_eq!(mesh.normals, [Vec3::Z; 4]);
        assert_eq!(mesh.uvs[1], Vec2::X);
    }

    #[test]
    fn binary_in_both_orders() {
        for big in [false, true] {
            let mesh = parse(&binary(big)).unwrap();
            assert_eq!(mesh.positions[2], DVec3::Y);
            assert_eq!(mesh.triangles, [[0, 1, 2]]);
            assert!(mesh.normals.is_empty() && mesh.uvs.is_empty());
        }
    }

    #[test]
    fn comments_in_any_encoding_and_returns_alone_are_read() {
        let latin = [b"ply\ncomment caf\xe9\n".as_slice(), &ASCII.as_bytes()[4..]].concat();
        for bytes in [
            latin,
            ASCII.replace('\n', "\r").into_bytes(),
            ASCII.replace('\n', "\r\n").into_bytes(),
        ] {
            assert_eq!(parse(&bytes).unwrap().triangles.len(), 2);
        }
    }

    #[test]
    fn vertices_that_are_not_finite_are_kept_for_whoever_uses_them() {
        for word in ["nan", "-NAN", "inf", "-1.#IND"] {
            let text = ASCII.replace("0 1 0.5 0 0 1 0 1\n", &format!("{word} 1 0.5 0 0 1 0 1\n"));
            let mesh = parse(text.as_bytes()).unwrap();
            assert!(!mesh.positions[3].is_finite(), "{word}");
        }
    }

    #[test]
    fn messages_show_the_line_and_nothing_of_the_parser() {
        let cut = ASCII.replace("1 1 0 0 0 1 1 1\n", "1 1 0 0 0 x 1 1\n");
        let error = parse(cut.as_bytes()).unwrap_err();
        assert!(error.contains("`1 1 0 0 0 x 1 1` is not what"), "{error}");
        assert!(
            !error.contains("ParseError") && !error.contains("expected one of"),
            "{error}"
        );
    }

    #[test]
    fn headers_cannot_promise_what_is_not_there() {
        let empty = "ply\nformat ascii 1.0\nelement odd 1000000000000\nend_header\n";
        assert!(
            parse(empty.as_bytes())
                .unwrap_err()
                .contains("no properties")
        );
        let many = ASCII.replace("element vertex 4", "element vertex 999999999");
        assert!(parse(many.as_bytes()).unwrap_err().contains("are promised"));
    }

    #[test]
    fn every_truncation_is_refused() {
        let whole = binary(false);
        for length in 0..whole.len() {
            assert!(parse(&whole[..length]).is_err(), "{length} bytes");
        }
        let error = parse(&whole[..whole.len() - 3]).unwrap_err();
        assert!(error.starts_with("t.ply: byte offset "), "{error}");
    }

    #[test]
    fn damage_is_named_with_its_line() {
        let cut = ASCII.replace("1 1 0 0 0 1 1 1\n", "1 1 0 0 0 x 1 1\n");
        let error = parse(cut.as_bytes()).unwrap_err();
        assert!(error.starts_with("t.ply:20:1: "), "{error}");
        let range = ASCII.replace("9 4 0 1 2 3", "9 4 0 1 2 4");
        assert!(
            parse(range.as_bytes())
                .unwrap_err()
                .contains("names vertex 4, the file has 4")
        );
        let negative = ASCII.replace("9 4 0 1 2 3", "9 4 0 1 2 -3");
        assert!(parse(negative.as_bytes()).is_err());
        let short = ASCII.replace("9 4 0 1 2 3", "9 2 0 1");
        assert!(
            parse(short.as_bytes())
                .unwrap_err()
                .contains("fewer than three")
        );
    }
}
