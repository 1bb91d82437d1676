use glam::{DVec3, Vec3};

use super::*;

const ASCII: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\nelement edge 1\nproperty int a\nelement face 1\nproperty uchar flag\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n1 1 0 0 0 1 1 1\n0 1 0.5 0 0 1 0 1\n7\n9 4 0 1 2 3\n";

fn read(bytes: &[u8]) -> Result<FileMesh, String> {
    parse_ply(bytes, Path::new("t.ply")).map_err(|e| e.to_string())
}

fn parse(bytes: &[u8]) -> Result<Mesh, String> {
    read(bytes).map(|read| read.mesh)
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
fn numbers_are_read_as_c_libraries_read_them() {
    let text = ASCII.replace("0 1 0.5 0 0 1 0 1\n", "+.5e+0 1.e0 -.5 0. 0 +1 0 1.\n");
    let mesh = parse(text.as_bytes()).unwrap();
    assert_eq!(mesh.positions[3], DVec3::new(0.5, 1.0, -0.5));
    for word in [".", "-", "+-1", "1..", "1.2.3", "e5"] {
        let text = ASCII.replace("0 1 0.5", &format!("{word} 1 0.5"));
        assert!(parse(text.as_bytes()).is_err(), "{word}");
    }
}

#[test]
fn blank_lines_may_stand_among_entries_and_lines_end_in_two_returns() {
    let (head, body) = ASCII.split_once("end_header\n").unwrap();
    let loose = |body: &str| format!("{head}end_header\n\n{}\n\n", body.replace('\n', "\n \n"));
    for text in [loose(body), ASCII.replace('\n', "\r\r\n")] {
        let read = read(text.as_bytes()).unwrap();
        assert_eq!(read.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    }
    // Lines of the file are told.
    let damaged = body.replace("1 1 0 0 0 1 1 1", "1 1 0 0 0 x 1 1");
    let error = parse(loose(&damaged).as_bytes()).unwrap_err();
    assert!(error.starts_with("t.ply:23:1: "), "{error}");
    let longer = loose(&body.replace("1 1 0 0 0 1 1 1", "1 1 0 0 0 1 1 1 5"));
    let read = read(longer.as_bytes()).unwrap();
    assert!(
        read.notes[0].contains("1 lines have more values"),
        "{:?}",
        read.notes
    );
}

#[test]
fn numbers_that_are_declared_as_lists_are_refused() {
    for name in ["z", "ny", "t"] {
        let text = ["float", "double"]
            .iter()
            .fold(ASCII.to_owned(), |text, kind| {
                text.replace(
                    &format!("property {kind} {name}\n"),
                    &format!("property list uchar float {name}\n"),
                )
            });
        let error = parse(text.as_bytes()).unwrap_err();
        let told = format!("property `{name}` of `vertex` is a list: it must be one number");
        assert!(error.contains(&told), "{error}");
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
fn vertices_that_are_not_finite_and_that_no_face_has_are_told() {
    let text = ASCII.replace("element vertex 4", "element vertex 5");
    let text = text.replace(
        "0 1 0.5 0 0 1 0 1\n",
        "0 1 0.5 0 0 1 0 1\nnan 1 0.5 0 0 1 0 1\n",
    );
    let read = parse_ply(text.as_bytes(), Path::new("t.ply")).unwrap();
    let note = "t.ply: vertices that are not finite and that no face has are left out: 1";
    assert_eq!(read.notes.last().map(String::as_str), Some(note));
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
            .contains("no faces of three vertices")
    );
}
#[test]
fn blank_lines_of_headers_and_returns_in_bodies_are_read() {
    let blank = ASCII.replace("element edge", "\n \nelement edge");
    assert_eq!(parse(blank.as_bytes()).unwrap().triangles.len(), 2);
    let cut = blank.replace("1 1 0 0 0 1 1 1\n", "1 1 0 0 0 x 1 1\n");
    let error = parse(cut.as_bytes()).unwrap_err();
    assert!(error.starts_with("t.ply:22:1: "), "{error}");
    let (header, body) = ASCII.split_once("end_header\n").unwrap();
    let mixed = format!("{header}end_header\n{}", body.replace('\n', "\r"));
    assert_eq!(parse(mixed.as_bytes()).unwrap().triangles.len(), 2);
    let whole = binary(false);
    let end = whole
        .windows(11)
        .position(|w| w == b"end_header\n")
        .unwrap()
        + 11;
    for line_end in ["\r", "\r\n"] {
        let header = String::from_utf8_lossy(&whole[..end]).replace('\n', line_end);
        let bytes = [header.as_bytes(), &whole[end..]].concat();
        assert_eq!(parse(&bytes).unwrap().positions[2], DVec3::Y);
    }
}

#[test]
fn vertices_without_an_axis_are_refused() {
    let flat = ASCII.replace("property double z\n", "property double height\n");
    let error = parse(flat.as_bytes()).unwrap_err();
    assert!(error.contains("`vertex` has no property `z`"), "{error}");
}

#[test]
fn strips_are_read_and_other_elements_told() {
    let strips = ASCII
        .replace(
            "element face 1\nproperty uchar flag\n",
            "element tristrips 1\n",
        )
        .replace("9 4 0 1 2 3\n", "8 0 1 3 2 -1 0 1 2\n");
    let read = read(strips.as_bytes()).unwrap();
    assert_eq!(read.mesh.triangles, [[0, 1, 3], [3, 1, 2], [0, 1, 2]]);
    assert_eq!(read.notes, ["t.ply: element `edge` is left out, 1 entries"]);
    let bad = strips.replace("8 0 1 3 2", "8 0 1 3 9");
    assert!(
        parse(bad.as_bytes())
            .unwrap_err()
            .contains("names vertex 9")
    );
}

#[test]
fn coordinates_of_corners_split_vertices() {
    let corners = ASCII
        .replace("element face 1", "element face 2")
        .replace(
            "vertex_indices\n",
            "vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\n",
        )
        .replace(
            "9 4 0 1 2 3\n",
            "9 3 0 1 2 6 0 0 1 0 1 1 0\n9 3 0 2 3 6 0.5 0 1 1 0 1 1\n",
        );
    let read = read(corners.as_bytes()).unwrap();
    let mesh = read.mesh;
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 2, 4]], "vertex 0 is split");
    assert_eq!(mesh.positions[3], mesh.positions[0]);
    assert_eq!(mesh.uvs[3], Vec2::new(0.5, 0.0));
    assert_eq!((mesh.normals.len(), mesh.uvs.len()), (5, 5));
    assert!(read.notes.iter().any(|note| note.contains("texnumber")));
    let short = corners.replace("6 0 0 1 0 1 1 0\n", "4 0 0 1 0 0\n");
    let error = parse(short.as_bytes()).unwrap_err();
    assert!(error.contains("4 texture coordinates for 3"), "{error}");
}

