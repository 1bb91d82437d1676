//! Small glTF files, put together in memory.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use lightbench::scene::{SceneDescription, find_scene_in};
use serde_json::{Value, json};

pub const FLOAT: u32 = 5126;
pub const BYTES: u32 = 5121;
pub const SHORTS: u32 = 5123;

/// The parts of a file; its one buffer is `data`.
#[derive(Clone)]
pub struct File {
    pub json: Value,
    pub data: Vec<u8>,
}

impl File {
    /// A triangle in the xy plane that faces +z, of one mesh of one node.
    pub fn triangle() -> Self {
        let mut file = Self {
            json: json!({
                "asset": { "version": "2.0" },
                "scene": 0,
                "scenes": [{ "nodes": [0] }],
                "nodes": [{ "mesh": 0 }],
                "meshes": [{ "primitives": [{ "attributes": {} }] }],
                "accessors": [],
                "bufferViews": [],
                "materials": [],
            }),
            data: Vec::new(),
        };
        let corners = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let positions = file.accessor(&corners, FLOAT, "VEC3", 3);
        file.set(
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(positions),
        );
        file
    }

    /// Adds an accessor with a buffer view of its own; its index.
    pub fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({ "bufferView": view, "componentType": component, "type": kind, "count": count });
        self.push("/accessors", accessor)
    }

    /// Adds a buffer view; its index.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.data.len(), "byteLength": bytes.len() });
        self.data.extend(bytes);
        self.push("/bufferViews", view)
    }

    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self
            .json
            .pointer_mut(list)
            .and_then(Value::as_array_mut)
            .expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// Sets what a pointer names; the object around it must be there.
    pub fn set(&mut self, pointer: &str, value: Value) {
        let (around, key) = pointer.rsplit_once('/').expect("a pointer");
        let around = self
            .json
            .pointer_mut(around)
            .unwrap_or_else(|| panic!("{pointer}"));
        match around {
            Value::Array(items) => items[key.parse::<usize>().expect("an index")] = value,
            around => around[key] = value,
        }
    }

    pub fn with(mut self, pointer: &str, value: Value) -> Self {
        self.set(pointer, value);
        self
    }

    /// As text, its buffer in a data URI unless it says something of its buffers.
    pub fn text(&self) -> String {
        let mut json = self.json.clone();
        if json.get("buffers").is_none() {
            json["buffers"] =
                json!([{ "byteLength": self.data.len(), "uri": data_uri(&self.data) }]);
        }
        json.to_string()
    }

    /// As a GLB file.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.data.len() }]);
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut data = self.data.clone();
        data.resize(data.len().next_multiple_of(4), 0);
        let mut bytes = [b"glTF".as_slice(), &2_u32.to_le_bytes(), &[0; 4]].concat();
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &data)] {
            bytes.extend((chunk.len() as u32).to_le_bytes());
            bytes.extend(kind);
            bytes.extend(chunk);
        }
        let length = (bytes.len() as u32).to_le_bytes();
        bytes[8..12].copy_from_slice(&length);
        bytes
    }

    pub fn load(&self) -> Result<SceneDescription, String> {
        load_bytes(self.text().as_bytes(), "s.gltf")
    }
}

/// Loads the bytes of a file; errors are what a user reads, without the folder. Every file has a folder of its
/// own below that of the tests, because scenes read from it later.
pub fn load_bytes(bytes: &[u8], name: &str) -> Result<SceneDescription, String> {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("gltf/{number}"));
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("writable");
    load_file(&path)
}

pub fn load_file(path: &Path) -> Result<SceneDescription, String> {
    let folder = path.parent().expect("a folder").display().to_string();
    let scene = find_scene_in(&path.to_string_lossy(), &[]);
    scene.map_err(|e| e.to_string().replace(&format!("{folder}/"), ""))
}

pub fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub fn shorts(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub fn data_uri(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::from("data:application/octet-stream;base64,");
    for group in bytes.chunks(3) {
        let bits = group
            .iter()
            .fold(0_u32, |bits, b| bits << 8 | u32::from(*b))
            << (8 * (3 - group.len()));
        for i in 0..4 {
            let sextet = bits >> (18 - 6 * i) & 63;
            text.push(if i <= group.len() {
                char::from(LETTERS[sextet as usize])
            } else {
                '='
            });
        }
    }
    text
}
