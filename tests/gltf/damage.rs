//! Bad files: a clear error with a place, never a panic.

use serde_json::{Value, json};

use crate::builder::{BYTES, FLOAT, File, floats, load_bytes, shorts};

/// Loads the triangle with something set.
fn error(pointer: &str, value: Value) -> String {
    File::triangle()
        .with(pointer, value)
        .load()
        .expect_err(pointer)
}

#[test]
fn wrong_structure_has_a_place() {
    for (pointer, value, expected) in [
        ("/scene", json!(3), "scene"),
        ("/scenes/0/nodes/0", json!(7), "scenes[0].nodes[0]"),
        ("/nodes/0/mesh", json!(9), "nodes[0].mesh"),
        ("/nodes/0/mesh", json!(-1), "s.gltf:1:"),
        ("/nodes/0/mesh", json!("x"), "s.gltf:1:"),
        ("/nodes/0/camera", json!(0), "nodes[0].camera"),
        ("/nodes/0/children", json!([0]), "node 0: is reached twice"),
        (
            "/nodes",
            json!([{ "mesh": 0 }, { "children": [2] }, { "children": [1] }]),
            "node 1: no way leads to it from a node without a parent: nodes form a circle",
        ),
        (
            "/nodes/0/rotation",
            json!([0, 0, 0, 0]),
            "node 0: its rotation",
        ),
        (
            "/nodes/0/scale",
            json!([1e38, 1e39, 1]),
            "node 0: its place in the world is not finite",
        ),
        (
            "/nodes/0/matrix",
            json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "last row",
        ),
        ("/nodes/0/matrix", json!([1, 0, 0]), "s.gltf:1:"),
        ("/nodes/0/skin", json!(0), "skin"),
        ("/asset/version", json!("1.0"), "glTF 1.0"),
        ("/asset/minVersion", json!("2.1"), "glTF 2.1"),
        (
            "/meshes/0/primitives/0/mode",
            json!(7),
            "meshes[0].primitives[0].mode",
        ),
        (
            "/meshes/0/primitives/0/mode",
            json!(1),
            "nothing in it has triangles",
        ),
        ("/meshes/0/primitives/0/material", json!(0), "material"),
        (
            "/meshes/0/primitives/0/indices",
            json!(4),
            "meshes[0].primitives[0].indices",
        ),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(4),
            "accessor 4 is not there",
        ),
        (
            "/meshes/0/primitives/0/attributes/NORMAL",
            json!(4),
            "accessor 4 is not there",
        ),
        (
            "/accessors/0/bufferView",
            json!(5),
            "accessors[0].bufferView",
        ),
        ("/accessors/0/type", json!("VEC2"), "accessor 0: holds VEC2"),
        ("/accessors/0/type", json!("VEC5"), "accessors[0].type"),
        (
            "/accessors/0/componentType",
            json!(5125),
            "accessor 0: holds VEC3",
        ),
        (
            "/accessors/0/count",
            json!(4),
            "accessor 0: reaches beyond its buffer view",
        ),
        (
            "/accessors/0/count",
            json!(0),
            "accessor 0: has no elements",
        ),
        ("/accessors/0/count", json!(u64::MAX), "accessor 0: "),
        (
            "/accessors/0/byteOffset",
            json!(u64::MAX),
            "accessor 0: reaches beyond",
        ),
        (
            "/bufferViews/0/byteLength",
            json!(1000),
            "buffer view 0 reaches",
        ),
        (
            "/bufferViews/0/byteOffset",
            json!(u64::MAX),
            "buffer view 0 reaches",
        ),
        ("/bufferViews/0/byteStride", json!(8), "a stride of 8"),
        ("/bufferViews/0/buffer", json!(1), "bufferViews[0].buffer"),
        (
            "/buffers",
            json!([{ "byteLength": 36 }]),
            "buffer 0: has no `uri`",
        ),
        (
            "/buffers",
            json!([{ "byteLength": 36, "uri": "gone.bin" }]),
            "gone.bin: No such file",
        ),
        (
            "/buffers",
            json!([{ "byteLength": 36, "uri": "data:,x" }]),
            "has 1 bytes, 36 are declared",
        ),
        (
            "/buffers",
            json!([{ "byteLength": 36, "uri": "data:;base64,*" }]),
            "not base64",
        ),
        (
            "/buffers",
            json!([{ "byteLength": 36, "uri": "http://x/y.bin" }]),
            "http://",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "KHR_draco_mesh_compression cannot be read",
        ),
        ("/extensionsRequired", json!(["X_new"]), "X_new"),
        ("/nodes/0/weights", json!([0.5]), "morph targets"),
    ] {
        let found = error(pointer, value.clone());
        assert!(
            found.starts_with("s.gltf:") && found.contains(expected),
            "{pointer} = {value}: {found}"
        );
    }
}

