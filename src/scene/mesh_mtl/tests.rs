use super::*;

fn parsed(text: &str) -> (Vec<MtlMaterial>, Vec<String>) {
    let mut notes = Vec::new();
    let materials = parse_mtl(text, Path::new("d/m.mtl"), &mut notes);
    (materials, notes)
}

#[test]
fn libraries_are_read_and_what_is_not_understood_is_noted() {
    let text = "# x\nnewmtl a b\nKd 0.1 0.2 0.3 1 # brown\nKs 0.04\nNs 48\nTr 0.25\nmap_Kd -s 1 1 1 t\\x y.png\nillum 2\nnewmtl c\n";
    let (materials, notes) = parsed(text);
    assert_eq!((materials.len(), notes.len()), (2, 0), "{notes:?}");
    let m = &materials[0];
    assert_eq!(
        (m.name.as_str(), m.diffuse, m.opacity),
        ("a b", Some([0.1, 0.2, 0.3]), 0.75)
    );
    let map = m.diffuse_map.clone().unwrap();
    assert_eq!(map.file, Path::new("d/t/x y.png"));
    assert!((phong_alpha(m.exponent) - 0.2).abs() < 1e-6);
    for (line, expected) in [
        (
            "Kd 0.1 0.2",
            "d/m.mtl:2: `Kd` is left out: one or three numbers",
        ),
        (
            "Kd spectral file.rfl 1",
            "d/m.mtl:2: `Kd` is left out: one or three",
        ),
        ("Kd nan 0 0", "d/m.mtl:2: `Kd` is left out: one or three"),
        (
            "Kd 0.6 0.3x 0.1",
            "d/m.mtl:2: `Kd` is left out: one or three numbers were expected, found `0.6 0.3x 0.1`",
        ),
        ("Ke 3 nan 1", "d/m.mtl:2: `Ke` is left out: one or three"),
        ("Ke 1e39", "d/m.mtl:2: `Ke` is left out: one or three"),
        (
            "Kd -0.8 0.5 1.8",
            "d/m.mtl:2: `Kd` is out of range and clamped",
        ),
        (
            "map_Kd",
            "d/m.mtl:2: `map_Kd` is left out: a file was expected",
        ),
        (
            "map_d -imfchan l x.png",
            "d/m.mtl:2: `-imfchan l` of a map is left out",
        ),
        (
            "map_Kd -q 1 x.png",
            "d/m.mtl:2: `map_Kd` is left out: option `-q`",
        ),
    ] {
        let (materials, notes) = parsed(&format!("newmtl a\n{line}\nNs 7\n"));
        assert!(notes[0].starts_with(expected), "{notes:?}");
        assert_eq!((notes.len(), materials[0].exponent), (1, 7.0));
        let mut diffuse = materials[0].diffuse.iter().flatten();
        assert!(diffuse.all(|d| (0.0..=1.0).contains(d)));
    }
}

#[test]
fn comments_may_touch_numbers_but_not_names() {
    let (materials, notes) = parsed("newmtl a#1\nKd .6 .3 .1#x\nNs 7# 8 9\nmap_Kd b#1.png\n");
    assert!(notes.is_empty(), "{notes:?}");
    let m = &materials[0];
    assert_eq!((m.diffuse, m.exponent), (Some([0.6, 0.3, 0.1]), 7.0));
    let map = m.diffuse_map.as_ref().unwrap();
    assert_eq!(
        (m.name.as_str(), &*map.file),
        ("a#1", Path::new("d/b#1.png"))
    );
}

#[test]
fn options_of_maps_that_are_not_finite_are_noted_and_left_out() {
    for option in [
        "-s nan 2 1",
        "-o inf 0 0",
        "-s 1e39 1",
        "-mm nan 1",
        "-mm 0 inf",
        "-s x 2",
    ] {
        let (materials, notes) = parsed(&format!("newmtl a\nmap_Kd {option} -clamp on a.png\n"));
        let note = format!("d/m.mtl:2: `{option}` of a map is left out: expected finite numbers");
        assert_eq!(notes, [note]);
        let expected = MtlMap {
            file: "d/a.png".into(),
            clamp: true,
            ..MtlMap::default()
        };
        let mut map = materials[0].diffuse_map.clone().unwrap();
        map.left_out.clear();
        assert_eq!(map, expected);
    }
}

