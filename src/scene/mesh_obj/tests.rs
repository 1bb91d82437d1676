use super::*;

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 0.5 0\n";

fn parse(text: &str) -> Result<Mesh, String> {
    let file = ObjFile::parse(text.as_bytes(), Path::new("t.obj"));
    file.and_then(|file| file.mesh(None, None))
        .map(|read| read.mesh)
        .map_err(|e| e.to_string())
}

#[test]
fn relative_indices_equal_absolute_ones() {
    let absolute = parse(&format!("{CORNERS}f 1 2 3\nf 1 3 4\n")).unwrap();
    let relative = parse(&format!("{CORNERS}f -5 -4 -3\nf -5 -3 -2\n")).unwrap();
    assert_eq!(absolute.positions, relative.positions);
    assert_eq!(absolute.triangles, relative.triangles);
}

#[test]
fn polygons_become_fans() {
    let mesh = parse(&format!("{CORNERS}f 1 2 3 4 5\n")).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

/// Area of a mesh in the xy plane, signed.
fn areas(mesh: &Mesh) -> Vec<f64> {
    let corners = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize]);
    let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).z;
    mesh.triangles.iter().map(corners).map(area).collect()
}

#[test]
fn hollow_polygons_are_covered_once() {
    // The hollow corner is the second.
    let arrow = "v 0 2 0\nv 0.5 0.5 0\nv 2 0 0\nv 0 0 0\nvt 0.5\n";
    for face in [
        "f 4 3 2 1",
        "f 3 2 1 4",
        "f -2 -3 -4 -1",
        "f 3/1 2/1 1/1 4/1",
        "f 3 2/1 1 4",
    ] {
        let mesh = parse(&format!("{arrow}{face}\n")).unwrap();
        let areas = areas(&mesh);
        assert_eq!(areas.len(), 2, "{face}");
        let sum: f64 = areas.iter().sum();
        assert!(
            areas.iter().all(|a| *a > 0.0) && (sum - 1.0).abs() < 1e-12,
            "{face}: {areas:?}"
        );
    }
}

#[test]
fn coordinates_of_one_number_have_a_second_of_0() {
    let mesh = parse(&format!("{CORNERS}vt 0.25\nvt 1 # end\nf 1/1 2/2 3/2\n")).unwrap();
    assert_eq!(mesh.uvs[..2], [Vec2::new(0.25, 0.0), Vec2::X]);
    let error = parse(&format!("{CORNERS}vt\nf 1/1 2/1 3/1\n")).unwrap_err();
    assert!(
        error.starts_with("t.obj:6:1: expected 2 numbers"),
        "{error}"
    );
}

#[test]
fn what_is_left_out_is_told() {
    let text = format!("v 9 9 9 1 0 0\n{CORNERS}f 2 3 4\nl 1 2\nl 2 3\n");
    let file = ObjFile::parse(text.as_bytes(), Path::new("t.obj")).unwrap();
    let expected = [
        "t.obj: colours of vertices are left out (1 times)",
        "t.obj: lines (`l`) are left out (2 times)",
    ];
    assert_eq!(file.mesh(None, None).unwrap().notes, expected);
}

#[test]
fn normals_and_coordinates_belong_to_corners() {
    let text = format!(
        "{CORNERS}vt 0 0\nvt 1 0\nvn 0 0 1\nvn 0 0 -1\nf 1/1/1 2/2/1 3/1/1\nf 1/2/2 3/1/2 4/1/2\n"
    );
    let mesh = parse(&text).unwrap();
    assert_eq!(mesh.positions.len(), 6, "vertex 1 and 3 are split");
    assert_eq!(mesh.normals.len(), 6);
    assert_eq!(mesh.normals[mesh.triangles[1][0] as usize], Vec3::NEG_Z);
    assert_eq!(mesh.uvs[mesh.triangles[1][0] as usize], Vec2::X);
}

#[test]
fn corners_without_normal_among_others_get_zero() {
    let text = format!("{CORNERS}vt 0.5 0.25\nvn 0 0 1\nf 1//1 2//1 3//1\nf -5/-1 -3/-1 -2/-1\n");
    let mesh = parse(&text).unwrap();
    assert_eq!(mesh.normals.len(), mesh.positions.len());
    assert_eq!(mesh.uvs.len(), mesh.positions.len());
    assert_eq!(mesh.normals[mesh.triangles[0][0] as usize], Vec3::Z);
    assert_eq!(mesh.normals[mesh.triangles[1][0] as usize], Vec3::ZERO);
    assert_eq!(mesh.uvs[mesh.triangles[0][0] as usize], Vec2::ZERO);
    assert_eq!(
        mesh.uvs[mesh.triangles[1][0] as usize],
        Vec2::new(0.5, 0.25)
    );
}

#[test]
fn groups_are_selected_by_name_and_missing_libraries_tolerated() {
    let text = format!(
        "mtllib gone.mtl\n{CORNERS}g left\nusemtl stone\nf 1 2 3\ng right\nf 1 3 4\nf 1 4 5\n"
    );
    let file = ObjFile::parse(text.as_bytes(), Path::new("t.obj")).unwrap();
    let part = |name| file.mesh(Some(name), None).map(|read| read.mesh);
    assert_eq!(part("right").unwrap().triangles.len(), 2);
    let error = part("rihgt").unwrap_err().to_string();
    assert!(error.contains("did you mean `right`"), "{error}");
    assert_eq!(part("usemtl stone").unwrap().triangles.len(), 3);
}

