//! The equal-area map of the hemisphere and the frame that carries it to a surface.

use glam::Vec3;

/// An orthonormal frame built from a unit normal alone, so that equal normals give equal
/// directions (Duff et al. 2017, branchless form).
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Unit; x of the local frame.
    pub tangent: Vec3,
    /// Unit; y of the local frame.
    pub bitangent: Vec3,
    /// Unit; z of the local frame.
    pub normal: Vec3,
}

impl Frame {
    /// `normal` must have unit length.
    pub fn from_normal(normal: Vec3) -> Self {
        let sign = 1.0f32.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: Vec3::new(
                1.0 + sign * normal.x * normal.x * a,
                sign * b,
                -sign * normal.x,
            ),
            bitangent: Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// A direction of the local frame (z along the normal) in the space of the normal.
    pub fn to_world(&self, local: Vec3) -> Vec3 {
        self.tangent * local.x + self.bitangent * local.y + self.normal * local.z
    }

    /// The inverse of [`Frame::to_world`].
    pub fn to_local(&self, world: Vec3) -> Vec3 {
        Vec3::new(
            world.dot(self.tangent),
            world.dot(self.bitangent),
            world.dot(self.normal),
        )
    }
}

/// Maps the unit square to the upper hemisphere (z ≥ 0) with equal areas: the diamond of
/// Clarberg's square-to-sphere map, fed with a square rotated by 45° (Clarberg 2008).
pub fn square_to_hemisphere(x: f32, y: f32) -> Vec3 {
    let (a, b) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    let (u, v) = (0.5 * (a + b), 0.5 * (a - b));
    let r = u.abs() + v.abs();
    let phi = if r == 0.0 {
        std::f32::consts::FRAC_PI_4
    } else {
        std::f32::consts::FRAC_PI_4 * ((v.abs() - u.abs()) / r + 1.0)
    };
    let planar = r * (2.0 - r * r).max(0.0).sqrt();
    Vec3::new(
        planar * phi.cos().copysign(u),
        planar * phi.sin().copysign(v),
        1.0 - r * r,
    )
}

/// The point of the unit square that [`square_to_hemisphere`] maps to a unit direction; directions
/// below the horizon count as on it.
pub fn hemisphere_to_square(d: Vec3) -> [f32; 2] {
    let r = (1.0 - d.z).clamp(0.0, 1.0).sqrt();
    let v = r * d.y.abs().atan2(d.x.abs()) * std::f32::consts::FRAC_2_PI;
    let (u, v) = ((r - v).copysign(d.x), v.copysign(d.y));
    [0.5 * (u + v) + 0.5, 0.5 * (u - v) + 0.5]
}

/// The centres of the `side * side` equal cells (2π/side² sr each) of the upper hemisphere, row by
/// row. Unit vectors in the local frame, z along the normal.
pub fn equal_area_hemisphere(side: usize) -> Vec<Vec3> {
    let centre = |i: usize| (i as f32 + 0.5) / side as f32;
    (0..side * side)
        .map(|i| square_to_hemisphere(centre(i % side), centre(i / side)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_unit_upper_and_integrate_the_cosine() {
        for side in [1, 2, 8, 32, 64] {
            let directions = equal_area_hemisphere(side);
            assert!(
                directions
                    .iter()
                    .all(|d| d.z >= 0.0 && (d.length() - 1.0).abs() < 1e-5)
            );
            let cosine =
                directions.iter().map(|d| d.z).sum::<f32>() * 2.0 / directions.len() as f32;
            // The error of cell centres falls with the square of the side.
            let bound = 2.5 / (side * side) as f32;
            assert!((cosine - 1.0).abs() < bound, "side {side}: {cosine}");
        }
    }

    #[test]
    fn directions_map_back_to_the_square() {
        for i in 0..400 {
            let (x, y) = ((i % 20) as f32 / 19.0, (i / 20) as f32 / 19.0);
            let [u, v] = hemisphere_to_square(square_to_hemisphere(x, y));
            assert!((u - x).abs().max((v - y).abs()) < 1e-3, "{x} {y}: {u} {v}");
        }
        let [u, v] = hemisphere_to_square(Vec3::new(0.6, 0.0, -0.8));
        let level = hemisphere_to_square(Vec3::X);
        assert_eq!([u, v], level);
        let pole = hemisphere_to_square(Vec3::Z);
        assert!(pole.iter().all(|x| (x - 0.5).abs() < 1e-6), "{pole:?}");
    }

    #[test]
    fn frames_are_orthonormal_and_right_handed_at_the_poles_too() {
        for n in [
            Vec3::Z,
            -Vec3::Z,
            Vec3::X,
            Vec3::new(0.3, -0.4, -0.999).normalize(),
        ] {
            let f = Frame::from_normal(n);
            assert!((f.tangent.cross(f.bitangent) - n).length() < 1e-5, "{n}");
            let d = Vec3::new(0.1, 0.7, 0.2);
            assert!((f.to_local(f.to_world(d)) - d).length() < 1e-5);
        }
    }
}
