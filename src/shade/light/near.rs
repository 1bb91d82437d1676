//! A triangle as it is seen from nearby: places on it that are spread evenly over the directions to them (Arvo 1995, "Stratified
//! sampling of spherical triangles"). Spread over its area, those next to a surface that the triangle touches would send it any
//! number of times the light that it shines with.

use glam::DVec3;

/// Height above a triangle, as a part of its longest edge, from which on places are spread over its area: no place then sends
/// more than some times what all together do.
const HIGHEST: f32 = 0.2;

/// Whether a position at this squared distance from the centre of a triangle and at this height above it is near: `edge2` is its
/// longest edge, squared.
#[inline(always)]
pub(super) fn is_near(distance2: f32, height: f32, edge2: f32) -> bool {
    (distance2 < edge2) & (height > 0.0) & (height * height < HIGHEST * HIGHEST * edge2)
}

/// Solid angle, steradians, below which a triangle is not seen at all.
const LEAST_SOLID_ANGLE: f64 = 1e-9;

/// A triangle on the unit sphere around a position.
pub(super) struct SphericalTriangle {
    corners: [DVec3; 3],
    /// Angle at the first corner, radians.
    angle: f64,
    /// Steradians.
    pub solid_angle: f64,
}

impl SphericalTriangle {
    /// Of the ways to three corners; `None` where they lead into one plane, or nowhere.
    pub fn of(ways: [DVec3; 3]) -> Option<Self> {
        let corners = ways.map(DVec3::normalize_or_zero);
        let [a, b, c] = corners;
        // Normals of the planes of its sides.
        let sides = [a.cross(b), b.cross(c), c.cross(a)].map(DVec3::normalize_or_zero);
        let [ab, bc, ca] = sides;
        let at = |before: DVec3, after: DVec3| before.angle_between(-after);
        let angles = [at(ca, ab), at(ab, bc), at(bc, ca)];
        let solid_angle = angles.iter().sum::<f64>() - std::f64::consts::PI;
        let is_seen = solid_angle > LEAST_SOLID_ANGLE && !sides.contains(&DVec3::ZERO);
        is_seen.then_some(Self {
            corners,
            angle: angles[0],
            solid_angle,
        })
    }

    /// The unit direction at a place in [0, 1)²: areas become solid angles.
    pub fn direction(&self, [u, v]: [f64; 2]) -> DVec3 {
        let [a, b, c] = self.corners;
        // The part of the triangle up to a side from `b` to a point of the side between `a` and `c`.
        let (sin, cos) = (u * self.solid_angle - self.angle).sin_cos();
        let (sin_angle, cos_angle) = self.angle.sin_cos();
        let x = cos - cos_angle;
        let y = sin + sin_angle * a.dot(b);
        let along = ((y * cos - x * sin) * cos_angle - y) / ((y * sin + x * cos) * sin_angle);
        let along = if along.is_finite() { along } else { 1.0 };
        let third = towards(a, c, along.clamp(-1.0, 1.0));
        towards(b, third, 1.0 - v * (1.0 - third.dot(b)))
    }

    /// The place in [0, 1]² of a unit direction in the triangle: what [`SphericalTriangle::direction`] undoes.
    pub fn place(&self, direction: DVec3) -> [f64; 2] {
        let [a, b, c] = self.corners;
        // Where the side from `b` through the direction meets the one between `a` and `c`.
        let third = b.cross(direction).cross(c.cross(a)).normalize_or_zero();
        let third = if third.dot(a + c) < 0.0 {
            -third
        } else {
            third
        };
        let part = Self::of([a, b, third]).map_or(0.0, |part| part.solid_angle);
        let v = (1.0 - direction.dot(b)) / (1.0 - third.dot(b));
        let v = if v.is_finite() { v } else { 0.0 };
        [part / self.solid_angle, v].map(|x| x.clamp(0.0, 1.0))
    }
}

/// The point whose angle with `from` has this cosine, on the great circle through another.
fn towards(from: DVec3, other: DVec3, cosine: f64) -> DVec3 {
    let across = (other - from * other.dot(from)).normalize_or_zero();
    from * cosine + across * (1.0 - cosine * cosine).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    #[test]
    fn an_octant_has_its_solid_angle_and_directions_are_even_in_it() {
        let octant = SphericalTriangle::of([DVec3::X * 3.0, DVec3::Y, DVec3::Z * 0.2]);
        let octant = octant.expect("is seen");
        assert!((octant.solid_angle - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        let mut rng = Rng::new(1, 2, 3, 4);
        let count = 100_000;
        let mut mean = DVec3::ZERO;
        let mut below = 0;
        for _ in 0..count {
            let direction = octant.direction([rng.next_f64(), rng.next_f64()]);
            assert!(direction.min_element() > -1e-9 && direction.is_normalized());
            mean += direction / f64::from(count);
            below += u32::from(direction.z < 0.3);
        }
        // Of an octant the mean of each coordinate is a half, and heights are even (Archimedes).
        assert!((mean - 0.5).abs().max_element() < 0.005, "{mean}");
        assert!(
            (f64::from(below) / f64::from(count) - 0.3).abs() < 0.006,
            "{below}"
        );
    }

    #[test]
    fn places_lead_to_directions_and_back() {
        let mut rng = Rng::new(1, 2, 3, 4);
        for ways in [
            [DVec3::X * 3.0, DVec3::Y, DVec3::Z * 0.2],
            [
                DVec3::X,
                DVec3::new(0.9, 0.3, 0.1),
                DVec3::new(0.8, -0.1, 0.4),
            ],
            // More than half of what is above.
            [
                DVec3::new(1.0, 0.0, 0.1),
                DVec3::new(-0.5, 0.9, 0.1),
                DVec3::new(-0.5, -0.9, 0.1),
            ],
        ] {
            let seen = SphericalTriangle::of(ways).expect("is seen");
            for _ in 0..1000 {
                let place = [rng.next_f64(), rng.next_f64()];
                let found = seen.place(seen.direction(place));
                for (found, given) in found.into_iter().zip(place) {
                    assert!((found - given).abs() < 1e-6, "{found} {given}");
                }
            }
            assert!(seen.place(seen.corners[1]).iter().all(|x| x.is_finite()));
        }
    }

    #[test]
    fn slivers_and_triangles_seen_from_their_plane_are_not_seen() {
        let flat = [DVec3::X, DVec3::Y, DVec3::NEG_ONE.with_z(0.0) * 0.1];
        for ways in [
            [DVec3::X, DVec3::X, DVec3::Y],
            [DVec3::ZERO, DVec3::X, DVec3::Y],
            [DVec3::X, DVec3::Y, DVec3::X + DVec3::Y],
        ] {
            assert!(SphericalTriangle::of(ways).is_none(), "{ways:?}");
        }
        // From within: half of all directions, on either side.
        let around = SphericalTriangle::of(flat);
        assert!(
            around.is_none_or(|seen| (seen.solid_angle - 2.0 * std::f64::consts::PI).abs() < 1e-6)
        );
    }
}
