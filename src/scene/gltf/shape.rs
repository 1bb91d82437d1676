//! Meshes of nodes as shapes.

use std::collections::BTreeMap;

use ::gltf::json::mesh::{Mesh as Declared, Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::DVec3;
use rayon::prelude::*;

use super::Importer;
use super::document::named;
use super::material::{Mapped, has_colour_texture};
use super::node::Placed;
use super::primitive::{attribute, has_triangles};
use crate::scene::{SceneError, ShapeDescription, ShapeSource};

/// The primitives of a mesh that have triangles.
pub(super) type Parts = Vec<Part>;

/// A primitive with triangles.
pub(super) struct Part {
    primitive: usize,
    mapped: Mapped,
    /// Corners of the box around it, in the frame of the mesh.
    low: DVec3,
    high: DVec3,
}

impl Importer<'_> {
    /// The meshes of some nodes by index, all of them read once and checked.
    pub(super) fn meshes_of(
        &mut self,
        nodes: &[Placed],
    ) -> Result<BTreeMap<usize, Parts>, SceneError> {
        let mut used = Vec::new();
        let mut meshes: BTreeMap<usize, Parts> = BTreeMap::new();
        for placed in nodes {
            let node = &self.file.root().nodes[placed.node];
            let Some(index) = node.mesh.map(|mesh| mesh.value()) else {
                continue;
            };
            if meshes.contains_key(&index) {
                continue;
            }
            meshes.insert(index, Parts::new());
            let Some(mesh) = self.file.root().meshes.get(index) else {
                return Err(self.file.error(format!("mesh {index}"), "is not there"));
            };
            let place = named("mesh", index, mesh.name.as_deref());
            let weights = node.weights.as_deref().or(mesh.weights.as_deref());
            self.check_morphs(mesh, weights.unwrap_or_default(), &place)?;
            for (i, primitive) in mesh.primitives.iter().enumerate() {
                if self.is_shown(primitive, &format!("{place}, primitive {i}"))? {
                    let material = primitive.material.map(|m| m.value());
                    used.push((index, i, self.material(material)?));
                    self.note_attributes(primitive, used[used.len() - 1].2.uv_set);
                }
            }
        }
        self.note_reused_morphs(nodes)?;
        let file = self.file;
        let read = used.par_iter().map(|&(mesh, primitive, mapped)| {
            let triangles = file.mesh([mesh, primitive], mapped.uv_set)?;
            let positions = || triangles.positions.iter().copied();
            let part = Part {
                primitive,
                mapped,
                low: positions().fold(DVec3::INFINITY, DVec3::min),
                high: positions().fold(DVec3::NEG_INFINITY, DVec3::max),
            };
            Ok((mesh, part))
        });
        // Collected first, so that the first error in the order of the file is told.
        let read: Vec<Result<(usize, Part), SceneError>> = read.collect();
        for result in read {
            let (mesh, part) = result?;
            meshes.entry(mesh).or_default().push(part);
        }
        Ok(meshes)
    }

    /// Whether a primitive has triangles; points and lines are told and left out.
    fn is_shown(&mut self, primitive: &Primitive, place: &str) -> Result<bool, SceneError> {
        match has_triangles(primitive) {
            None => return Err(self.file.error(place, "its mode is unknown")),
            Some(false) => {
                self.note(format!("{place} is of points or lines and left out"));
                return Ok(false);
            }
            Some(true) => {}
        }
        if attribute(primitive, Semantic::Positions).is_none() {
            self.note(format!("{place} has no positions and is left out"));
            return Ok(false);
        }
        let indices = primitive.indices.map(|index| index.value());
        let corners = indices.or(attribute(primitive, Semantic::Positions));
        let corners = corners.and_then(|index| self.file.root().accessors.get(index));
        let extra = corners.map_or(0, |accessor| accessor.count.0 % 3);
        if extra > 0 && primitive.mode == Checked::Valid(Mode::Triangles) {
            self.note(format!(
                "{place} has {extra} corners more than fill triangles, which are left out"
            ));
        }
        Ok(true)
    }

    /// Says where a node is placed in a way that glTF does not allow.
    pub(super) fn note_odd_place(&mut self, index: usize) {
        let node = &self.file.root().nodes[index];
        let place = self.file.node_place(index);
        let parts = node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
        if node.matrix.is_some() && parts {
            self.note(format!(
                "{place} has a matrix, which counts, beside translation, rotation or scale"
            ));
        }
        let length = node
            .rotation
            .map_or(1.0, |r| r.0.iter().map(|x| x * x).sum::<f32>().sqrt());
        if (length - 1.0).abs() > 0.01 {
            self.note(format!(
                "the rotation of {place} is no unit quaternion and made one"
            ));
        }
    }

    /// Morph targets of weight 0 change nothing; others would be seen wrong.
    fn check_morphs(
        &mut self,
        mesh: &Declared,
        weights: &[f32],
        place: &str,
    ) -> Result<(), SceneError> {
        let has_targets = |p: &Primitive| p.targets.as_ref().is_some_and(|t| !t.is_empty());
        if !mesh.primitives.iter().any(has_targets) {
            return Ok(());
        }
        if weights.iter().any(|w| *w != 0.0) {
            let message = "morph targets cannot be read here, and their weights are not 0";
            return Err(self.file.error(place, message));
        }
        self.note(format!("the morph targets of {place} are left out"));
        Ok(())
    }

    /// Checks the weights of the nodes that show a mesh again.
    fn note_reused_morphs(&mut self, nodes: &[Placed]) -> Result<(), SceneError> {
        for placed in nodes {
            let node = &self.file.root().nodes[placed.node];
            if node.weights.iter().flatten().any(|w| *w != 0.0) {
                let message = "morph targets cannot be read here, and its weights are not 0";
                return Err(self.file.error(self.file.node_place(placed.node), message));
            }
        }
        Ok(())
    }

    fn note_attributes(&mut self, primitive: &Primitive, uv_set: u32) {
        for semantic in primitive.attributes.keys() {
            match semantic {
                Checked::Valid(Semantic::Colors(_)) => self.note("vertex colours are left out"),
                Checked::Valid(Semantic::TexCoords(set)) if *set != uv_set => {
                    self.note(format!(
                        "texture coordinates TEXCOORD_{set} are left out: the colour reads TEXCOORD_{uv_set}"
                    ));
                }
                _ => {}
            }
        }
        let uvs = attribute(primitive, Semantic::TexCoords(uv_set));
        let material = primitive
            .material
            .and_then(|m| self.file.root().materials.get(m.value()));
        if material.is_some_and(has_colour_texture) && uvs.is_none() {
            self.note(format!(
                "a texture without coordinates (TEXCOORD_{uv_set}) shows one texel"
            ));
        }
    }

    /// Adds a shape for every part of the meshes of the nodes; gives the corners of the box around all of them.
    pub(super) fn shapes(
        &mut self,
        nodes: &[Placed],
        meshes: &BTreeMap<usize, Parts>,
    ) -> [DVec3; 2] {
        let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        for placed in nodes {
            let mesh = self.file.root().nodes[placed.node]
                .mesh
                .map(|mesh| mesh.value());
            let Some((mesh, parts)) = mesh.and_then(|mesh| Some((mesh, meshes.get(&mesh)?))) else {
                continue;
            };
            let object = self.shape_name(placed.node, mesh);
            for part in parts {
                for corner in part.corners() {
                    let corner = placed.to_world.transform_point3(corner);
                    bounds = [bounds[0].min(corner), bounds[1].max(corner)];
                }
                let name = match parts.len() {
                    1 => object.clone(),
                    _ => format!("{object}.{}", part.primitive),
                };
                let source = ShapeSource::Gltf {
                    file: self.file.clone(),
                    mesh,
                    primitive: part.primitive,
                    uv_set: part.mapped.uv_set,
                };
                let index = self.scene.shapes.len();
                self.carried(placed).shapes.push(index);
                self.scene.shapes.push(ShapeDescription {
                    object: (parts.len() > 1).then(|| object.clone()),
                    to_world: placed.to_world,
                    material: part.mapped.material,
                    emission: part.mapped.emission,
                    // glTF counts v from the top row of the image, we from the bottom.
                    flip_v: true,
                    ..ShapeDescription::new(&name, source)
                });
            }
        }
        bounds
    }

    /// The name of a node, or else of its mesh; with the node's index where that is taken.
    fn shape_name(&mut self, node: usize, mesh: usize) -> String {
        let root = self.file.root();
        let of_mesh = root.meshes.get(mesh).and_then(|m| m.name.as_deref());
        let names = [root.nodes[node].name.as_deref(), of_mesh]
            .into_iter()
            .flatten();
        let name = names.clone().find(|name| !name.is_empty());
        let name = name.map_or(format!("node {node}"), str::to_owned);
        match self.names.insert(name.clone()) {
            true => name,
            false => {
                let unique = format!("{name} (node {node})");
                self.names.insert(unique.clone());
                unique
            }
        }
    }
}

impl Part {
    fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let high = |bit: usize| i >> bit & 1 == 1;
            DVec3::select(
                glam::BVec3::new(high(0), high(1), high(2)),
                self.high,
                self.low,
            )
        })
    }
}
