//! What is read of meshes, nodes, cameras and lights.

use glam::{DVec3, Vec2, Vec3};
use lightbench::scene::{FovAxis, LightKind, Needs, Scene, SceneDescription};
use serde_json::json;

use crate::builder::{BYTES, FLOAT, File, SHORTS, floats, load_bytes, load_file, shorts};

pub fn built(description: &SceneDescription) -> Scene {
    Scene::build(description, Needs::ALL).expect("builds")
}

/// Positions of a scene in the coordinates of its file.
fn positions(scene: &Scene) -> Vec<Vec3> {
    let positions = scene.positions.iter();
    positions
        .map(|p| (p.as_dvec3() + scene.origin).as_vec3())
        .collect()
}

fn fronts(scene: &Scene) -> Vec<Vec3> {
    let corner = |i: u32| scene.positions[i as usize];
    let normal = |t: &[u32; 3]| (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0]));
    scene
        .triangles
        .iter()
        .map(|t| normal(t).normalize())
        .collect()
}

#[test]
fn all_containers_hold_the_same() {
    let file = File::triangle();
    let embedded = built(&file.load().expect("loads"));
    let binary = built(&load_bytes(&file.glb(), "s.glb").expect("loads"));
    let folder = tempfile::tempdir().expect("a folder");
    let beside = json!([{ "byteLength": file.data.len(), "uri": "my%20buffer.bin" }]);
    std::fs::write(folder.path().join("my buffer.bin"), &file.data).expect("writable");
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, file.clone().with("/buffers", beside).text()).expect("writable");
    let external = built(&load_file(&path).expect("loads"));
    let by_folder = built(&load_file(folder.path()).expect("a folder with scene.gltf is a scene"));
    for scene in [&binary, &external, &by_folder] {
        assert_eq!(scene.positions, embedded.positions);
        assert_eq!(scene.triangles, embedded.triangles);
    }
    assert_eq!(embedded.metres_per_unit, 1.0);
}

#[test]
fn every_mode_of_triangles_faces_the_same_way() {
    // Two triangles that make the unit square, and a third one in a strip and a fan.
    let corners = |list: &[[f32; 2]]| {
        let flat: Vec<f32> = list.iter().flat_map(|p| [p[0], p[1], 0.0]).collect();
        floats(&flat)
    };
    let [a, b, c, d, e] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 2.0]];
    for (mode, list, count) in [
        (4, vec![a, b, c, a, c, d], 2),
        (5, vec![a, b, d, c, e], 3),
        (6, vec![a, b, c, d, [-1.0, 1.0]], 3),
        (4, vec![a, b, c, a, c], 1),
    ] {
        let mut file = File::triangle();
        let at = file.accessor(&corners(&list), FLOAT, "VEC3", list.len());
        file.set("/meshes/0/primitives/0/attributes/POSITION", json!(at));
        file.set("/meshes/0/primitives/0/mode", json!(mode));
        let scene = built(&file.load().expect("loads"));
        assert_eq!(fronts(&scene), vec![Vec3::Z; count], "mode {mode}");
    }
}

#[test]
fn indices_of_every_size_and_sparse_positions() {
    let bytes = [2_u8, 1, 0];
    let wide = [2_u32, 1, 0].map(u32::to_le_bytes).concat();
    for (stored, component) in [
        (bytes.to_vec(), BYTES),
        (shorts(&[2, 1, 0]), SHORTS),
        (wide, 5125),
    ] {
        let mut file = File::triangle();
        let indices = file.accessor(&stored, component, "SCALAR", 3);
        file.set("/meshes/0/primitives/0/indices", json!(indices));
        assert_eq!(fronts(&built(&file.load().expect("loads"))), [Vec3::NEG_Z]);
    }
    let mut file = File::triangle();
    let indices = file.view(&[1, 2]);
    let values = file.view(&floats(&[3.0, 0.0, 0.0, 0.0, 5.0, 0.0]));
    let sparse = json!({
        "count": 2,
        "indices": { "bufferView": indices, "componentType": BYTES },
        "values": { "bufferView": values },
    });
    file.set("/accessors/0/sparse", sparse);
    let expected = [Vec3::ZERO, Vec3::X * 3.0, Vec3::Y * 5.0];
    assert_eq!(positions(&built(&file.load().expect("loads"))), expected);
    let accessor = file.json["accessors"][0]
        .as_object_mut()
        .expect("an object");
    accessor.remove("bufferView");
    assert_eq!(
        positions(&built(&file.load().expect("zeros but those"))),
        expected
    );
}

