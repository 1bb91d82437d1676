//! Near and far planes of the cameras of other programs: what they cut away is seen here, and told.

use glam::DVec3;

use super::{Scene, View};

/// The depths between which a camera of another program sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// Index into the views of the scene.
    pub view: usize,
    /// Scene units along the viewing direction.
    pub near: f64,
    /// Scene units along the viewing direction; may be infinite.
    pub far: f64,
}

impl Clip {
    /// A note where something in sight lies outside of the depths.
    pub(super) fn note(&self, scene: &Scene) -> Option<String> {
        let view = scene.views.get(self.view)?;
        let triangles = scene.triangles.iter();
        let corners = |t: &[u32; 3]| t.map(|i| scene.positions[i as usize].as_dvec3());
        let cut = triangles.filter(|t| self.cuts(view, corners(t))).count();
        let Self { near, far, .. } = self;
        (cut > 0).then(|| {
            format!(
                "view `{}` sees from depth {near} to {far} in other programs: what {cut} triangles have outside of that is seen here",
                view.name
            )
        })
    }

    /// Whether a part of a triangle in the pyramid of sight is too near or too far.
    fn cuts(&self, view: &View, corners: [DVec3; 3]) -> bool {
        let seen = corners.map(|corner| {
            let away = corner - view.origin;
            DVec3::new(
                away.dot(view.right),
                away.dot(view.up),
                away.dot(view.forward),
            )
        });
        // Files have few digits.
        let (near, far) = (self.near * (1.0 - 1e-4), self.far * (1.0 + 1e-4));
        let is_outside = |p: &DVec3| p.z < near || p.z > far;
        if !seen.iter().any(is_outside) {
            return false;
        }
        let [x, y] = view.half_tangents(view.width, view.height);
        let [right, up] = view.shift;
        let sides = [
            DVec3::new(1.0, 0.0, x - right),
            DVec3::new(-1.0, 0.0, x + right),
            DVec3::new(0.0, 1.0, y - up),
            DVec3::new(0.0, -1.0, y + up),
        ];
        let mut polygon = seen.to_vec();
        for side in sides {
            polygon = inside(&polygon, side);
        }
        polygon.iter().any(is_outside)
    }
}

/// The part of a polygon on the positive side of a plane through the origin.
fn inside(polygon: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &here) in polygon.iter().enumerate() {
        let next = polygon[(i + 1) % polygon.len()];
        let [a, b] = [here, next].map(|p| p.dot(normal));
        if a >= 0.0 {
            kept.push(here);
        }
        if (a < 0.0) != (b < 0.0) {
            kept.push(here + (next - here) * (a / (a - b)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_near_or_too_far_in_sight_is_cut() {
        let view = View::look_at("main", [DVec3::ZERO, DVec3::Z, DVec3::Y], 90.0, [10, 10]);
        let clip = Clip {
            view: 0,
            near: 1.0,
            far: 5.0,
        };
        let at = |x: f64, z: f64| {
            let corner = |dx, dy| DVec3::new(x + dx, dy, z);
            clip.cuts(
                &view,
                [corner(0.0, 0.0), corner(0.2, 0.0), corner(0.0, 0.2)],
            )
        };
        assert!(!at(0.0, 3.0));
        assert!(at(0.0, 0.5));
        assert!(at(0.0, 6.0));
        assert!(!at(0.0, -2.0), "behind the camera");
        assert!(!at(3.0, 0.5), "beside the film");
        // A floor from behind the camera to far away.
        let floor = |y: f64, end: f64| {
            let corner = |x, z| DVec3::new(x, y, z);
            clip.cuts(
                &view,
                [corner(-9.0, -4.0), corner(9.0, -4.0), corner(0.0, end)],
            )
        };
        assert!(!floor(-2.0, 4.9));
        assert!(floor(-0.5, 4.9), "enters the film at a depth of 0.5");
        assert!(floor(-2.0, 7.0));
    }
}
