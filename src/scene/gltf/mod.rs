//! glTF 2.0 scenes, `.gltf` and `.glb`.
//!
//! The tree of nodes becomes shapes, views and lights in world space; every primitive with triangles is a shape
//! of its own. glTF is right-handed, y up, in metres. Loading checks all that is read later, accessors and
//! indices included, so that damage is told before anything is rendered; `docs/gltf.md` says what is mapped,
//! approximated and left out.

mod accessor;
mod animation;
mod camera;
mod container;
mod document;
mod emission;
mod glass;
mod glossy;
mod image;
mod light;
mod material;
mod node;
mod parse;
mod primitive;
mod shape;
mod texture;
mod uri;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;

use super::motion::MotionDescription;
use super::path::{CameraPath, PathSource};
use super::{SceneDescription, SceneError};
use crate::environment::EnvironmentDescription;
use animation::Animated;
use material::Mapped;
use node::Placed;

pub(super) use document::Buffers;
pub use document::GltfFile;

/// Path edges where nothing says how many: that of scene files that say nothing.
const MAX_DEPTH: u32 = 6;

/// Reads a scene file and checks its buffers; nothing of them is kept.
pub(super) fn load_gltf(path: &Path, name: &str) -> Result<SceneDescription, SceneError> {
    let file = GltfFile::parse(path)?;
    Importer::new(&file, name).import()
}

/// [`load_gltf`] of the bytes of a file; its buffers are data URIs, or those of files beside `path`.
pub(super) fn parse_gltf(bytes: &[u8], path: &Path) -> Result<SceneDescription, SceneError> {
    let file = GltfFile::parse_bytes(path, bytes)?;
    Importer::new(&file, "bytes").import()
}

/// The state of one import.
struct Importer<'a> {
    file: &'a GltfFile,
    scene: SceneDescription,
    /// Sentences and how often they apply.
    notes: BTreeMap<String, usize>,
    /// What has been made of the materials of the file.
    materials: HashMap<Option<usize>, Mapped>,
    /// Names of nodes that are taken.
    names: HashSet<String>,
    /// What nodes that move carry, by their place in the list of nodes.
    carried: BTreeMap<usize, Carried>,
    /// What no node moves.
    still: Carried,
}

impl<'a> Importer<'a> {
    fn new(file: &'a GltfFile, name: &str) -> Self {
        let path = file.path();
        Self {
            file,
            scene: SceneDescription {
                name: name.to_owned(),
                title: format!("glTF scene {}", path.display()),
                file: Some(path.to_owned()),
                metres_per_unit: Some(1.0),
                exposure: 1.0,
                max_depth: MAX_DEPTH,
                ..SceneDescription::default()
            },
            notes: BTreeMap::new(),
            materials: HashMap::new(),
            names: HashSet::new(),
            carried: BTreeMap::new(),
            still: Carried::default(),
        }
    }

    fn import(mut self) -> Result<SceneDescription, SceneError> {
        let roots = self.roots()?;
        self.note_extensions();
        // Held to the end, so that they are read once.
        let buffers = self.file.buffers()?;
        let animated = self.animations(&buffers)?;
        let nodes = self.file.nodes_below(&roots, &animated)?;
        self.file.refuse_circles()?;
        self.prepare_means();
        let meshes = self.meshes_of(&nodes)?;
        for placed in &nodes {
            self.note_odd_place(placed.node);
            self.node(placed)?;
        }
        let bounds = self.shapes(&nodes, &meshes);
        if self.scene.shapes.is_empty() {
            let dropped = self.notes.keys().next();
            let dropped = dropped.map_or(String::new(), |note| format!(" ({note})"));
            return Err(self
                .file
                .error("scene", format!("nothing in it has triangles{dropped}")));
        }
        if self.scene.views.is_empty() {
            let [low, high] = bounds;
            self.stand_in_view(low, high);
        }
        self.stand_in_light();
        self.motions(&nodes, &animated);
        let notes = self.notes.into_iter();
        self.scene.notes = notes.map(|(text, count)| counted(text, count)).collect();
        Ok(self.scene)
    }

