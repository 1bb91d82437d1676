//! Mitsuba XML scenes of the versions 0.5, 0.6, 2 and 3.
//!
//! Conventions are those of Mitsuba: cameras look along +z of their space with +x to the *left* of
//! the image; transform chains apply their steps in order; `id`s name what `<ref>`s use, so that a
//! material inside a bump map is the bare material when it is referred to by its own id. What is
//! dropped or approximated is counted in the notes of the description.

mod blend;
mod bsdf;
mod cie;
mod conductor;
mod element;
mod emitter;
mod known_names;
mod light;
mod parse;
mod sensor;
mod shape;
mod solar;
mod spectrum;
mod texture;
mod transform;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use element::Element;
use parse::{Document, parse_document, read_document};

use super::text::{advice, decoded_xml, file_error};
use super::{Material, SceneDescription, SceneError};
use crate::image::file_of;

/// Depth that stands for Mitsuba's unlimited −1.
const UNLIMITED_DEPTH: u32 = 65;

/// Reads a scene file; no mesh, texture or map is opened.
pub(super) fn load_mitsuba(file: &Path, name: &str) -> Result<SceneDescription, SceneError> {
    let document = read_document(file)?;
    import(&document, file, name)
}

/// [`load_mitsuba`] of the bytes of a file.
pub(super) fn parse_mitsuba(bytes: &[u8], file: &Path) -> Result<SceneDescription, SceneError> {
    let text = decoded_xml(bytes).map_err(|why| file_error(file, why))?;
    import(&parse_document(file, &text)?, file, "bytes")
}

fn import(document: &Document, file: &Path, name: &str) -> Result<SceneDescription, SceneError> {
    let mut importer = Importer::new(document, file, name)?;
    known_names::check(&document.root, &|reference| {
        importer.ids.get(reference.id()?).copied()
    })?;
    importer.top_level(&document.root)?;
    importer.note_ignored(&document.root);
    let mut scene = importer.scene;
    if scene.views.is_empty() {
        let is_sensor = |e: &&Element| matches!(e.tag.as_str(), "sensor" | "camera");
        let others: Vec<&str> = document
            .root
            .children
            .iter()
            .filter(is_sensor)
            .map(Element::kind)
            .collect();
        let found = match others.is_empty() {
            true => "it has no <sensor>".to_owned(),
            false => format!("its sensor `{}` is not built", others.join("`, `")),
        };
        return Err(document.root.error(format!(
            "the scene has no perspective sensor, so nothing to look from: {found}"
        )));
    }
    scene.notes = importer
        .notes
        .into_iter()
        .map(|(text, count)| match count {
            1 => text,
            _ => format!("{text} ({count} times)"),
        })
        .collect();
    Ok(scene)
}

/// The state of one import.
struct Importer<'a> {
    /// Where files are looked for: beside the scene, then where `<path>` says.
    folders: Vec<PathBuf>,
    version: (u32, u32),
    ids: HashMap<&'a str, &'a Element>,
    scene: SceneDescription,
    /// Sentences and how often they apply.
    notes: BTreeMap<String, usize>,
    /// What has been made of elements, by their address in the tree.
    materials: HashMap<*const Element, usize>,
    textures: HashMap<*const Element, usize>,
    /// The material of lamps without one, once there is such a lamp.
    black: Option<usize>,
    has_integrator: bool,
    /// Textures that are being read, each inside the one before.
    open_textures: usize,
}

impl<'a> Importer<'a> {
    fn new(document: &'a Document, file: &Path, name: &str) -> Result<Self, SceneError> {
        let mut ids = HashMap::new();
        collect_ids(&document.root, &mut ids)?;
        let mut default_material = Material::diffuse("default", [0.5; 3]);
        default_material.two_sided = false;
        Ok(Importer {
            folders: vec![file.parent().unwrap_or(Path::new("")).to_owned()],
            version: document.version,
            ids,
            scene: SceneDescription {
                name: name.to_owned(),
                title: format!("Mitsuba scene {}", file.display()),
                file: Some(file.to_owned()),
                exposure: 1.0,
                max_depth: UNLIMITED_DEPTH,
                materials: vec![default_material],
                ..SceneDescription::default()
            },
            notes: BTreeMap::new(),
            materials: HashMap::new(),
            textures: HashMap::new(),
            black: None,
            has_integrator: false,
            open_textures: 0,
        })
    }

    fn top_level(&mut self, root: &'a Element) -> Result<(), SceneError> {
        root.used.set(true);
        for path in root.tagged("path") {
            path.used.set(true);
            let folder = self.folders[0].join(path.required("value")?.replace('\\', "/"));
            self.folders.push(folder);
        }
        for element in &root.children {
            match element.tag.as_str() {
                // Shines from the shapes that refer to it.
                "emitter" | "luminaire" if element.kind() == "area" => {}
                "integrator" => self.integrator(element)?,
                "sensor" | "camera" => self.sensor(element)?,
                "shape" => self.shape(element, glam::DMat4::IDENTITY)?,
                "emitter" | "luminaire" => self.emitter(element)?,
                "bsdf" | "texture" | "medium" | "alias" | "path" => {}
                other => {
                    element.mark_all();
                    self.note(format!("<{other}> is ignored"));
                }
            }
        }
        Ok(())
    }

