//! One cone, and the smallest cones around others.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Quat, Vec3};

use crate::sample::Frame;

/// Light from the directions around an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cone {
    /// D: unit direction towards the light.
    pub axis: Vec3,
    /// α: angle between the axis and the edge, radians in [0, π/2].
    pub half_angle: f32,
    /// `∫ L dω` over the cone, linear RGB: the irradiance of a surface that faces it.
    pub light: Vec3,
}

/// Widest half angle: a surface receives light from a hemisphere.
pub(super) const WIDEST: f32 = FRAC_PI_2;

/// More than rounding changes the cosine of two unit vectors by.
const ROUNDING: f32 = 2e-6;

/// Angle between unit vectors, radians in [0, π]; exact for small ones too.
pub fn angle_between(a: Vec3, b: Vec3) -> f32 {
    a.cross(b).length().atan2(a.dot(b))
}

impl Cone {
    /// Solid angle, sr.
    pub fn solid_angle(&self) -> f32 {
        TAU * self.height()
    }

    /// 1 − cos α, without cancellation in narrow cones.
    pub fn height(&self) -> f32 {
        2.0 * (0.5 * self.half_angle).sin().powi(2)
    }

    /// Angle from the edge out to a direction, radians; negative inside.
    pub fn gap_to(&self, direction: Vec3) -> f32 {
        angle_between(self.axis, direction) - self.half_angle
    }

    /// Whether a unit direction lies inside, as `gap_to(direction) <= 0.0` says, mostly without its arc tangent.
    pub fn holds(&self, direction: Vec3) -> bool {
        // Alternating series of the cosine bound it from both sides.
        let square = self.half_angle * self.half_angle;
        let above = 1.0 - square * (0.5 - square / 24.0);
        let below = above - square * square * square / 720.0;
        let cosine = self.axis.dot(direction);
        if cosine > above + ROUNDING {
            return true;
        }
        cosine >= below - ROUNDING && self.gap_to(direction) <= 0.0
    }

    /// A unit direction inside, uniformly by solid angle; `u` in [0, 1) goes from the axis to the edge, `turn` in
    /// [0, 1) around it.
    pub fn direction(&self, frame: &Frame, [u, turn]: [f32; 2]) -> Vec3 {
        let depth = u * self.height();
        let sine = (depth * (2.0 - depth)).max(0.0).sqrt();
        let (y, x) = (TAU * turn).sin_cos();
        frame.to_world(Vec3::new(sine * x, sine * y, 1.0 - depth))
    }

    /// A unit direction at an angle (radians) from the axis; `turn` in [0, 1) goes around it.
    pub fn direction_at(&self, angle: f32, turn: f32) -> Vec3 {
        let ((sine, cosine), (y, x)) = (angle.sin_cos(), (TAU * turn).sin_cos());
        let local = Vec3::new(sine * x, sine * y, cosine);
        Frame::from_normal(self.axis).to_world(local).normalize()
    }

    /// The smallest cone around this one and a direction, with the light of this one.
    pub fn around(&self, direction: Vec3) -> Self {
        self.enclosing(&Cone {
            axis: direction,
            ..Cone::default()
        })
    }

    /// The smallest cone around both, with the light of both.
    pub fn enclosing(&self, other: &Self) -> Self {
        let (wide, narrow) = self.by_width(other);
        let light = self.light + other.light;
        match wide.enclosing_angle(narrow) {
            None => Self { light, ..*wide },
            Some(half_angle) if half_angle >= WIDEST => {
                // No smaller cone than a hemisphere is needed: around the middle of both.
                let middle = (wide.axis + narrow.axis).try_normalize();
                Self {
                    axis: middle.unwrap_or(wide.axis),
                    half_angle: WIDEST,
                    light,
                }
            }
            Some(half_angle) => Self {
                axis: turned(wide.axis, narrow.axis, half_angle - wide.half_angle),
                half_angle,
                light,
            },
        }
    }

    /// Half angle of [`Cone::enclosing`].
    pub(super) fn half_angle_around(&self, other: &Self) -> f32 {
        let (wide, narrow) = self.by_width(other);
        let half_angle = wide.enclosing_angle(narrow);
        half_angle.map_or(wide.half_angle, |angle| angle.min(WIDEST))
    }

    /// The wider one first.
    fn by_width<'a>(&'a self, other: &'a Self) -> (&'a Self, &'a Self) {
        match self.half_angle >= other.half_angle {
            true => (self, other),
            false => (other, self),
        }
    }

    /// Half angle, however large, of the smallest cone around this one and a narrower one; `None` where that is this one.
    fn enclosing_angle(&self, narrow: &Self) -> Option<f32> {
        let apart = angle_between(self.axis, narrow.axis);
        let outside = apart + narrow.half_angle > self.half_angle;
        outside.then_some(0.5 * (self.half_angle + narrow.half_angle + apart))
    }
}

