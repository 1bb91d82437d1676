//! Content keys: what a scene, a reference and a job are, whatever they are called and wherever
//! their files lie.
//!
//! Every key is a hash of JSON with its parts in a fixed order. Files count by what is in them.

use crate::environment::EnvironmentDescription;
use crate::files::check_ends;
use crate::image::file_of;
use std::collections::HashMap;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use glam::DVec3;
use serde_json::{Value, json};

use super::Job;
use crate::scene::{
    GltfFile, Material, SceneDescription, ShapeDescription, ShapeSource, TextureDescription,
    TextureSource, View,
};
use crate::technique::{Technique, TechniqueEntry, Terms};

/// Raised when the form of keys changes, or when something that all techniques share (loaders, shapes
/// made in code, rays, shading) gives other pictures; methods have versions of their own.
const FORMAT: u32 = 4;

/// Sixteen hexadecimal digits of a text's hash.
pub fn hash(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex()[..16].to_owned()
}

/// A hash of what a scene shows from any view: all that it declares but names, notes, views and paths, and
/// the contents of its files.
pub fn scene_key(description: &SceneDescription) -> String {
    let SceneDescription {
        name: _,
        title: _,
        file: _,
        metres_per_unit,
        ao_distance,
        exposure,
        max_depth,
        hides_lights,
        views: _,
        shapes,
        materials,
        textures,
        lights,
        paths: _,
        motions,
        environment,
        // What is told of them changes no picture.
        clips: _,
        notes: _,
        absent_libraries: _,
    } = description;
    let mut shown = vec![
        json!(FORMAT),
        json!(metres_per_unit),
        json!(ao_distance),
        json!(exposure),
        json!(max_depth),
        shapes.iter().map(shape).collect(),
        materials.iter().map(material).collect(),
        textures.iter().map(texture).collect(),
        json!(lights),
        json!(environment.as_ref().map(self::environment)),
    ];
    if !motions.is_empty() {
        shown.push(json!(motions));
    }
    if *hides_lights {
        shown.push(json!("hides lights, and the sky behind masks"));
    }
    hash(&Value::from(shown).to_string())
}

fn shape(shape: &ShapeDescription) -> Value {
    let ShapeDescription {
        name: _,
        object: _,
        source,
        to_world,
        material,
        emission,
        emission_texture,
        flip_normals,
        turn_bare,
        face_normals,
        smooth_normals,
        flip_v,
    } = shape;
    let source = match source {
        ShapeSource::Obj {
            path,
            part,
            material: None,
        } => json!(["obj", contents(path), part]),
        ShapeSource::Obj {
            path,
            part,
            material,
        } => json!(["obj", contents(path), part, material]),
        ShapeSource::Ply { path } => json!(["ply", contents(path)]),
        ShapeSource::Serialized { path, index } => json!(["serialized", contents(path), index]),
        ShapeSource::Gltf {
            file,
            mesh,
            primitive,
            uv_set,
        } => json!(["gltf", all_contents(file), mesh, primitive, uv_set]),
        ShapeSource::Rectangle => json!(["rectangle"]),
        ShapeSource::Cube => json!(["cube"]),
        ShapeSource::Sphere { centre, radius } => json!(["sphere", centre, radius]),
        ShapeSource::Disk => json!(["disk"]),
        ShapeSource::Cylinder { from, to, radius } => json!(["cylinder", from, to, radius]),
        ShapeSource::Generated {
            generator,
            part,
            parameters,
        } => json!(["generated", generator, part, parameters]),
    };
    let sides = [flip_normals, face_normals, smooth_normals, flip_v];
    let mut parts = vec![source, json!(to_world), json!(material), json!(emission)];
    parts.extend(emission_texture.map(|texture| json!(texture)));
    parts.push(json!(sides));
    if *turn_bare {
        parts.push(json!("turns bare faces"));
    }
    Value::from(parts)
}

fn material(material: &Material) -> Value {
    let Material {
        name: _,
        bsdf,
        two_sided,
        back,
        blend,
        opacity,
        bump,
        normals,
        soft_terminators,
    } = material;
    // Rays pass masks without an edge, and shadow rays pass them: results of the time before that are others.
    let passed = opacity.map_or(Value::Null, |opacity| json!(["passed", opacity]));
    let mut parts = vec![json!(bsdf), json!(two_sided), passed, json!(bump)];
    parts.extend(normals.map(|normals| json!(normals)));
    parts.extend(back.map(|back| json!(["back", back])));
    parts.extend(blend.map(|blend| json!(["blend", blend])));
    if *soft_terminators {
        parts.push(json!("soft terminators"));
    }
    Value::from(parts)
}