    fn integrator(&mut self, element: &Element) -> Result<(), SceneError> {
        if std::mem::replace(&mut self.has_integrator, true) {
            return Err(element.error("a scene has one integrator"));
        }
        element.mark_all();
        // Integrators such as `aov` add to what the one inside them renders.
        let mut inner = element;
        while let Some(next) = inner.tagged("integrator").next() {
            inner = next;
        }
        if inner.boolean("hide_emitters", false)? {
            self.scene.hides_lights = true;
            self.note(
                "hide_emitters: path tracing keeps lights out of sight, other techniques show them",
            );
        }
        let kinds = [element.kind(), inner.kind()];
        let known = ["path", "volpath", "direct", "aov", "moment"];
        if let Some(kind) = kinds.iter().find(|kind| !known.contains(kind)) {
            self.note(format!("integrator `{kind}` becomes the path tracer"));
        }
        let depth = inner.float("max_depth")?;
        self.scene.max_depth = match depth.unwrap_or(-1.0) {
            _ if inner.kind() == "direct" => 2,
            depth if depth >= 0.0 && depth.fract() == 0.0 => depth as u32,
            -1.0 => {
                let note = format!("unlimited path depth becomes {UNLIMITED_DEPTH} edges");
                self.note(note);
                UNLIMITED_DEPTH
            }
            other => {
                let message = format!("`max_depth` is −1 or a whole number from 0, not {other}");
                return Err(inner.child("max_depth").unwrap_or(inner).error(message));
            }
        };
        Ok(())
    }

    /// Counts one occurrence of something dropped or approximated.
    fn note(&mut self, text: impl Into<String>) {
        *self.notes.entry(text.into()).or_insert(0) += 1;
    }

    /// What a `<ref>` refers to, or the element itself.
    fn resolved(&self, element: &'a Element) -> Result<&'a Element, SceneError> {
        if element.tag != "ref" {
            return Ok(element);
        }
        element.used.set(true);
        self.referred(element)
    }

    /// What a `<ref>` refers to, which is looked at without being used.
    fn referred(&self, element: &'a Element) -> Result<&'a Element, SceneError> {
        let id = element.required("id")?;
        self.ids.get(id).copied().ok_or_else(|| {
            let mut known: Vec<&str> = self.ids.keys().copied().collect();
            known.sort_unstable();
            known.truncate(200);
            let nearest = super::text::nearest(id, &known);
            let hint = nearest.map_or(String::new(), |k| format!("; did you mean `{k}`?"));
            element.error(format!("nothing has the id `{id}`{hint}"))
        })
    }

    /// The children (or what they refer to) with a tag.
    fn nested(&self, element: &'a Element, tag: &str) -> Result<Vec<&'a Element>, SceneError> {
        let mut found = Vec::new();
        for child in &element.children {
            let target = match child.tag.as_str() {
                "ref" => self.referred(child)?,
                _ => child,
            };
            if target.tag == tag {
                found.push(self.resolved(child)?);
            }
        }
        Ok(found)
    }

    /// A file named by a scene: the first of that name in the scene's folders.
    fn path(&self, element: &Element) -> Result<PathBuf, SceneError> {
        match element.string("filename")? {
            Some(name) => {
                let name = name.replace('\\', "/");
                let mut files = self.folders.iter().map(|folder| folder.join(&name));
                let found = files.find(|file| file_of(file).exists());
                Ok(found.unwrap_or_else(|| self.folders[0].join(&name)))
            }
            None => Err(element.error(format!("{} needs a `filename`", element.kind()))),
        }
    }

    /// One of the known words, or an error with the nearest one.
    fn unknown_word(element: &Element, what: &str, word: &str, known: &[&str]) -> SceneError {
        element.error(format!(
            "{what} `{word}` is unknown; {}",
            advice(word, known)
        ))
    }

    /// Notes parameters that nothing has looked at, inside elements that were used.
    fn note_ignored(&mut self, element: &Element) {
        for child in &element.children {
            if child.used.get() {
                self.note_ignored(child);
            } else if matches!(
                child.tag.as_str(),
                "bsdf" | "texture" | "emitter" | "luminaire"
            ) && element.tag == "scene"
            {
                self.note(format!(
                    "{} `{}` that nothing refers to is left out",
                    child.tag,
                    child.kind()
                ));
            } else if !child.name().is_empty() {
                self.note(format!(
                    "parameter `{}` of {} `{}` is ignored",
                    child.name(),
                    element.tag,
                    element.kind()
                ));
            } else if element.tag != "scene" {
                self.note(format!(
                    "<{} type=\"{}\"> in {} `{}` is ignored",
                    child.tag,
                    child.kind(),
                    element.tag,
                    element.kind()
                ));
            }
        }
    }
}

/// Elements by their ids and by other names of them.
type Ids<'a> = HashMap<&'a str, &'a Element>;

fn collect_ids<'a>(element: &'a Element, ids: &mut Ids<'a>) -> Result<(), SceneError> {
    for child in &element.children {
        if let (Some(id), false) = (child.id(), matches!(child.tag.as_str(), "ref" | "alias")) {
            insert_id(ids, id, [child, child])?;
        }
        collect_ids(child, ids)?;
    }
    for alias in element.tagged("alias") {
        alias.used.set(true);
        if let (Some(id), Some(name)) = (alias.id(), alias.attribute("as"))
            && let Some(&target) = ids.get(id)
        {
            insert_id(ids, name, [alias, target])?;
        }
    }
    Ok(())
}

/// Gives a thing an id at a place in the file; an error where another thing has it.
fn insert_id<'a>(
    ids: &mut Ids<'a>,
    id: &'a str,
    [place, target]: [&'a Element; 2],
) -> Result<(), SceneError> {
    match ids.insert(id, target) {
        Some(other) if !std::ptr::eq(other, target) => {
            let file = match other.file == place.file {
                true => String::new(),
                false => format!("{}:", other.file.display()),
            };
            let at = format!("{file}{}:{}", other.line, other.column);
            Err(place.error(format!("the id `{id}` is taken already, at {at}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