#[test]
fn what_would_shine_or_bend_normals_elsewhere_is_not_left_out_in_silence() {
    let (_, notes) =
        parsed("newmtl lamp\nKa 1\nmap_Ke four.png\nmap_kd x.png\nillum 2\nbump b.png\n");
    let left: Vec<bool> = [
        "d/m.mtl:3: `map_Ke`",
        "d/m.mtl:4: `map_kd`",
        "d/m.mtl:6: `bump`",
    ]
    .iter()
    .zip(&notes)
    .map(|(start, note)| note.starts_with(start))
    .collect();
    assert_eq!(left, [true; 3], "{notes:?}");
}

#[test]
fn options_of_maps_are_followed() {
    let map = |text: &str| MtlMap::read(text, Path::new("d")).unwrap();
    let twice = map("-s 2 3 1 -o 0.25 0 0 a.png");
    assert_eq!((twice.scale, twice.offset), ([2.0, 3.0], [0.25, 0.0]));
    let short = map("-bm 0.5 -s 2 -clamp on -o 0.5 0.5 -1.png");
    assert_eq!((short.scale, short.offset), ([2.0, 1.0], [0.5; 2]));
    assert_eq!(
        (short.file.as_path(), short.clamp),
        (Path::new("d/-1.png"), true)
    );
    assert_eq!(map("-mm 0 1 wood 2.png").file, Path::new("d/wood 2.png"));
    let dimmed = map("-mm 0.1 0.5 -t 1 -cc on -imfchan l a.png");
    assert_eq!(
        (dimmed.gain, dimmed.base, dimmed.left_out.len()),
        (0.5, 0.1, 3)
    );
    assert!(map("-t 0 0 0 -mm 0 2 -cc off a.png").left_out.is_empty());
}

#[test]
fn what_would_bend_or_colour_what_passes_is_told() {
    for (text, told) in [
        ("Ni 1.5\nTf 0.5\nillum 2", vec![]),
        ("Ni 1.0\nTf 1 1 1\nd 0.5", vec![]),
        ("d 0.5\nNi 1.5\nTf 0.5 1 1", vec!["`Ni`", "`Tf`"]),
        ("illum 7\nNi 1.5\nTf 1", vec!["`illum 7`"]),
        ("Ks 0.5\nillum 1", vec!["`illum 1`"]),
        ("Ks 0\nillum 1", vec![]),
        ("illum 10", vec!["`illum 10`"]),
        ("map_Kd -mm 0.2 1 a.png", vec![]),
        ("map_d -mm 0.2 1 a.png", vec!["`-mm`"]),
    ] {
        for text in [
            format!("newmtl a\n{text}\nnewmtl b\n"),
            format!("newmtl a\n{text}\n"),
        ] {
            let (_, notes) = parsed(&text);
            assert_eq!(notes.len(), told.len(), "{text}: {notes:?}");
            let found = notes.iter().zip(&told);
            assert!(
                found.into_iter().all(|(note, word)| note.contains(word)),
                "{notes:?}"
            );
        }
    }
}

#[test]
fn d_decides_where_tr_stands_too() {
    for (text, opacity) in [("d 1\nTr 1", 1.0), ("Tr 1\nd 1", 1.0), ("Tr 0.25", 0.75)] {
        let (materials, _) = parsed(&format!("newmtl a\n{text}\nnewmtl b\nTr 1\n"));
        assert_eq!(
            (materials[0].opacity, materials[1].opacity),
            (opacity, 0.0),
            "{text}"
        );
    }
}