fn texture(texture: &TextureDescription) -> Value {
    let TextureDescription {
        source,
        srgb,
        nearest,
        wrap,
        uv_scale,
        uv_shear,
        uv_turn_rad,
        uv_offset,
        factor,
        base,
        alpha,
    } = texture;
    let source = match source {
        TextureSource::File(path) => json!(["file", contents(path)]),
        TextureSource::Gltf { file, image } => json!(["gltf", all_contents(file), image]),
        TextureSource::Checkerboard(colours) => json!(["checkerboard", colours]),
    };
    let basic = json!([source, srgb, nearest, wrap, uv_scale, uv_offset]);
    // What only glTF says is not part of the keys of others.
    let mut parts = match (uv_turn_rad, factor, alpha) {
        (0.0, [1.0, 1.0, 1.0], None) => basic,
        others => json!([basic, others]),
    };
    if let (Some(base), Some(parts)) = (base, parts.as_array_mut()) {
        parts.push(json!(["base", base]));
    }
    if let (true, Some(parts)) = (*uv_shear != 0.0, parts.as_array_mut()) {
        parts.push(json!(["shear", uv_shear]));
    }
    parts
}

fn environment(environment: &EnvironmentDescription) -> Value {
    match environment {
        EnvironmentDescription::Constant { radiance } => json!(["constant", radiance]),
        EnvironmentDescription::Map {
            path,
            scale,
            to_world,
            rows,
        } => json!(["map", contents(path), scale, to_world, rows]),
        EnvironmentDescription::Embedded {
            name,
            scale,
            to_world,
        } => json!(["embedded", name, scale, to_world]),
        EnvironmentDescription::SunSky {
            sun_direction,
            zenith,
            turbidity,
            albedo,
            sun,
            sun_irradiance,
            sun_aperture_deg,
            sky,
            scale,
        } => {
            let albedo = match *albedo {
                [r, g, b] if [g, b] == [r; 2] => json!(r),
                colour => json!(colour),
            };
            let mut sky = json!(["sky", sun_direction, turbidity, albedo, sun, sky, scale]);
            if let (Some(irradiance), Some(parts)) = (sun_irradiance, sky.as_array_mut()) {
                parts.push(json!(["sun", irradiance]));
            }
            if let (Some(aperture), Some(parts)) = (sun_aperture_deg, sky.as_array_mut()) {
                parts.push(json!(["aperture", aperture]));
            }
            if let (true, Some(parts)) = (*zenith != DVec3::Y, sky.as_array_mut()) {
                parts.push(json!(zenith));
            }
            sky
        }
    }
}

/// Hashes of a glTF file and its buffers.
fn all_contents(file: &GltfFile) -> Vec<String> {
    file.files().iter().map(|path| contents(path)).collect()
}

