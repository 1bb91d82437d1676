//! `[[shape]]`.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3};
use toml::de::DeValue;

use super::Loader;
use super::keys::{Keys, NUMBER, list, number};
use crate::scene::mesh_mtl::{ObjMaterials, materials_of};
use crate::scene::{SceneError, ShapeDescription, ShapeSource};

const KINDS: [&str; 9] = [
    "obj",
    "ply",
    "serialized",
    "rectangle",
    "cube",
    "sphere",
    "disk",
    "cylinder",
    "generated",
];

impl Loader {
    pub(super) fn shape(&self, keys: &mut Keys) -> Result<ShapeDescription, SceneError> {
        let kind = keys.kind(&KINDS)?;
        let name = match keys.string("name")? {
            Some(name) => name.to_owned(),
            None => format!("{kind} {}", self.scene.shapes.len()),
        };
        keys.what = format!("shape `{name}` ({kind})");
        let source = self.source(kind, keys)?;
        let shape = ShapeDescription {
            to_world: transform(keys)?,
            material: self.material_index(keys)?,
            emission: keys.colour("emission")?,
            flip_normals: keys.boolean("flip_normals", false)?,
            face_normals: keys.boolean("face_normals", false)?,
            smooth_normals: keys.boolean("smooth_normals", false)?,
            ..ShapeDescription::new(&name, source)
        };
        keys.finish()?;
        Ok(shape)
    }

    /// Adds a shape; an OBJ file for which no material is given, or a part of one, becomes one shape for each material
    /// of its libraries.
    pub(super) fn add_shape(
        &mut self,
        shape: ShapeDescription,
        keys: &Keys,
    ) -> Result<(), SceneError> {
        let (obj, part) = match &shape.source {
            ShapeSource::Obj { path, part, .. } if keys.get("material").is_none() => {
                (path.clone(), part.clone())
            }
            _ => {
                self.scene.shapes.push(shape);
                return Ok(());
            }
        };
        let ObjMaterials {
            materials,
            notes,
            absent_libraries,
        } = materials_of(&obj, part.as_deref())?;
        for note in notes {
            // Once for all parts of a file.
            if !self.scene.notes.contains(&note) {
                self.scene.notes.push(note);
            }
        }
        self.scene.absent_libraries.extend(absent_libraries);
        if materials.is_empty() {
            self.scene.shapes.push(shape);
            return Ok(());
        }
        for material in &materials {
            let index = self.mtl_material(material);
            let emits = material.emission.iter().any(|&e| e > 0.0);
            self.scene.shapes.push(ShapeDescription {
                name: format!("{} {}", shape.name, material.name),
                object: Some(shape.name.clone()),
                source: match &part {
                    None => ShapeSource::Obj {
                        path: obj.clone(),
                        part: Some(format!("usemtl {}", material.name)),
                        material: None,
                    },
                    Some(_) => ShapeSource::Obj {
                        path: obj.clone(),
                        part: part.clone(),
                        material: Some(material.name.clone()),
                    },
                },
                material: index,
                emission: shape.emission.or(emits.then_some(material.emission)),
                ..shape.clone()
            });
        }
        Ok(())
    }

    fn source(&self, kind: &str, keys: &Keys) -> Result<ShapeSource, SceneError> {
        let part = |keys: &Keys| Ok(keys.string("part")?.map(str::to_owned));
        Ok(match kind {
            "obj" => ShapeSource::Obj {
                path: self.file(keys)?,
                part: part(keys)?,
                material: None,
            },
            "ply" => ShapeSource::Ply {
                path: self.file(keys)?,
            },
            "serialized" => ShapeSource::Serialized {
                path: self.file(keys)?,
                index: keys.whole("index", 0..u32::MAX)?.unwrap_or(0) as usize,
            },
            "rectangle" => ShapeSource::Rectangle,
            "cube" => ShapeSource::Cube,
            "disk" => ShapeSource::Disk,
            "sphere" => ShapeSource::Sphere {
                centre: keys.vector("centre")?.unwrap_or(DVec3::ZERO),
                radius: keys.positive("radius")?.unwrap_or(1.0),
            },
            "cylinder" => ShapeSource::Cylinder {
                from: keys.vector("from")?.unwrap_or(DVec3::ZERO),
                to: keys.vector("to")?.unwrap_or(DVec3::Z),
                radius: keys.positive("radius")?.unwrap_or(1.0),
            },
            _ => ShapeSource::Generated {
                generator: keys
                    .required("generator", keys.string("generator")?)?
                    .to_owned(),
                part: part(keys)?,
                parameters: parameters(keys)?,
            },
        })
    }

