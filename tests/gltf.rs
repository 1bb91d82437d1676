//! glTF files: what is read, what is made of it, what is refused.

#[path = "gltf/animated.rs"]
mod animated;
#[path = "gltf/builder.rs"]
mod builder;
#[path = "gltf/damage.rs"]
mod damage;
#[path = "gltf/program.rs"]
mod program;
#[path = "gltf/reading.rs"]
mod reading;
#[path = "gltf/samples.rs"]
mod samples;
#[path = "gltf/surfaces.rs"]
mod surfaces;

use std::path::PathBuf;

/// A file of `scripts/gltf-files.py`.
fn committed(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/gltf");
    folder.join(format!("{name}.gltf"))
}