/// A hash of what is in a file; `absent` or the reason for files that cannot be read. It is
/// remembered for as long as the program runs, by path, size and time of change.
fn contents(path: &Path) -> String {
    static KNOWN: Mutex<Option<HashMap<Stamp, String>>> = Mutex::new(None);
    let read = || -> io::Result<String> {
        let file = file_of(path);
        check_ends(&file)?;
        let metadata = std::fs::metadata(&file)?;
        let stamp = (path.to_owned(), metadata.len(), metadata.modified()?);
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        let known = known.get_or_insert_default();
        if let Some(found) = known.get(&stamp) {
            return Ok(found.clone());
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(File::open(&file)?)?;
        if file != path {
            let layer = path.to_string_lossy();
            hasher.update(layer.rsplit('#').next().unwrap_or("").as_bytes());
        }
        let found = hasher.finalize().to_hex().to_string();
        known.insert(stamp, found.clone());
        Ok(found)
    };
    read().unwrap_or_else(|error| match error.kind() {
        io::ErrorKind::NotFound => "absent".into(),
        kind => kind.to_string(),
    })
}

/// Path, size and time of change of a file.
type Stamp = (PathBuf, u64, SystemTime);

impl Job {
    /// One key of all its references together and the key of each, from what they show: the same for all methods and
    /// seeds.
    pub(super) fn references(&self, scene: &SceneDescription) -> (String, Arc<[String]>) {
        let references: Arc<[String]> = self
            .sequence
            .measured()
            .flat_map(|frame| self.references_of(frame, scene).unwrap_or_default())
            .collect();
        let together = match &references[..] {
            [one] => one.clone(),
            several => hash(&several.join(" ")),
        };
        (together, references)
    }

    /// Fills in the content id, from what the job does and the key of its references.
    pub(super) fn identify(&mut self, entry: &TechniqueEntry, built: &dyn Technique) {
        let (own, _) = self.parameters_by_use(entry);
        let parts = versions(built, &self.method, &self.method_parameters);
        let mut done = vec![
            json!(self.reference),
            json!(self.method),
            json!(parts),
            canonical_table(&self.method_parameters),
            canonical_table(&own),
            json!(self.budget),
            json!(self.seed),
        ];
        if !self.sequence.is_still() {
            done.push(json!(self.sequence));
        }
        self.id = hash(&Value::from(done).to_string());
    }

    /// Keys of the references of a frame, one for each viewer, of a scene as it is declared. `None` where the scene has
    /// no longer what viewers follow.
    pub fn references_of(&self, frame: u32, scene: &SceneDescription) -> Option<Vec<String>> {
        let sequence = &self.sequence;
        let at = |frame: u32| sequence.views(scene, sequence.time_s(frame));
        let first = sequence.frames[0];
        let exposes = frame != first
            && self
                .built_technique()
                .is_some_and(|technique| technique.decides_exposure());
        let exposed_by: Vec<Option<View>> = match exposes {
            true => at(first)?.into_iter().map(Some).collect(),
            false => vec![None; sequence.viewers.len()],
        };
        let views = at(frame)?.into_iter().zip(exposed_by);
        let keys = views.map(|(view, first_view)| {
            let key = self.reference_of(&view, sequence.time_s(frame));
            match first_view {
                None => key,
                // What the first frame is decides the exposure.
                Some(view) => {
                    let exposing = self.reference_of(&view, sequence.time_s(first));
                    hash(&format!("{key} exposed by {exposing}"))
                }
            }
        });
        Some(keys.collect())
    }

    /// Key of the reference of a view, in the coordinates of the scene's file, at a time.
    fn reference_of(&self, view: &View, time_s: f64) -> String {
        let technique = crate::registry::technique(&self.technique);
        let version = technique.map_or(0, |entry| entry.about.version);
        let shared = technique.map_or_else(toml::Table::new, |t| self.parameters_by_use(t).1);
        let mut seen = json!(view);
        if let (true, Some(parts)) = (view.shift == [0.0; 2], seen.as_object_mut()) {
            // What few views have is not part of the keys of others, whose order stays.
            parts.shift_remove("shift");
        }
        let mut shown = vec![
            json!(FORMAT),
            json!(self.shown),
            seen,
            json!(self.transform),
            json!(self.technique),
            json!(version),
            canonical_table(&shared),
            json!([self.width, self.height]),
            json!(self.spp),
        ];
        if self.moves {
            shown.push(json!(time_s));
        }
        hash(&Value::from(shown).to_string())
    }

    /// The technique's parameters that only contenders depend on, and those that the reference does too.
    fn parameters_by_use(&self, technique: &TechniqueEntry) -> (toml::Table, toml::Table) {
        let parameters = self.technique_parameters.clone().into_iter();
        parameters.partition(|(key, _)| technique.of_contenders.contains(&key.as_str()))
    }
}

/// Ids and versions of the parts of a method.
fn versions(
    technique: &dyn Technique,
    method: &str,
    parameters: &toml::Table,
) -> Vec<(&'static str, u32)> {
    let started = technique.start(method, parameters, Terms::default());
    let parts = started.map_or(Vec::new(), |started| started.parts);
    parts.iter().map(|part| (part.id, part.version)).collect()
}

/// A table with its keys in order at every level, and with numbers that JSON does not have as text.
fn canonical_table(table: &toml::Table) -> Value {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| *key);
    let entries = entries.into_iter();
    entries
        .map(|(key, value)| (key.clone(), canonical(value)))
        .collect()
}

fn canonical(value: &toml::Value) -> Value {
    match value {
        toml::Value::Table(table) => canonical_table(table),
        toml::Value::Array(items) => items.iter().map(canonical).collect(),
        toml::Value::Float(x) if !x.is_finite() => x.to_string().into(),
        other => json!(other),
    }
}

#[cfg(test)]
mod tests;