    fn material_index(&self, keys: &Keys) -> Result<usize, SceneError> {
        let Some(name) = keys.string("material")? else {
            return Ok(0);
        };
        let materials = &self.scene.materials[1..];
        match materials.iter().position(|m| m.name == name) {
            Some(index) => Ok(index + 1),
            None => {
                let known: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
                Err(keys.unknown("material", name, &known))
            }
        }
    }
}

fn parameters(keys: &Keys) -> Result<BTreeMap<String, f64>, SceneError> {
    let Some(value) = keys.get("parameters") else {
        return Ok(BTreeMap::new());
    };
    let table = Keys::of(keys.source, value, format!("`parameters` of {}", keys.what))?;
    table
        .entries()
        .map(|(name, value)| match number(value.get_ref()) {
            Some(x) => Ok((name.to_owned(), x)),
            None => Err(table.wrong(name, value, NUMBER)),
        })
        .collect()
}

/// Scale, then rotations, then translation; or a row-major matrix.
fn transform(keys: &Keys) -> Result<DMat4, SceneError> {
    let scale = scale(keys)?;
    let rotation = rotation(keys)?;
    let translation = keys.vector("translate")?;
    let Some(rows) = keys.numbers::<16>("matrix")? else {
        let translation = DMat4::from_translation(translation.unwrap_or(DVec3::ZERO));
        let scale = DMat4::from_scale(scale.unwrap_or(DVec3::ONE));
        return Ok(translation * rotation.unwrap_or(DMat4::IDENTITY) * scale);
    };
    if scale.is_some() || rotation.is_some() || translation.is_some() {
        return Err(keys.error("give either `matrix` or `scale`, `rotate`, `translate`"));
    }
    match (&rows[12..], keys.get("matrix")) {
        ([0.0, 0.0, 0.0, 1.0], _) | (_, None) => Ok(DMat4::from_cols_array(&rows).transpose()),
        (_, Some(value)) => {
            let expected = "16 numbers, row by row, of which the last row is 0, 0, 0, 1";
            Err(keys.wrong("matrix", value, expected))
        }
    }
}

fn scale(keys: &Keys) -> Result<Option<DVec3>, SceneError> {
    let Some(value) = keys.get("scale") else {
        return Ok(None);
    };
    let uniform = number(value.get_ref()).map(DVec3::splat);
    let scale = uniform.or_else(|| match list(value.get_ref())?[..] {
        [x, y, z] => Some(DVec3::new(x, y, z)),
        _ => None,
    });
    match scale {
        Some(s) if s.x * s.y * s.z != 0.0 => Ok(Some(s)),
        _ => Err(keys.wrong("scale", value, "a number or [x, y, z], none of them 0")),
    }
}

/// `[ax, ay, az, degrees]` or a list of such, applied in order.
fn rotation(keys: &Keys) -> Result<Option<DMat4>, SceneError> {
    let Some(value) = keys.get("rotate") else {
        return Ok(None);
    };
    let wrong = || keys.wrong("rotate", value, "[axis x, y, z, degrees] or a list of such");
    let steps: Vec<Vec<f64>> = match list(value.get_ref()) {
        Some(one) => vec![one],
        None => {
            let items = value.get_ref().as_array().ok_or_else(wrong)?;
            let one = |item: &DeValue| list(item).ok_or_else(wrong);
            items
                .iter()
                .map(|item| one(item.get_ref()))
                .collect::<Result<_, _>>()?
        }
    };
    let mut product = DMat4::IDENTITY;
    for step in steps {
        let [x, y, z, degrees] = step[..] else {
            return Err(wrong());
        };
        let axis = DVec3::new(x, y, z).normalize_or_zero();
        if axis == DVec3::ZERO {
            return Err(keys.wrong("rotate", value, "an axis that is not zero"));
        }
        product = DMat4::from_axis_angle(axis, degrees.to_radians()) * product;
    }
    Ok(Some(product))
}