#[test]
fn texture_coordinates_may_be_integers_and_count_from_the_top() {
    let stored = shorts(&[0, 0, 65535, 0, 13107, 65535]);
    let bytes = [0, 0, 255, 0, 51, 255];
    for (stored, component) in [(stored, SHORTS), (bytes.to_vec(), BYTES)] {
        let mut file = File::triangle();
        let uvs = file.accessor(&stored, component, "VEC2", 3);
        file.set(&format!("/accessors/{uvs}/normalized"), json!(true));
        file.set("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(uvs));
        let scene = built(&file.load().expect("loads"));
        assert_eq!(
            scene.uvs,
            [Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(0.2, 0.0)]
        );
    }
}

#[test]
fn texture_coordinates_that_are_not_normalised_need_an_extension() {
    let mut file = File::triangle();
    let uvs = file.accessor(&[0, 0, 1, 0, 0, 1], BYTES, "VEC2", 3);
    file.set("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(uvs));
    let error = file.load().unwrap_err();
    assert!(error.contains("not normalised"), "{error}");
    file.set("/extensionsUsed", json!(["KHR_mesh_quantization"]));
    let scene = built(&file.load().expect("loads"));
    assert_eq!(scene.uvs, [Vec2::Y, Vec2::ONE, Vec2::ZERO]);
}

#[test]
fn nodes_hang_below_each_other_and_mirrors_keep_the_front() {
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    let file = File::triangle()
        .with("/scenes/0/nodes/0", json!(1))
        .with(
            "/nodes",
            json!([
                { "mesh": 0, "name": "leaf", "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 0, 0, 1] },
                { "children": [0, 2], "translation": [0, 0, 5], "rotation": [0, quarter, 0, quarter] },
                { "mesh": 0, "name": "leaf", "scale": [-1, 1, 1] },
            ]),
        );
    let description = file.load().expect("loads");
    let names: Vec<&str> = description.shapes.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["leaf", "leaf (node 2)"]);
    let scene = built(&description);
    // A quarter turn about y takes x to −z and z to x.
    let expected = [
        [0.0, 0.0, 4.0],
        [0.0, 0.0, 2.0],
        [0.0, 2.0, 4.0],
        [0.0, 0.0, 5.0],
        [0.0, 0.0, 6.0],
        [0.0, 1.0, 5.0],
    ];
    for (found, expected) in positions(&scene).iter().zip(expected) {
        assert!(
            found.distance(Vec3::from(expected)) < 1e-6,
            "{found} {expected:?}"
        );
    }
    for front in fronts(&scene) {
        assert!(front.distance(Vec3::X) < 1e-6, "{front}");
    }
}

#[test]
fn scenes_are_chosen_and_cameras_become_views() {
    let file = File::triangle()
        .with(
            "/nodes",
            json!([
                { "mesh": 0 },
                { "name": "eye", "camera": 0, "translation": [1, 2, 3], "scale": [2, 2, 2] },
                { "camera": 1 },
            ]),
        )
        .with("/scenes", json!([{}, { "nodes": [0, 1, 2] }]))
        .with("/scene", json!(1))
        .with(
            "/cameras",
            json!([
                { "type": "perspective", "perspective": { "yfov": 1.0, "aspectRatio": 2.0, "znear": 0.1 } },
                { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0, "zfar": 1 } },
            ]),
        );
    let scene = file.load().expect("loads");
    let [view] = scene.views.as_slice() else {
        panic!("one view")
    };
    assert_eq!((view.name.as_str(), view.fov_axis), ("eye", FovAxis::Y));
    assert_eq!([view.width, view.height], [1440, 720]);
    assert!((view.fov_deg - 1.0_f64.to_degrees()).abs() < 1e-5);
    assert_eq!(
        [view.origin, view.forward],
        [DVec3::new(1.0, 2.0, 3.0), DVec3::NEG_Z]
    );
    assert_eq!([view.right, view.up], [DVec3::X, DVec3::Y]);
    for note in ["orthographic", "scenes other than scene 1", "no light"] {
        assert!(
            scene.notes.iter().any(|n| n.contains(note)),
            "{note}: {:?}",
            scene.notes
        );
    }
    let mut file = file.with("/cameras/0/perspective/yfov", json!(4));
    assert!(
        file.load()
            .expect_err("too wide")
            .contains("camera 0: its yfov")
    );
    file.json
        .as_object_mut()
        .expect("an object")
        .remove("scene");
    assert!(
        file.load()
            .expect_err("an empty scene 0")
            .contains("nothing in it has triangles")
    );
    file.json
        .as_object_mut()
        .expect("an object")
        .remove("scenes");
    file.set("/cameras/0/perspective/yfov", json!(1));
    assert_eq!(file.load().expect("all roots").shapes.len(), 1);
}

#[test]
fn without_a_camera_everything_is_seen() {
    let scene = File::triangle()
        .with("/nodes/0/scale", json!([30, 1, 2]))
        .load()
        .expect("loads");
    let view = &scene.views[0];
    assert_eq!(view.name, "main");
    for corner in [DVec3::ZERO, DVec3::X * 30.0, DVec3::Y] {
        assert!(
            view.project(corner, [view.width, view.height]).is_some(),
            "{corner}"
        );
    }
    assert!(scene.environment.is_some(), "a file without light is lit");
}

#[test]
fn lights_stand_where_their_nodes_are() {
    let lights = json!([
        { "type": "point", "intensity": 3, "color": [1, 0.5, 0], "range": 9 },
        { "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 } },
        { "type": "directional" },
    ]);
    let node = |light: usize| {
        let extensions = json!({ "KHR_lights_punctual": { "light": light } });
        json!({ "translation": [1, 2, 3], "extensions": extensions })
    };
    let file = File::triangle()
        .with(
            "/extensions",
            json!({ "KHR_lights_punctual": { "lights": lights } }),
        )
        .with("/nodes", json!([{ "mesh": 0 }, node(0), node(1), node(2)]))
        .with("/scenes/0/nodes", json!([0, 1, 2, 3]));
    let scene = file.load().expect("loads");
    let at = DVec3::new(1.0, 2.0, 3.0);
    assert!(
        matches!(&scene.lights[0].kind, LightKind::Point { position, intensity: [3.0, 1.5, 0.0] } if *position == at)
    );
    assert!(
        matches!(&scene.lights[1].kind, LightKind::Spot { direction, beam_width_deg, cutoff_deg, .. }
            if *direction == DVec3::NEG_Z
                && (beam_width_deg.to_radians() - 0.1).abs() < 1e-6
                && (cutoff_deg.to_radians() - 0.2).abs() < 1e-6)
    );
    assert!(
        matches!(&scene.lights[2].kind, LightKind::Directional { direction, irradiance: [1.0, 1.0, 1.0] }
            if *direction == DVec3::NEG_Z)
    );
    assert!(scene.environment.is_none());
    for (pointer, value) in [
        ("intensity", json!(-1)),
        ("color", json!([1, 1, 1e39])),
        ("type", json!("area")),
    ] {
        let file = file.clone().with(
            &format!("/extensions/KHR_lights_punctual/lights/0/{pointer}"),
            value,
        );
        file.load().expect_err(pointer);
    }
}

#[test]
fn buffers_count_by_what_is_in_them() {
    let file = File::triangle();
    let beside = json!([{ "byteLength": file.data.len(), "uri": "b.bin" }]);
    let text = file.clone().with("/buffers", beside).text();
    let key = |data: &[u8]| {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("b.bin"), data).expect("writable");
        std::fs::write(folder.path().join("s.gltf"), &text).expect("writable");
        let scene = load_file(&folder.path().join("s.gltf")).expect("loads");
        lightbench::experiment::scene_key(&scene)
    };
    let mut other = file.data.clone();
    other[8..12].copy_from_slice(&1.0_f32.to_le_bytes());
    assert_eq!(key(&file.data), key(&file.data), "wherever it lies");
    assert_ne!(key(&file.data), key(&other));
}

#[test]
fn what_gltf_does_not_allow_and_viewers_take_is_told() {
    let notes = |file: &File| file.load().expect("loads").notes;
    let told = |file: &File, words: &str| notes(file).iter().any(|note| note.contains(words));
    let mut file = File::triangle();
    file.set("/nodes/0/rotation", json!([0, 0, 0, 2]));
    assert!(told(&file, "no unit quaternion"), "{:?}", notes(&file));
    let one = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    file.set("/nodes/0/matrix", one);
    assert!(
        told(&file, "has a matrix, which counts"),
        "{:?}",
        notes(&file)
    );
    let mut file = File::triangle();
    let five = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 0., 0., 1., 1., 0.];
    let at = file.accessor(&floats(&five), FLOAT, "VEC3", 5);
    file.set("/meshes/0/primitives/0/attributes/POSITION", json!(at));
    file.set("/meshes/0/primitives/0/mode", json!(4));
    assert!(told(&file, "2 corners more"), "{:?}", notes(&file));
    for words in ["quaternion", "matrix", "corners more"] {
        assert!(!told(&File::triangle(), words));
    }
}
