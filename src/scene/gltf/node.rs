//! The tree of nodes.

use std::collections::{HashMap, HashSet};

use ::gltf::json::Index;
use ::gltf::json::scene::Node;
use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};

use super::animation::Animated;
use super::document::{GltfFile, named};
use crate::scene::SceneError;
use crate::scene::motion::{Link, Placement};

/// A node that is reached from the roots of a scene, at rest.
pub(super) struct Placed {
    /// Index among the nodes of the file.
    pub node: usize,
    /// Index of the node above it in the list of those reached.
    parent: Option<usize>,
    /// In the frame of the node above.
    local: Local,
    pub to_world: DMat4,
    /// Index in the list of the lowest node that moves, itself included, of those above it.
    pub carrier: Option<usize>,
}

/// A node in the frame of the node above.
#[derive(Clone, Copy)]
enum Local {
    Matrix(DMat4),
    Trs(Trs),
}

/// Translation, rotation and scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trs {
    pub translation: DVec3,
    pub rotation: DQuat,
    pub scale: DVec3,
}

impl GltfFile {
    /// The nodes below some roots, each after the one above it. A node that is reached twice is an error: glTF
    /// has trees only, and a circle would never end.
    ///
    /// At rest nodes are as the file puts them; one that is animated and has no extent there is as at the first
    /// key where it has.
    pub(super) fn nodes_below(
        &self,
        roots: &[usize],
        animated: &HashMap<usize, Animated>,
    ) -> Result<Vec<Placed>, SceneError> {
        let nodes = &self.root().nodes;
        let mut placed: Vec<Placed> = Vec::new();
        let mut seen = vec![false; nodes.len()];
        let mut open: Vec<(usize, Option<usize>)> =
            roots.iter().rev().map(|&root| (root, None)).collect();
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
            let own = animated.get(&index);
            let local = self.local(index, node, own)?;
            let above = parent.map_or(DMat4::IDENTITY, |parent| placed[parent].to_world);
            let to_world = above * local.matrix();
            if !to_world.is_finite() {
                let message = "its place in the world is not finite";
                return Err(self.error(self.node_place(index), message));
            }
            let carrier = match own {
                Some(_) => Some(placed.len()),
                None => parent.and_then(|parent| placed[parent].carrier),
            };
            let children = node.children.iter().flatten().rev();
            open.extend(children.map(|child| (child.value(), Some(placed.len()))));
            placed.push(Placed {
                node: index,
                parent,
                local,
                to_world,
                carrier,
            });
        }
        Ok(placed)
    }

    /// Refuses nodes that are below themselves, which no scene can show.
    pub(super) fn refuse_circles(&self) -> Result<(), SceneError> {
        let nodes = &self.root().nodes;
        let mut reached = vec![false; nodes.len()];
        let mut open = self.nodes_without_parent();
        while let Some(index) = open.pop() {
            if let Some(reached) = reached.get_mut(index)
                && !std::mem::replace(reached, true)
            {
                open.extend(nodes[index].children.iter().flatten().map(Index::value));
            }
        }
        match reached.iter().position(|reached| !reached) {
            None => Ok(()),
            Some(index) => {
                let message =
                    "no way leads to it from a node without a parent: nodes form a circle";
                Err(self.error(self.node_place(index), message))
            }
        }
    }

    /// Indices of the nodes that are no children, in the order of the file.
    pub(super) fn nodes_without_parent(&self) -> Vec<usize> {
        let nodes = &self.root().nodes;
        let children = nodes.iter().flat_map(|node| node.children.iter().flatten());
        let children: HashSet<usize> = children.map(Index::value).collect();
        (0..nodes.len()).filter(|i| !children.contains(i)).collect()
    }

    /// How messages call a node.
    pub(super) fn node_place(&self, index: usize) -> String {
        let node = self.root().nodes.get(index);
        named("node", index, node.and_then(|n| n.name.as_deref()))
    }

    /// The transform of a node in the frame of the node above.
    fn local(
        &self,
        index: usize,
        node: &Node,
        animated: Option<&Animated>,
    ) -> Result<Local, SceneError> {
        let fail = |message: &str| Err(self.error(self.node_place(index), message));
        if let Some(columns) = node.matrix {
            let matrix = DMat4::from_cols_array(&columns.map(f64::from));
            return match matrix.row(3) == DVec4::W {
                true => Ok(Local::Matrix(matrix)),
                false => fail("the last row of its matrix is not 0 0 0 1"),
            };
        }
        let rotation = DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from));
        let length = rotation.length();
        if !(length.is_finite() && length > 0.0) {
            return fail("its rotation is not a quaternion");
        }
        let vector = |v: Option<[f32; 3]>, rest| v.map_or(rest, |v| DVec3::from(v.map(f64::from)));
        let rest = Trs {
            translation: vector(node.translation, DVec3::ZERO),
            rotation: rotation / length,
            scale: vector(node.scale, DVec3::ONE),
        };
        let has_extent = |trs: &Trs| trs.scale.abs().min_element() > 0.0;
        let keyed = animated.map_or(Vec::new(), |animated| {
            let times_s = animated.times_s().into_iter();
            times_s.map(|time_s| animated.at(&rest, time_s)).collect()
        });
        let mut all = std::iter::once(rest).chain(keyed);
        Ok(Local::Trs(all.find(has_extent).unwrap_or(rest)))
    }
}

/// How a node that is animated moves what it carries: from where it is at rest to where it is at a time. `None`
/// where it has no extent at rest, and so nothing to be seen.
pub(super) fn placement(
    nodes: &[Placed],
    animated: &HashMap<usize, Animated>,
    carrier: usize,
) -> Option<Placement> {
    let back = DAffine3::from_mat4(nodes[carrier].to_world).inverse();
    if !back.is_finite() {
        return None;
    }
    let mut links = vec![Link::Fixed(back)];
    let mut next = Some(carrier);
    while let Some(at) = next {
        let placed = &nodes[at];
        match (&placed.local, animated.get(&placed.node)) {
            (Local::Trs(rest), Some(animated)) => {
                links.extend(animated.links(rest).into_iter().rev())
            }
            (local, _) => links.push(Link::Fixed(DAffine3::from_mat4(local.matrix()))),
        }
        next = placed.parent;
    }
    links.reverse();
    Some(Placement { links })
}

impl Local {
    fn matrix(&self) -> DMat4 {
        match self {
            Self::Matrix(matrix) => *matrix,
            Self::Trs(trs) => {
                DMat4::from_scale_rotation_translation(trs.scale, trs.rotation, trs.translation)
            }
        }
    }
}
