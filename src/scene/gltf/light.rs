//! Lights without extent: `KHR_lights_punctual`.

use ::gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use glam::DVec3;

use super::Importer;
use super::document::{named, valid};
use super::node::Placed;
use crate::scene::{LightDescription, LightKind, SceneError};

impl Importer<'_> {
    /// Adds the light of a node: it stands at the node's origin and shines along its −z.
    ///
    /// Candela become W/sr and lux W/m², number for number.
    pub(super) fn light(&mut self, index: usize, placed: &Placed) -> Result<(), SceneError> {
        let to_world = &placed.to_world;
        let lights: &[Light] = self.file.root().as_ref();
        let Some(light) = lights.get(index) else {
            return Err(self.file.error(format!("light {index}"), "is not there"));
        };
        let place = named("light", index, light.name.as_deref());
        let fail = |message: &str| self.file.error(&place, message);
        let strength = light.color.map(|c| c * light.intensity);
        if !strength.iter().all(|s| s.is_finite() && *s >= 0.0) {
            return Err(fail(
                "its colour times its intensity must be finite and not below 0",
            ));
        }
        let position = to_world.transform_point3(DVec3::ZERO);
        let direction = to_world.transform_vector3(DVec3::NEG_Z).normalize_or_zero();
        let light_type = valid(&light.type_).ok_or_else(|| fail("its type is unknown"))?;
        if light_type != Type::Point && direction == DVec3::ZERO {
            return Err(fail("its direction is zero: a node above it scales by 0"));
        }
        let described = match light_type {
            Type::Directional => LightKind::Directional {
                direction,
                irradiance: strength,
            },
            Type::Point => LightKind::Point {
                position,
                intensity: strength,
            },
            Type::Spot => {
                let spot = light.spot.clone().unwrap_or_default();
                let angles = [spot.inner_cone_angle, spot.outer_cone_angle].map(f64::from);
                let [inner, outer] = angles;
                if !(inner >= 0.0 && inner <= outer && outer > 0.0 && outer <= std::f64::consts::PI)
                {
                    return Err(fail("its cone angles must be 0 ≤ inner ≤ outer ≤ π"));
                }
                LightKind::Spot {
                    position,
                    direction,
                    intensity: strength,
                    beam_width_deg: inner.to_degrees().min(180.0),
                    cutoff_deg: outer.to_degrees().min(180.0),
                }
            }
        };
        if light_type == Type::Spot {
            self.note("the beam of a spot light falls linearly with the angle, not as the square of cosines");
        }
        if light.range.is_some() {
            self.note(
                "the range of a light is ignored: its light falls with the square of the distance",
            );
        }
        let of_node = self.file.root().nodes[placed.node].name.as_deref();
        let names = [of_node, light.name.as_deref()].into_iter().flatten();
        let name = names.into_iter().find(|name| !name.is_empty());
        let index = self.scene.lights.len();
        self.carried(placed).lights.push(index);
        self.scene.lights.push(LightDescription {
            name: name.unwrap_or_default().to_owned(),
            kind: described,
        });
        Ok(())
    }
}
