//! `[environment]` and `[[light]]`.

use glam::{DMat4, DVec3};

use super::Loader;
use super::keys::Keys;
use crate::environment::EnvironmentRows;
use crate::scene::{EnvironmentDescription, LightDescription, SceneError};

impl Loader {
    pub(super) fn environment(&mut self, keys: &Keys) -> Result<(), SceneError> {
        let Some(value) = keys.get("environment") else {
            return Ok(());
        };
        let mut keys = Keys::of(keys.source, value, "[environment]")?;
        let kind = keys.kind(&["constant", "map", "sky"])?;
        keys.what = format!("[environment] ({kind})");
        let environment = match kind {
            "constant" => EnvironmentDescription::Constant {
                radiance: keys.required("radiance", keys.colour("radiance")?)?,
            },
            "map" => EnvironmentDescription::Map {
                path: self.path(&keys)?,
                scale: keys.non_negative("scale")?.unwrap_or(1.0) as f32,
                to_world: DMat4::from_rotation_y(
                    keys.number("rotate_deg")?.unwrap_or(0.0).to_radians(),
                ),
                rows: EnvironmentRows::CellCentred,
            },
            _ => sky(&keys)?,
        };
        keys.finish()?;
        self.scene.environment = Some(environment);
        Ok(())
    }

    pub(super) fn light(&mut self, keys: &Keys) -> Result<(), SceneError> {
        keys.kind(&["directional"])?;
        let direction = keys.required("direction", keys.vector("direction")?)?;
        let irradiance = keys.required("irradiance", keys.colour("irradiance")?)?;
        keys.finish()?;
        match direction.normalize_or_zero() {
            DVec3::ZERO => Err(keys.error("the `direction` of a light must not be zero")),
            direction => {
                self.scene.lights.push(LightDescription::Directional {
                    direction,
                    irradiance,
                });
                Ok(())
            }
        }
    }
}

/// Azimuth 0 is towards +z, 90 towards +x.
fn sky(keys: &Keys) -> Result<EnvironmentDescription, SceneError> {
    let elevation = keys
        .number("sun_elevation_deg")?
        .unwrap_or(45.0)
        .to_radians();
    let azimuth = keys.number("sun_azimuth_deg")?.unwrap_or(0.0).to_radians();
    Ok(EnvironmentDescription::SunSky {
        sun_direction: DVec3::new(
            azimuth.sin() * elevation.cos(),
            elevation.sin(),
            azimuth.cos() * elevation.cos(),
        ),
        turbidity: keys.positive("turbidity")?.unwrap_or(3.0) as f32,
        albedo: keys.non_negative("albedo")?.unwrap_or(0.2) as f32,
        sun: keys.boolean("sun", true)?,
        sky: keys.boolean("sky", true)?,
        scale: keys.non_negative("scale")?.unwrap_or(1.0) as f32,
    })
}