#[test]
fn hollow_faces_are_covered_once() {
    let arrow = ASCII
        .replace("0 0 0 0 0 1 0 0\n", "0 2 0 0 0 1 0 0\n")
        .replace("1 0 0 0 0 1 1 0\n", "0 0 0 0 0 1 1 0\n")
        .replace("1 1 0 0 0 1 1 1\n", "2 0 0 0 0 1 1 1\n")
        .replace("0 1 0.5 0 0 1 0 1\n", "0.5 0.5 0 0 0 1 0 1\n");
    let mesh = parse(arrow.as_bytes()).unwrap();
    assert!(
        mesh.triangles
            .iter()
            .all(|t| t.contains(&1) && t.contains(&3))
    );
}

#[test]
fn what_stands_behind_the_last_element_is_told() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let notes = |text: &str| {
        parse_ply(text.as_bytes(), Path::new("m.ply"))
            .unwrap()
            .notes
    };
    assert!(notes(&format!("{text}\n \n")).is_empty());
    assert_eq!(
        notes(&format!("{text}3 2 1 0\n")),
        ["m.ply: 7 bytes behind the last element are left out"]
    );
}

#[test]
fn colours_of_types_without_a_largest_value_are_told() {
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty int red\nproperty int green\nproperty int blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2\n";
    let read = parse_ply(text.as_bytes(), Path::new("m.ply")).unwrap();
    assert!(read.mesh.colours.is_empty());
    assert!(read.notes[0].contains("of type int"), "{:?}", read.notes);
}

/// A square of two triangles with these properties of vertices, lines behind the header, and faces.
fn square(properties: &str, faces: &str, body: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n{properties}element face {faces}end_header\n{body}"
    )
}

const LIST: &str = "2\nproperty list uchar int vertex_indices\n";
const CORNERS: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
const FACES: &str = "3 0 1 2\n3 0 2 3\n";

fn told(text: &str) -> Result<FileMesh, String> {
    read(text.as_bytes())
}