/// A unit vector turned towards another by an angle (radians, negative away from it); where they are parallel it stays.
pub(super) fn turned(from: Vec3, towards: Vec3, angle: f32) -> Vec3 {
    match from.cross(towards).try_normalize() {
        Some(axis) if angle.abs() <= PI => {
            (Quat::from_axis_angle(axis, angle) * from).normalize_or(from)
        }
        _ => from,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    fn at(degrees: f32) -> Vec3 {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        Vec3::new(sine, 0.0, cosine)
    }

    fn cone(degrees: f32, half_angle_deg: f32) -> Cone {
        Cone {
            axis: at(degrees),
            half_angle: half_angle_deg.to_radians(),
            light: Vec3::ONE,
        }
    }

    fn assert_is(found: &Cone, degrees: f32, half_angle_deg: f32) {
        let off = angle_between(found.axis, at(degrees)).to_degrees();
        let wider = found.half_angle.to_degrees() - half_angle_deg;
        assert!(off < 1e-3 && wider.abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn the_smallest_cone_around_two_touches_their_far_edges() {
        assert_is(&cone(0.0, 10.0).enclosing(&cone(40.0, 6.0)), 18.0, 28.0);
        assert_is(&cone(40.0, 6.0).enclosing(&cone(0.0, 10.0)), 18.0, 28.0);
        assert_is(&cone(0.0, 30.0).enclosing(&cone(12.0, 5.0)), 0.0, 30.0);
        assert_is(&cone(0.0, 10.0).around(at(30.0)), 10.0, 20.0);
        assert_is(&cone(0.0, 10.0).around(at(5.0)), 0.0, 10.0);
        assert_eq!(cone(0.0, 10.0).enclosing(&cone(40.0, 6.0)).light.x, 2.0);
        for (a, b) in [(0.0, 10.0), (12.0, 30.0), (150.0, 70.0)] {
            let (a, b) = (cone(a, b), cone(20.0, 25.0));
            assert_eq!(a.half_angle_around(&b), a.enclosing(&b).half_angle);
        }
    }

    #[test]
    fn what_is_wider_than_a_hemisphere_is_one() {
        let all = cone(0.0, 60.0).enclosing(&cone(120.0, 60.0));
        assert_is(&all, 60.0, 90.0);
        let opposite = cone(0.0, 50.0).enclosing(&cone(180.0, 50.0));
        assert!(opposite.axis.is_normalized() && opposite.half_angle == WIDEST);
    }

    #[test]
    fn a_cone_holds_what_has_no_gap_to_it() {
        let mut rng = Rng::new(3, 0, 0, 0);
        for half_angle_deg in [0.0, 0.01, 1.43, 8.0, 45.0, 90.0] {
            let cone = cone(25.0, half_angle_deg);
            let (mut inside, count) = (0, 20_000);
            for _ in 0..count {
                // Half of them near the edge.
                let spread = if rng.next_f32() < 0.5 { 1e-4 } else { 1.0 };
                let angle = cone.half_angle * (1.0 + spread * (2.0 * rng.next_f32() - 1.0));
                let direction = cone.direction_at(angle, rng.next_f32());
                assert_eq!(cone.holds(direction), cone.gap_to(direction) <= 0.0);
                inside += u32::from(cone.holds(direction));
            }
            assert!(half_angle_deg == 0.0 || (count / 4..3 * count / 4).contains(&inside));
            assert!(cone.holds(cone.axis) && !cone.holds(-cone.axis));
        }
    }

    #[test]
    fn directions_fill_the_cone_evenly() {
        for half_angle_deg in [0.01, 1.43, 30.0, 90.0] {
            let cone = cone(25.0, half_angle_deg);
            let frame = Frame::from_normal(cone.axis);
            let side = 64;
            let mut mean = 0.0f64;
            for i in 0..side * side {
                let u = [i % side, i / side].map(|k| (k as f32 + 0.5) / side as f32);
                let direction = cone.direction(&frame, u);
                assert!(direction.is_normalized());
                assert!(cone.gap_to(direction) <= 1e-6);
                let off = f64::from(angle_between(direction, cone.axis));
                mean += (1.0 - off.cos()) / f64::from(side * side);
            }
            // The mean of 1 − cos over a cone is half of what it is at the edge.
            let expected = 0.5 * (1.0 - f64::from(cone.half_angle).cos());
            assert!((mean / expected - 1.0).abs() < 2e-3, "{mean} {expected}");
        }
    }

    #[test]
    fn angles_are_exact_where_cosines_are_not() {
        let small = angle_between(Vec3::Z, Vec3::new(1e-5, 0.0, 1.0).normalize());
        assert!((small / 1e-5 - 1.0).abs() < 1e-4, "{small}");
        assert!((angle_between(Vec3::Z, Vec3::NEG_Z) - PI).abs() < 1e-6);
        let edge = cone(40.0, 8.0).direction_at(0.1, 0.3);
        assert!((angle_between(edge, at(40.0)) - 0.1).abs() < 1e-5);
    }
}