#[test]
fn wrong_vertices_have_a_place() {
    for (at, value) in [(0, f32::NAN), (4, f32::INFINITY)] {
        let mut file = File::triangle();
        file.data[4 * at..4 * at + 4].copy_from_slice(&value.to_le_bytes());
        let found = file.load().expect_err("not finite");
        let expected = format!(
            "mesh 0, primitive 0: POSITION {} of accessor 0 is not finite",
            at / 3
        );
        assert!(found.contains(&expected), "{found}");
    }
    let mut file = File::triangle();
    let normals = file.accessor(&floats(&[0.0; 6]), FLOAT, "VEC3", 2);
    file.set("/meshes/0/primitives/0/attributes/NORMAL", json!(normals));
    let found = file.load().expect_err("too few");
    assert!(
        found.contains("NORMAL (accessor 1) has 2 elements, POSITION 3"),
        "{found}"
    );
    let mut file = File::triangle();
    let indices = file.accessor(&[0, 1, 3], BYTES, "SCALAR", 3);
    file.set("/meshes/0/primitives/0/indices", json!(indices));
    file.set("/meshes/0/name", json!("flag"));
    let found = file.load().expect_err("out of range");
    let expected = "mesh 0 `flag`, primitive 0: index 2 of accessor 1 is vertex 3, there are 3";
    assert!(found.contains(expected), "{found}");
}

#[test]
fn wrong_sparse_accessors_have_a_place() {
    let mut file = File::triangle();
    let indices = file.view(&shorts(&[7]));
    let values = file.view(&floats(&[1.0; 3]));
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": 5123 },
        "values": { "bufferView": values },
    });
    let file = file.with("/accessors/0/sparse", sparse);
    let found = file.load().expect_err("out of range");
    assert!(
        found.contains("accessor 0: replaces element 7, it has 3"),
        "{found}"
    );
    let short = file.with("/accessors/0/sparse/count", json!(2));
    assert!(
        short
            .load()
            .expect_err("too few")
            .contains("reaches beyond")
    );
}

#[test]
fn morphs_and_materials_out_of_range_are_refused() {
    let found = File::triangle()
        .with("/meshes/0/primitives/0/targets", json!([{ "POSITION": 0 }]))
        .with("/meshes/0/weights", json!([0.5]));
    assert!(
        found
            .load()
            .expect_err("a morph")
            .contains("mesh 0: morph targets")
    );
    let still = found.with("/meshes/0/weights", json!([0]));
    assert!(
        still
            .load()
            .expect("at rest")
            .notes
            .iter()
            .any(|n| n.contains("morph targets"))
    );
    for (pbr, expected) in [
        (
            json!({ "baseColorFactor": [2, 0, 0, 1] }),
            "material 0: baseColorFactor",
        ),
        (
            json!({ "metallicFactor": -1 }),
            "material 0: metallicFactor",
        ),
        (json!({ "baseColorTexture": { "index": 0 } }), "index"),
    ] {
        let mut file = File::triangle().with("/meshes/0/primitives/0/material", json!(0));
        file.push("/materials", json!({ "pbrMetallicRoughness": pbr }));
        let found = file.load().expect_err(expected);
        assert!(found.contains(expected), "{found}");
    }
    let mut file = File::triangle().with("/meshes/0/primitives/0/material", json!(0));
    file.push(
        "/materials",
        json!({ "name": "hot", "emissiveFactor": [-1, 0, 0] }),
    );
    assert!(
        file.load()
            .expect_err("dark")
            .contains("material 0 `hot`: its emission")
    );
}

#[test]
fn truncated_and_spoilt_files_never_panic() {
    let glb = File::triangle().glb();
    for length in 0..glb.len() {
        load_bytes(&glb[..length], "s.glb").expect_err("truncated");
    }
    assert!(load_bytes(&glb, "s.glb").is_ok());
    let moving = std::fs::read(crate::committed("moving")).expect("a file");
    // Every byte of the triangle, and many of the moving file, replaced by others.
    let text = File::triangle().text().into_bytes();
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize
    };
    for (bytes, rounds) in [(&text, 1500), (&glb, 700), (&moving, 500)] {
        for _ in 0..rounds {
            let mut spoilt = bytes.clone();
            let at = random() % spoilt.len();
            spoilt[at] = b"0123456789-\"[]{}e.,x\xff\0"[random() % 22];
            let name = if bytes == &glb { "s.glb" } else { "s.gltf" };
            let _ = load_bytes(&spoilt, name);
        }
    }
}
