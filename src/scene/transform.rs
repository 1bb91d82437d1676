//! A similarity of a whole scene, for tests of scale, rotation and translation.

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::{EnvironmentDescription, LightDescription, SceneDescription};

impl SceneDescription {
    /// Scales, then turns about +y, then moves everything, cameras, lights and declared lengths
    /// included. Metres per unit follow where they are declared, so that lengths in metres stay what they were.
    pub fn transformed(mut self, scale: f64, rotate_y_deg: f64, translate: DVec3) -> Self {
        let turn = DQuat::from_rotation_y(rotate_y_deg.to_radians());
        let all = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, translate);
        for shape in &mut self.shapes {
            shape.to_world = DMat4::from(all) * shape.to_world;
        }
        for view in &mut self.views {
            view.origin = all.transform_point3(view.origin);
            view.right = turn * view.right;
            view.up = turn * view.up;
            view.forward = turn * view.forward;
        }
        for light in &mut self.lights {
            let LightDescription::Directional { direction, .. } = light;
            *direction = turn * *direction;
        }
        match &mut self.environment {
            Some(
                EnvironmentDescription::Map { to_world, .. }
                | EnvironmentDescription::Embedded { to_world, .. },
            ) => {
                *to_world = DMat4::from_quat(turn) * *to_world;
            }
            Some(EnvironmentDescription::SunSky { sun_direction, .. }) => {
                *sun_direction = turn * *sun_direction;
            }
            Some(EnvironmentDescription::Constant { .. }) | None => {}
        }
        self.ao_distance = self.ao_distance.map(|d| d * scale);
        self.metres_per_unit = self.metres_per_unit.map(|m| m / scale);
        self
    }
}
