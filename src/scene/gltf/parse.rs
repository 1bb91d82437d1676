//! From the JSON of a file to the tree of the crate `gltf`, with places in errors.

use std::path::Path;

use ::gltf::json::validation::{Error, Validate};
use ::gltf::json::{Path as Place, Root};
use serde_json::Value;

use crate::scene::SceneError;
use crate::scene::text::file_error;

/// Extensions that a file may require: what they say is read, or does not change what is seen.
pub(super) const READ: [&str; 12] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// Reads and checks the JSON of a file: every index of the tree is of something that is there, and every
/// required extension is one of those that are read.
pub(super) fn parse_root(path: &Path, json: &[u8]) -> Result<Root, SceneError> {
    let root = deserialize(path, json)?;
    check_version(path, &root)?;
    let unknown = root.extensions_required.iter();
    let unknown: Vec<&str> = unknown
        .map(String::as_str)
        .filter(|e| !READ.contains(e))
        .collect();
    if !unknown.is_empty() {
        let message = format!(
            "extensionsRequired: {} cannot be read here",
            unknown.join(", ")
        );
        return Err(file_error(path, message));
    }
    check_positions(path, &root)?;
    let mut first = None;
    root.validate(&root, Place::new, &mut |place, error| {
        let place = place().to_string();
        if first.is_none() && !is_harmless(&place, error) {
            first = Some((place, error));
        }
    });
    match first {
        Some((place, error)) => Err(file_error(path, format!("{place}: {}", in_words(error)))),
        None => Ok(root),
    }
}

fn deserialize(path: &Path, json: &[u8]) -> Result<Root, SceneError> {
    let error = match serde_json::from_slice(json) {
        Ok(root) => return Ok(root),
        Err(error) => error,
    };
    // What glTF lets a file leave out and the crate does not.
    if let Ok(mut value) = serde_json::from_slice::<Value>(json) {
        if let Some(version @ ("1.0" | "1.1")) = version(&value) {
            return Err(file_error(
                path,
                format!("glTF {version} is not read, only 2.0"),
            ));
        }
        complete(&mut value);
        // Through text: to read glTF from values as well would take half a megabyte of program.
        if let Ok(root) = serde_json::from_slice(value.to_string().as_bytes()) {
            return Ok(root);
        }
    }
    let text = error.to_string();
    let message = text
        .rsplit_once(" at line ")
        .map_or(text.as_str(), |(message, _)| message);
    Err(SceneError::At {
        file: path.to_owned(),
        line: error.line().max(1),
        column: error.column().max(1),
        message: message.to_owned(),
    })
}

/// Adds the empty lists of nodes to scenes without any, and takes away channels that animate no node.
fn complete(root: &mut Value) {
    let list = |value: &mut Value, key: &str| match value.get_mut(key) {
        Some(Value::Array(items)) => std::mem::take(items),
        _ => Vec::new(),
    };
    let mut scenes = list(root, "scenes");
    for scene in scenes.iter_mut().filter_map(Value::as_object_mut) {
        scene
            .entry("nodes")
            .or_insert_with(|| Value::Array(Vec::new()));
    }
    let mut animations = list(root, "animations");
    for animation in &mut animations {
        if let Some(Value::Array(channels)) = animation.get_mut("channels") {
            channels.retain(|channel| channel.pointer("/target/node").is_some());
        }
    }
    for (key, items) in [("scenes", scenes), ("animations", animations)] {
        if !items.is_empty() {
            root[key] = Value::Array(items);
        }
    }
}

fn version(root: &Value) -> Option<&str> {
    root.pointer("/asset/version").and_then(Value::as_str)
}

/// A file of a later 2.x is for readers of 2.0 unless it says what it needs.
fn check_version(path: &Path, root: &Root) -> Result<(), SceneError> {
    let asset = &root.asset;
    let needed = asset.min_version.as_ref().unwrap_or(&asset.version);
    let is_read = match asset.min_version {
        Some(_) => needed == "2.0",
        None => needed.starts_with("2."),
    };
    match is_read {
        true => Ok(()),
        false => Err(file_error(
            path,
            format!("asset: glTF {needed} is not read, only 2.0"),
        )),
    }
}

/// The crate looks at the positions of a primitive before it checks that they are there.
fn check_positions(path: &Path, root: &Root) -> Result<(), SceneError> {
    for (i, mesh) in root.meshes.iter().enumerate() {
        for (j, primitive) in mesh.primitives.iter().enumerate() {
            for accessor in primitive.attributes.values() {
                if accessor.value() >= root.accessors.len() {
                    let message = format!(
                        "meshes[{i}].primitives[{j}].attributes: accessor {} is not there",
                        accessor.value()
                    );
                    return Err(file_error(path, message));
                }
            }
        }
    }
    Ok(())
}

/// Complaints of the crate that do not concern us: bounds of positions, which are not used, primitives without
/// positions, attributes of an application's own, and accessors of zeros.
fn is_harmless(place: &str, error: Error) -> bool {
    let of_primitive = place.contains(".attributes");
    error == Error::Unsupported
        || (of_primitive && matches!(error, Error::Invalid | Error::Missing))
        || (error == Error::Missing && place.starts_with("accessors"))
}

fn in_words(error: Error) -> &'static str {
    match error {
        Error::IndexOutOfBounds => "the index is of something that is not there",
        Error::Invalid => "the value is not one that glTF knows",
        Error::Missing => "is missing",
        Error::Oversize => "is too large for this machine",
        Error::Unsupported => "is not supported",
    }
}
