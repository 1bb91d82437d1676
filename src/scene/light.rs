//! Lights without extent as a built scene has them.

use glam::{DVec3, Vec3};

use super::{LightKind, Scene};

/// A point or spot light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// Scene units, in the frame of [`Scene::positions`].
    pub position: Vec3,
    /// Radiant intensity (W/sr, linear RGB), of a spot light along its axis.
    pub intensity: [f32; 3],
    /// Where a spot light shines; `None` shines evenly in all directions.
    pub cone: Option<Cone>,
}

/// The directions of a spot light: full intensity up to the beam width, then falling linearly with the
/// angle to zero at the cutoff.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit, from the light into the middle of its beam.
    pub axis: Vec3,
    /// Radians from the axis.
    beam_width: f32,
    /// Radians from the axis.
    cutoff: f32,
}

impl Cone {
    /// Angles are in degrees from the axis, beam width ≤ cutoff ≤ 180; equal ones make a hard edge.
    pub fn new(axis: Vec3, beam_width_deg: f64, cutoff_deg: f64) -> Self {
        Self {
            axis,
            beam_width: beam_width_deg.to_radians() as f32,
            cutoff: cutoff_deg.to_radians() as f32,
        }
    }

    /// Angle in radians of a direction from the axis.
    pub fn angle(&self, direction: Vec3) -> f32 {
        let sine = self.axis.cross(direction).length();
        sine.atan2(self.axis.dot(direction))
    }

    /// Share of the intensity that is sent at an angle (radians) from the axis.
    pub fn share(&self, angle: f32) -> f32 {
        if angle <= self.beam_width {
            1.0
        } else if angle >= self.cutoff {
            0.0
        } else {
            (self.cutoff - angle) / (self.cutoff - self.beam_width)
        }
    }

    /// The share integrated over all directions, sr.
    pub fn solid_angle(&self) -> f64 {
        let (beam, cutoff) = (f64::from(self.beam_width), f64::from(self.cutoff));
        let mean_cosine = if cutoff > beam {
            (cutoff.sin() - beam.sin()) / (cutoff - beam)
        } else {
            cutoff.cos()
        };
        std::f64::consts::TAU * (1.0 - mean_cosine)
    }
}

impl PointLight {
    /// Radiant intensity (W/sr, linear RGB) in a unit direction away from the light.
    pub fn sent(&self, direction: Vec3) -> Vec3 {
        let share = self
            .cone
            .map_or(1.0, |cone| cone.share(cone.angle(direction)));
        Vec3::from(self.intensity) * share
    }

    /// Irradiance (W/m², linear RGB) of a surface that faces the light, at `way` (scene units) from it; 0
    /// at the light itself.
    pub fn irradiance(&self, way: Vec3) -> Vec3 {
        let irradiance = self.sent(way.normalize_or_zero()) / way.length_squared();
        match irradiance.is_finite() {
            true => irradiance,
            false => Vec3::ZERO,
        }
    }

    /// Power (W) of an intensity of 1: the solid angle that it fills.
    pub fn solid_angle(&self) -> f64 {
        let all = 2.0 * std::f64::consts::TAU;
        self.cone.map_or(all, |cone| cone.solid_angle())
    }

    /// A direction uniformly among those it can send in, and their solid angle (sr); `u`, `v` in [0, 1).
    pub fn direction(&self, [u, v]: [f64; 2]) -> (Vec3, f32) {
        let (axis, cutoff) = self.cone.map_or((Vec3::Y, std::f64::consts::PI), |cone| {
            (cone.axis, f64::from(cone.cutoff))
        });
        // 1 − cos, without cancellation in narrow cones.
        let height = 2.0 * (0.5 * cutoff).sin().powi(2);
        let depth = u * height;
        let sine = (depth * (2.0 - depth)).max(0.0).sqrt();
        let (y, x) = (std::f64::consts::TAU * v).sin_cos();
        let local = DVec3::new(sine * x, sine * y, 1.0 - depth).as_vec3();
        let direction = crate::sample::Frame::from_normal(axis).to_world(local);
        (
            direction.normalize_or(axis),
            (std::f64::consts::TAU * height) as f32,
        )
    }
}

impl Scene {
    /// Replaces point, spot and directional lights, which are in the coordinates of the file. Those of no strength keep
    /// their place, so that a light has the same index at all times.
    pub(crate) fn set_lights_without_extent<'a>(
        &mut self,
        lights: impl IntoIterator<Item = &'a LightKind>,
    ) {
        self.point_lights.clear();
        self.directional_lights.clear();
        for light in lights {
            let origin = self.origin;
            let point = |position: &DVec3, intensity: &[f32; 3], cone| PointLight {
                position: (*position - origin).as_vec3(),
                intensity: *intensity,
                cone,
            };
            match light {
                LightKind::Directional {
                    direction,
                    irradiance,
                } => self
                    .directional_lights
                    .push((direction.normalize().as_vec3(), *irradiance)),
                LightKind::Point {
                    position,
                    intensity,
                } => self.point_lights.push(point(position, intensity, None)),
                LightKind::Spot {
                    position,
                    direction,
                    intensity,
                    beam_width_deg,
                    cutoff_deg,
                } => {
                    let axis = direction.normalize().as_vec3();
                    let cone = Cone::new(axis, *beam_width_deg, *cutoff_deg);
                    self.point_lights
                        .push(point(position, intensity, Some(cone)));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(beam_width_deg: f64, cutoff_deg: f64) -> PointLight {
        PointLight {
            position: Vec3::ZERO,
            intensity: [3.0, 2.0, 1.0],
            cone: Some(Cone::new(
                Vec3::new(0.6, 0.0, 0.8),
                beam_width_deg,
                cutoff_deg,
            )),
        }
    }

    #[test]
    fn a_beam_falls_linearly_with_the_angle() {
        let cone = Cone::new(Vec3::Z, 20.0, 40.0);
        for (degrees, expected) in [
            (0.0, 1.0),
            (20.0, 1.0),
            (25.0, 0.75),
            (39.0, 0.05),
            (41.0, 0.0),
        ] {
            let (sine, cosine) = f32::to_radians(degrees).sin_cos();
            let share = cone.share(cone.angle(Vec3::new(sine, 0.0, cosine)));
            assert!((share - expected).abs() < 1e-5, "{degrees}: {share}");
        }
        let hard = Cone::new(Vec3::Z, 30.0, 30.0);
        assert_eq!([0.52, 0.53].map(|angle| hard.share(angle)), [1.0, 0.0]);
    }

    #[test]
    fn solid_angles_are_what_sampled_directions_say() {
        for (beam_width, cutoff) in [(0.0, 0.1), (20.0, 40.0), (30.0, 30.0), (100.0, 180.0)] {
            let light = spot(beam_width, cutoff);
            let side = 400;
            let mut sum = 0.0;
            for i in 0..side * side {
                let [u, v] = [i % side, i / side].map(|k| (f64::from(k) + 0.5) / f64::from(side));
                let (direction, solid_angle) = light.direction([u, v]);
                assert!((direction.length() - 1.0).abs() < 1e-6);
                sum += f64::from(light.sent(direction).z * solid_angle);
            }
            let (mean, expected) = (sum / f64::from(side * side), light.solid_angle());
            assert!((mean / expected - 1.0).abs() < 2e-3, "{mean} {expected}");
        }
        let everywhere = PointLight {
            cone: None,
            ..spot(1.0, 2.0)
        };
        let (_, solid_angle) = everywhere.direction([0.3, 0.4]);
        assert!((f64::from(solid_angle) - everywhere.solid_angle()).abs() < 1e-5);
    }
}
