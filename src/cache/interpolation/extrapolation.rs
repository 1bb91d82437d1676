//! Records that say how their function changes around them.

use glam::Vec3;

use super::gradient::{Gradient, MAX_ANGLE_DEG};
use crate::sample::HemisphereEdges;

/// What extrapolates the records of a technique, which knows changes as `C`.
pub struct Extrapolation<C> {
    pub rule: Gradient,
    /// Of the grid that the records' changes are made from.
    pub edges: HemisphereEdges,
    least_cosine: f32,
    anchors: Vec<Anchor<C>>,
}

struct Anchor<C> {
    position: Vec3,
    normal: Vec3,
    change: C,
}

impl<C> Extrapolation<C> {
    /// No records yet.
    pub fn new(rule: Gradient, edges: HemisphereEdges) -> Self {
        Self {
            rule,
            edges,
            least_cosine: MAX_ANGLE_DEG.to_radians().cos(),
            anchors: Vec::new(),
        }
    }

    /// Appends a record at a position, with its unit normal.
    pub fn add(&mut self, (position, normal): (Vec3, Vec3), change: C) {
        self.anchors.push(Anchor {
            position,
            normal,
            change,
        });
    }

    /// The step from a record to a shading point (position and unit normal), and how the function
    /// changes around the record. `None` beyond the largest angle between normals: there the record
    /// knows nothing of the half space that the point sees, and its plain value errs least.
    pub fn around(&self, record: u32, (position, normal): (Vec3, Vec3)) -> Option<(Vec3, &C)> {
        let anchor = &self.anchors[record as usize];
        let alike = anchor.normal.dot(normal) >= self.least_cosine;
        alike.then(|| (position - anchor.position, &anchor.change))
    }

    /// The changes of all records.
    pub fn changes(&self) -> impl Iterator<Item = &C> {
        self.anchors.iter().map(|anchor| &anchor.change)
    }

    /// Bytes held by the records.
    pub fn bytes(&self) -> usize {
        self.anchors.len() * size_of::<Anchor<C>>()
    }
}