#[test]
fn entries_may_stand_anywhere_in_the_lines() {
    let whole = told(&square("", LIST, &format!("{CORNERS}{FACES}"))).unwrap();
    assert!(whole.notes.is_empty(), "{:?}", whole.notes);
    let one_line = format!("{CORNERS}{FACES}").replace('\n', " ");
    let wrapped = "0 0 0 1\n0 0 1 1 0 0 1 0\n3 0 1\n2 3 0 2 3\n";
    for body in [one_line.as_str(), wrapped] {
        let read = told(&square("", LIST, body)).unwrap();
        assert_eq!(read.mesh.positions, whole.mesh.positions);
        assert_eq!(read.mesh.triangles, whole.mesh.triangles);
        assert!(read.notes.is_empty(), "{:?}", read.notes);
    }
    let longer = format!("{CORNERS}3 0 1 2 255 0 0\n3 0 2 3\n");
    let read = told(&square("", LIST, &longer)).unwrap();
    assert_eq!(read.mesh.triangles, whole.mesh.triangles);
    assert_eq!(
        read.notes,
        ["t.ply: 1 lines have more values than the header declares, these are left out"]
    );
}

#[test]
fn a_mark_of_the_byte_order_and_comments_that_name_the_end_are_passed_over() {
    let text = square("", LIST, &format!("{CORNERS}{FACES}"));
    let marked = format!("\u{feff}{text}");
    assert_eq!(told(&marked).unwrap().mesh.triangles.len(), 2);
    let comment = "ply\ncomment end_header is below, nan\nobj_info inf\n";
    let named = text.replacen("ply\n", comment, 1);
    assert_eq!(told(&named).unwrap().mesh.triangles.len(), 2);
}

#[test]
fn what_of_vertices_and_faces_is_left_out_is_told() {
    let coloured = format!("{LIST}property uchar red\nproperty int material_index\n");
    let faces = "3 0 1 2 255 0\n3 0 2 3 0 1\n";
    let faces = told(&square("", &coloured, &format!("{CORNERS}{faces}"))).unwrap();
    assert_eq!(
        faces.notes,
        ["t.ply: properties of faces are left out: red, material_index"]
    );
    let half = "property float nx\nproperty float ny\nproperty float u\n";
    let body = CORNERS.replace('\n', " 0 0 0.5\n");
    let read_half = told(&square(half, LIST, &format!("{body}{FACES}"))).unwrap();
    assert!(read_half.mesh.normals.is_empty() && read_half.mesh.uvs.is_empty());
    assert_eq!(
        read_half.notes,
        [
            "t.ply: `nx, ny` of vertices is left out: of nx, ny, nz some are absent",
            "t.ply: `u` of vertices is left out: of u, v some are absent",
        ]
    );
    let alpha =
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    let body = CORNERS.replace('\n', " 1 2 3 4\n");
    let text = square(alpha, LIST, &format!("{body}{FACES}"));
    let text = text.replacen("ply\n", "ply\ncomment TextureFile my wood.png\n", 1);
    assert_eq!(
        told(&text).unwrap().notes,
        [
            "t.ply: the texture `my wood.png` that a comment names is left out",
            "t.ply: `alpha` of vertices is left out: they are opaque",
        ]
    );
}

#[test]
fn faces_of_few_corners_cost_a_message() {
    let three = LIST.replacen('2', "4", 1);
    let body = format!("{CORNERS}2 0 1\n{FACES}0\n");
    let mesh = told(&square("", &three, &body)).unwrap();
    assert_eq!(mesh.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(
        mesh.notes,
        ["t.ply: faces of fewer than three vertices are left out: 2"]
    );
}

#[test]
fn headers_that_cannot_be_meant_are_refused_in_words() {
    let body = format!("{CORNERS}{FACES}");
    let list = |line: &str| format!("2\nproperty {line}\n");
    for (text, expected) in [
        (
            square("property float x\n", LIST, &body),
            "property `x` of `vertex` is declared twice",
        ),
        (
            square("element vertex 4\nproperty float x\n", LIST, &body),
            "element `vertex` is declared twice",
        ),
        (
            square("", &list("list uchar int Vertex_Indices"), &body),
            "a list `vertex_indices` was expected, its properties are: Vertex_Indices",
        ),
        (
            square("", &list("list uchar float vertex_indices"), &body),
            "must be whole numbers, not float",
        ),
        (
            square("", &list("int vertex_indices"), &body),
            "must be a list",
        ),
        (
            square("", LIST, &body.replace("3 0 1 2", "3 0 1 -2")),
            "face 0 (from 0) names vertex -2, the file has 4",
        ),
        (
            "version https://git-lfs.github.com/spec/v1\n".into(),
            "a pointer of Git LFS",
        ),
    ] {
        let error = told(&text).unwrap_err();
        assert!(error.contains(expected), "{error} ({expected})");
    }
}
