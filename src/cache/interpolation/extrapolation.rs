//! Records that say how their function changes around them.

use glam::Vec3;

use super::gradient::{Gradient, MAX_ANGLE_DEG};
use crate::sample::HemisphereEdges;

/// What extrapolates the records of a technique, which knows changes as `C`.
pub struct Extrapolation<C> {
    /// Weights of the records, and how much they may change a value.
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

    /// Room for so many more records, and not for others.
    pub fn make_room(&mut self, count: usize) {
        self.anchors.reserve_exact(count);
    }

    /// Appends a record at a position, with its unit normal.
    pub fn add(&mut self, position: Vec3, normal: Vec3, change: C) {
        self.anchors.push(Anchor {
            position,
            normal,
            change,
        });
    }

    /// The step from a record to a shading point (position and unit normal), and how the function
    /// changes around the record. `None` beyond the largest angle between normals: there the record
    /// knows nothing of the half space that the point sees, and its plain value errs least.
    pub fn around(&self, record: u32, position: Vec3, normal: Vec3) -> Option<(Vec3, &C)> {
        let anchor = &self.anchors[record as usize];
        let alike = anchor.normal.dot(normal) >= self.least_cosine;
        alike.then(|| (position - anchor.position, &anchor.change))
    }

    /// Where a record is.
    pub fn position(&self, record: u32) -> Vec3 {
        self.anchors[record as usize].position
    }

    /// The changes of all records.
    pub fn changes(&self) -> impl Iterator<Item = &C> {
        self.anchors.iter().map(|anchor| &anchor.change)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_extrapolated_within_its_largest_angle_only() {
        let mut records = Extrapolation::new(Gradient::default(), HemisphereEdges::new(4));
        records.add(Vec3::new(1.0, 2.0, 3.0), Vec3::Z, "first");
        records.add(Vec3::ZERO, Vec3::X, "second");
        let there = Vec3::new(1.5, 2.0, 3.0);
        let turned = |degrees: f32| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            Vec3::new(0.0, sin, cos)
        };
        let (step, change) = records.around(0, there, turned(59.0)).expect("a change");
        assert_eq!((step, *change), (Vec3::new(0.5, 0.0, 0.0), "first"));
        for degrees in [61.0, 90.0, 180.0] {
            assert!(
                records.around(0, there, turned(degrees)).is_none(),
                "{degrees}"
            );
        }
        assert!(records.around(1, there, turned(0.0)).is_none());
        assert!(records.around(0, there, Vec3::NAN).is_none());
        assert_eq!(
            records.changes().copied().collect::<Vec<_>>(),
            ["first", "second"]
        );
    }
}
