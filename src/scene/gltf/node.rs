//! The tree of nodes.

use ::gltf::json::scene::Node;
use glam::{DMat4, DQuat, DVec3};

use super::document::{GltfFile, named};
use crate::scene::SceneError;

/// A node that is reached from the roots of a scene.
pub(super) struct Placed {
    /// Index among the nodes of the file.
    pub node: usize,
    /// Index of the node above it in the list of those reached.
    pub parent: Option<usize>,
    pub to_world: DMat4,
}

/// Position, rotation and scale of a node in the frame of the node above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placement {
    pub translation: DVec3,
    pub rotation: DQuat,
    pub scale: DVec3,
}

impl GltfFile {
    /// The nodes below some roots, each after the one above it. A node that is reached twice is an error: glTF
    /// has trees only, and a circle would never end.
    pub(super) fn nodes_below(&self, roots: &[usize]) -> Result<Vec<Placed>, SceneError> {
        let nodes = &self.root().nodes;
        let mut placed: Vec<Placed> = Vec::new();
        let mut seen = vec![false; nodes.len()];
        let mut open: Vec<(usize, Option<usize>)> =
            roots.iter().rev().map(|&r| (r, None)).collect();
        while let Some((index, parent)) = open.pop() {
            let Some(node) = nodes.get(index) else {
                return Err(self.error(format!("node {index}"), "is not there"));
            };
            if std::mem::replace(&mut seen[index], true) {
                return Err(self.error(
                    self.node_place(index),
                    "is reached twice: the nodes form a circle, or two nodes share a child",
                ));
            }
            let above = parent.map_or(DMat4::IDENTITY, |parent| placed[parent].to_world);
            let to_world = above * self.local(index, node)?;
            if !to_world.is_finite() {
                return Err(self.error(
                    self.node_place(index),
                    "its place in the world is not finite",
                ));
            }
            placed.push(Placed {
                node: index,
                parent,
                to_world,
            });
            let children = node.children.iter().flatten().rev();
            open.extend(children.map(|child| (child.value(), Some(placed.len() - 1))));
        }
        Ok(placed)
    }

    /// How messages call a node.
    pub(super) fn node_place(&self, index: usize) -> String {
        let node = self.root().nodes.get(index);
        named("node", index, node.and_then(|n| n.name.as_deref()))
    }

    /// The transform of a node in the frame of the node above.
    fn local(&self, index: usize, node: &Node) -> Result<DMat4, SceneError> {
        if let Some(columns) = node.matrix {
            return Ok(DMat4::from_cols_array(&columns.map(f64::from)));
        }
        self.placement(index, node).map(|p| p.matrix())
    }

    /// The translation, rotation and scale of a node.
    pub(super) fn placement(&self, index: usize, node: &Node) -> Result<Placement, SceneError> {
        let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
        let rotation = DQuat::from_array(rotation);
        let length = rotation.length();
        if !(length.is_finite() && length > 0.0) {
            return Err(self.error(self.node_place(index), "its rotation is not a quaternion"));
        }
        let vector =
            |v: Option<[f32; 3]>, default| v.map_or(default, |v| DVec3::from(v.map(f64::from)));
        Ok(Placement {
            translation: vector(node.translation, DVec3::ZERO),
            rotation: rotation / length,
            scale: vector(node.scale, DVec3::ONE),
        })
    }
}

impl Placement {
    pub(super) fn matrix(&self) -> DMat4 {
        DMat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}
