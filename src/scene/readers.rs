//! Every reader of scene files, of bytes: what fuzzing and its tests call.

use std::path::Path;

use super::mesh_mtl::read_mtl;
use super::mesh_obj::ObjFile;
use super::mesh_ply::parse_ply;
use super::mesh_serialized::parse_serialized;
use super::texture_file::try_texture;
use super::{gltf, load_toml, mitsuba};

/// A format, and its reader: `Err` is what a user would be told.
pub(crate) type Reader = (&'static str, fn(&[u8]) -> Result<(), String>);

/// Name that messages carry; nothing is there, so that no file is opened beside it.
const NOWHERE: &str = "/nowhere/bytes";

/// All readers of scenes, meshes, materials and textures.
pub(crate) const READERS: &[Reader] = &[
    ("scene-toml", |bytes| {
        let text = String::from_utf8_lossy(bytes);
        told(load_toml::parse_toml(
            &text,
            Some(Path::new(NOWHERE)),
            "bytes",
        ))
    }),
    ("mitsuba", |bytes| {
        told(mitsuba::parse_mitsuba(bytes, Path::new(NOWHERE)))
    }),
    ("gltf", |bytes| {
        told(gltf::parse_gltf(bytes, Path::new(NOWHERE)))
    }),
    ("obj", |bytes| {
        let file = ObjFile::parse(bytes, Path::new(NOWHERE));
        told(file.and_then(|file| file.mesh(None, None)))
    }),
    ("mtl", |bytes| {
        read_mtl(bytes, Path::new(NOWHERE));
        Ok(())
    }),
    ("ply", |bytes| told(parse_ply(bytes, Path::new(NOWHERE)))),
    ("serialized", |bytes| told(parse_serialized(bytes, 0))),
    // PNG, JPEG, BMP, and what is none of these as TGA.
    ("texture", |bytes| {
        told(try_texture(bytes, Path::new("/nowhere/bytes.tga")))
    }),
];

fn told<T, E: std::fmt::Display>(read: Result<T, E>) -> Result<(), String> {
    read.map(|_| ()).map_err(|error| error.to_string())
}