    /// The roots of the default scene, of the first one, or of all nodes.
    fn roots(&mut self) -> Result<Vec<usize>, SceneError> {
        let root = self.file.root();
        let index = root.scene.map_or(0, |scene| scene.value());
        if let Some(scene) = root.scenes.get(index) {
            if root.scene.is_none() {
                self.note("the file has no default scene: scene 0 is shown");
            }
            if root.scenes.len() > 1 {
                self.note(format!("scenes other than scene {index} are left out"));
            }
            return Ok(scene.nodes.iter().map(|node| node.value()).collect());
        }
        if root.scene.is_some() {
            return Err(self
                .file
                .error("scene", format!("scene {index} is not there")));
        }
        self.note("the file has no scene: all its nodes are shown");
        Ok(self.file.nodes_without_parent())
    }

    /// Adds the camera and the light of a node; refuses what would be seen wrong.
    fn node(&mut self, placed: &Placed) -> Result<(), SceneError> {
        let node = &self.file.root().nodes[placed.node];
        if node.skin.is_some() {
            let message = "skinning cannot be read here: its mesh follows joints";
            return Err(self.file.error(self.file.node_place(placed.node), message));
        }
        if let Some(camera) = node.camera {
            self.camera(camera.value(), placed)?;
        }
        if let Some(extensions) = &node.extensions {
            if let Some(light) = &extensions.khr_lights_punctual {
                self.light(light.light.value(), placed)?;
            }
            for name in extensions.others.keys() {
                self.note(format!("{name} is left out"));
            }
        }
        Ok(())
    }

    /// Names the extensions that are used and not read, unless the materials and nodes that use them do.
    fn note_extensions(&mut self) {
        for name in &self.file.root().extensions_used {
            let is_told =
                name.starts_with("KHR_materials_") || parse::READ.contains(&name.as_str());
            if !is_told {
                self.note(format!("{name} is left out"));
            }
            if name == "KHR_materials_variants" {
                self.note("KHR_materials_variants: the materials of no variant are shown");
            }
        }
    }

    /// A sky for a file without any light.
    fn stand_in_light(&mut self) {
        let shines = self
            .scene
            .shapes
            .iter()
            .any(|shape| shape.emission.is_some());
        if self.scene.lights.is_empty() && !shines {
            self.note("the file has no light: a sky of constant radiance 1 stands in, `environment=FILE` replaces it");
            self.scene.environment = Some(EnvironmentDescription::Constant { radiance: [1.0; 3] });
        }
    }

    /// What moves with a node; what does not move has a list of its own.
    fn carried(&mut self, placed: &Placed) -> &mut Carried {
        match placed.carrier {
            Some(carrier) => self.carried.entry(carrier).or_default(),
            None => &mut self.still,
        }
    }

    /// Makes motions of the shapes and lights that nodes carry, and paths of the cameras.
    fn motions(&mut self, nodes: &[Placed], animated: &HashMap<usize, Animated>) {
        for (carrier, carried) in std::mem::take(&mut self.carried) {
            let Some(placement) = node::placement(nodes, animated, carrier) else {
                continue;
            };
            for view in carried.views {
                let view = self.scene.views[view].clone();
                self.scene.paths.push(CameraPath {
                    name: view.name.clone(),
                    eye_distance_m: None,
                    source: PathSource::Carried {
                        view,
                        placement: placement.clone(),
                    },
                });
            }
            if !carried.shapes.is_empty() || !carried.lights.is_empty() {
                self.scene.motions.push(MotionDescription {
                    shapes: carried.shapes,
                    lights: carried.lights,
                    placement,
                    ..MotionDescription::default()
                });
            }
        }
    }

    /// Counts one occurrence of something dropped or approximated.
    fn note(&mut self, text: impl Into<String>) {
        *self.notes.entry(text.into()).or_insert(0) += 1;
    }
}

/// Indices of what a node carries.
#[derive(Default)]
struct Carried {
    shapes: Vec<usize>,
    lights: Vec<usize>,
    views: Vec<usize>,
}

fn counted(text: String, count: usize) -> String {
    match count {
        1 => text,
        _ => format!("{text} ({count} times)"),
    }
}