#[test]
fn libraries_named_again_and_again_do_not_mix_materials_up() {
    let text = format!(
        "{CORNERS}mtllib a.mtl\nusemtl one\nf 1 2 3\nmtllib b.mtl\nusemtl two\nf 1 3 4\nf 1 4 5\n"
    );
    let file = ObjFile::parse(text.as_bytes(), Path::new("t.obj")).unwrap();
    let count = |name| file.mesh(Some(name), None).unwrap().mesh.triangles.len();
    assert_eq!([count("usemtl one"), count("usemtl two")], [1, 2]);
}

#[test]
fn what_other_programs_write_is_read() {
    let quad = "f 1 2 3\nf 1 3 4\n";
    for text in [
        format!("\u{feff}{CORNERS}{quad}"),
        format!("{CORNERS}f 1 2 \\\n3 4\n"),
        format!("{CORNERS}f 1 2 3 # first\nf 1 3 4#second\n"),
        format!("v 9 9 9 1 0 0\n{CORNERS}f 2 3 4 5\nl 1 2 3 4 5\np 1\n"),
        format!("{CORNERS}usemtl\n{quad}"),
        format!("mtllib gone.mtl\n{CORNERS}usemtl red\n{quad}usemtl blue\n"),
        format!("{CORNERS}{quad}").replace('\n', "\r"),
    ] {
        let mesh = parse(&text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
        assert_eq!(mesh.triangles.len(), 2, "{text:?}");
        assert!(mesh.positions.contains(&DVec3::X), "{text:?}");
    }
}

#[test]
fn lines_are_those_of_the_file_where_corners_are_completed() {
    let text = format!("{CORNERS}vn 0 0 1\nvn 0 0 -1.#IND\nf 1//1 2//1 3//1\nf 1 2 3\n");
    let error = parse(&text).unwrap_err();
    assert!(error.starts_with("t.obj:7:1: `-1.#IND`"), "{error}");
}

#[test]
fn damage_is_named_with_its_line() {
    for (text, expected) in [
        (
            "v 0 0 0\nv 1 0\n".to_owned(),
            "t.obj:2:1: the file has no faces",
        ),
        (
            format!("{CORNERS}v 1 2\nf 1 2 3\n"),
            "t.obj:6:1: expected 3 numbers, found 2",
        ),
        (
            format!("{CORNERS}v 1 2 x\nf 1 2 3\n"),
            "t.obj:6:1: `x` is not a number",
        ),
        (
            format!("{CORNERS}f 1 2 3\nf 1 2 9\n"),
            "t.obj:7:1: vertex 9 does not exist",
        ),
        (
            format!("{CORNERS}f 1 2 -9\n"),
            "t.obj:6:1: face corner `-9`",
        ),
        (format!("{CORNERS}f 0 1 2\n"), "t.obj:6:1: face corner `0`"),
        (
            format!("{CORNERS}f 1/7 2/1 3/1\n"),
            "t.obj:6:1: texture coordinate 7",
        ),
        (
            format!("{CORNERS}f 1/-7 2/1 3/1\n"),
            "t.obj:6:1: face corner `1/-7`",
        ),
        (
            format!("{CORNERS}f 1 2 3\nf 1 2"),
            "t.obj:7:1: a face needs 3 corners",
        ),
        (format!("{CORNERS}f 1 2 3/"), ""),
        (format!("{CORNERS}f 1 2 3e"), "t.obj:6:1: face corner `3e`"),
        (String::new(), "t.obj:1:1: the file has no faces"),
    ] {
        match parse(&text) {
            Ok(_) => assert!(expected.is_empty(), "{text:?} should fail"),
            Err(error) => assert!(
                !expected.is_empty() && error.starts_with(expected),
                "{error} should start with {expected}"
            ),
        }
    }
}

#[test]
fn faces_belong_to_each_group_that_a_line_names() {
    let text = format!("{CORNERS}g left top\nf 1 2 3\ng top\nf 1 3 4\no long name\nf 1 4 5\ng x\n");
    let file = ObjFile::parse(text.as_bytes(), Path::new("t.obj")).unwrap();
    let count = |part| {
        file.mesh(Some(part), None)
            .map_or(0, |m| m.mesh.triangles.len())
    };
    assert_eq!(
        ["left", "top", "left top", "long name", "long"].map(count),
        [1, 2, 1, 1, 0]
    );
}

#[test]
fn faces_of_older_versions_are_faces() {
    let mesh = parse(&format!("{CORNERS}fo 1 2 3 4\n")).unwrap();
    assert_eq!(mesh.triangles.len(), 2);
}

#[test]
fn files_without_faces_are_refused_with_what_they_have() {
    for (text, expected) in [
        ("<!DOCTYPE html><html>", "it is a web page"),
        (
            "version https://git-lfs.github.com/spec/v1\n",
            "git lfs pull",
        ),
        (
            "V 0 0 0\nF 1 2 3\n",
            "unknown statements (`F`), 1 times and unknown statements (`V`), 1 times: is it an OBJ",
        ),
        ("v 0 0 0\nf 1,2,3\n", "faces of 1 corners (`f`), 1 times"),
        ("v 0 0 0\n", "is it truncated?"),
    ] {
        let error = parse(text).unwrap_err();
        assert!(
            error.contains("the file has no faces") && error.contains(expected),
            "{error}"
        );
    }
    let padded = format!("{CORNERS}f 1 2 3\n\0\0\x1a");
    let file = ObjFile::parse(padded.as_bytes(), Path::new("t.obj")).unwrap();
    let told = [r"t.obj: unknown statements (`\0\0\u{1a}`) are left out (1 times)"];
    assert_eq!(file.mesh(None, None).unwrap().notes, told);
}