#[test]
fn several_libraries_may_stand_on_a_line_and_names_may_have_blanks() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(place.path().join(name), text).unwrap();
    write("a.mtl", "newmtl red\nKd 0.8 0.1 0.1\n");
    write("b.mtl", "newmtl blue\nKd 0.1 0.1 0.8\n");
    write(
        "c d.mtl",
        "newmtl red\nKd 0.2 0 0\nnewmtl blue\nKd 0 0 0.2\n",
    );
    let faces =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 2 3\nusemtl gone\n";
    for (line, red) in [
        ("a.mtl b.mtl", 0.8),
        ("c d.mtl", 0.2),
        ("\"c d.mtl\"", 0.2),
        ("\"a.mtl\" \"b.mtl\"", 0.8),
    ] {
        write("m.obj", &format!("mtllib {line}\n{faces}"));
        let ObjMaterials {
            materials, notes, ..
        } = materials_of(&place.path().join("m.obj"), None).unwrap();
        assert!(notes.is_empty(), "{notes:?}");
        let found: Vec<f32> = materials
            .iter()
            .filter_map(|m| m.diffuse)
            .flat_map(|diffuse| [diffuse[0], diffuse[2]])
            .collect();
        assert_eq!((found[0], found[3]), (red, red));
        assert_eq!(materials.len(), 2, "nothing has the third");
    }
}

#[test]
fn names_of_textures_may_stand_in_quotes() {
    let (materials, notes) = parsed("newmtl a\nmap_Kd -s 2 2 \"t\\x y.png\"\n");
    assert!(notes.is_empty(), "{notes:?}");
    let map = materials[0].diffuse_map.as_ref().unwrap();
    assert!(map.file.ends_with("t/x y.png"), "{}", map.file.display());
}

#[test]
fn of_two_materials_of_one_name_the_first_counts_and_that_is_told() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(place.path().join(name), text).unwrap();
    let faces = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
    write("m.obj", faces);
    for (other, told) in [("newmtl red\nKd 0 1 0\n", 1), ("newmtl red\nKd 1 0 0\n", 0)] {
        write("a.mtl", &format!("newmtl red\nKd 1 0 0\n{other}"));
        let ObjMaterials {
            materials, notes, ..
        } = materials_of(&place.path().join("m.obj"), None).unwrap();
        assert_eq!(materials[0].diffuse, Some([1.0, 0.0, 0.0]));
        assert_eq!(notes.len(), told, "{notes:?}");
    }
}

#[test]
fn the_base_value_of_opacity_is_told() {
    let (_, notes) = parsed("newmtl a\nmap_Kd -mm 0.1 0.5 a.png\nmap_d -mm 0.1 0.5 a.png\n");
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!(notes[0].contains(":3: the base value"), "{notes:?}");
}

#[test]
fn what_belongs_to_no_material_is_told() {
    let (materials, notes) = parsed("# head\n\nKd 1 0 0\nnewmtl a\nKd 0 1 0\n");
    assert_eq!(materials[0].diffuse, Some([0.0, 1.0, 0.0]));
    assert_eq!(
        notes,
        ["d/m.mtl:3: `Kd` is left out: it stands before the first `newmtl`"]
    );
}

#[test]
fn a_library_is_absent_where_a_face_uses_what_no_other_has() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(place.path().join(name), text).unwrap();
    write("a.mtl", "newmtl red\nKd 1 0 0\n");
    let corners = "mtllib a.mtl\nmtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (faces, absent) in [
        ("f 1 2 3\n", 0),
        ("usemtl red\nf 1 2 3\nusemtl blue\n", 0),
        ("usemtl red\nf 1 2 3\nusemtl blue\nf 1 2 3\n", 1),
    ] {
        write("m.obj", &format!("{corners}{faces}"));
        let found = materials_of(&place.path().join("m.obj"), None).unwrap();
        assert_eq!(found.absent_libraries.len(), absent, "{faces}");
        assert!(found.notes[0].contains("gone.mtl"), "{:?}", found.notes);
    }
}
