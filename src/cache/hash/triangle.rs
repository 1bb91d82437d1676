//! Whether a triangle touches a cube: separating axes.

use glam::DVec3;

/// The normal, and the products of three edges and three axes.
const AXES: usize = 10;

/// A triangle, and what it is on the thirteen axes that can separate it from a cube along the axes: the three of the cube, the triangle's
/// normal, and the products of its edges with the axes (Akenine-Möller 2001).
///
/// Any axis may be asked, as both are projected on it, so that a triangle without area, whose normal is rounding or nothing, is
/// no special case.
pub(super) struct Triangle {
    /// Smallest and largest corner of its bounding box.
    pub low: DVec3,
    pub high: DVec3,
    /// Components of the axes.
    x: [f64; AXES],
    y: [f64; AXES],
    z: [f64; AXES],
    /// Middle and half length of the triangle on each axis.
    middle: [f64; AXES],
    half: [f64; AXES],
    /// Half length of a cube of side 2 on each axis.
    reach: [f64; AXES],
}

impl Triangle {
    pub fn new([a, b, c]: [DVec3; 3]) -> Self {
        let edges = [b - a, c - b, a - c];
        let mut axes = [edges[0].cross(edges[1]); AXES];
        for (i, edge) in edges.iter().enumerate() {
            axes[1 + 3 * i] = DVec3::new(0.0, -edge.z, edge.y);
            axes[2 + 3 * i] = DVec3::new(edge.z, 0.0, -edge.x);
            axes[3 + 3 * i] = DVec3::new(-edge.y, edge.x, 0.0);
        }
        let mut triangle = Self {
            low: a.min(b).min(c),
            high: a.max(b).max(c),
            x: axes.map(|axis| axis.x),
            y: axes.map(|axis| axis.y),
            z: axes.map(|axis| axis.z),
            middle: [0.0; AXES],
            half: [0.0; AXES],
            reach: axes.map(|axis| axis.abs().element_sum()),
        };
        for (i, axis) in axes.iter().enumerate() {
            let on = DVec3::new(axis.dot(a), axis.dot(b), axis.dot(c));
            triangle.middle[i] = 0.5 * (on.max_element() + on.min_element());
            triangle.half[i] = 0.5 * (on.max_element() - on.min_element());
        }
        triangle
    }

    /// Whether it touches a closed cube of side `2 · half`.
    #[inline]
    pub fn touches(&self, centre: DVec3, half: f64) -> bool {
        if (centre + half).cmplt(self.low).any() || (centre - half).cmpgt(self.high).any() {
            return false;
        }
        // All axes without a branch, so that several are computed at once.
        let mut apart = false;
        for i in 0..AXES {
            let on = self.x[i] * centre.x + self.y[i] * centre.y + self.z[i] * centre.z;
            apart |= (on - self.middle[i]).abs() > self.half[i] + self.reach[i] * half;
        }
        !apart
    }
}
