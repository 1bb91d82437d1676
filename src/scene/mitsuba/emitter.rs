//! Emitters without a shape; those without extent are in `light.rs`.

use glam::{DMat4, DVec3};

use super::Importer;
use super::element::Element;
use super::solar::solar_irradiance;
use super::spectrum::{colour, emitted_colour};
use super::transform::vector;
use crate::environment::{EnvironmentDescription, EnvironmentRows};
use crate::scene::SceneError;

impl<'a> Importer<'a> {
    pub(super) fn emitter(&mut self, element: &'a Element) -> Result<(), SceneError> {
        element.used.set(true);
        self.sampling_weight(element)?;
        let to_world = match element.child("to_world") {
            Some(t) => self.transform(t)?,
            None => DMat4::IDENTITY,
        };
        let environment = match element.kind() {
            "constant" => EnvironmentDescription::Constant {
                radiance: self.emitted(element, "radiance")?,
            },
            "envmap" => EnvironmentDescription::Map {
                path: self.path(element)?,
                scale: map_scale(element)?,
                to_world,
                rows: EnvironmentRows::PoleCentred,
            },
            "sunsky" | "sun" | "sky" => self.sun_sky(element, to_world)?,
            "directional" | "point" | "spot" => {
                let light = self.light_without_extent(element, to_world)?;
                self.scene.lights.push(light);
                return Ok(());
            }
            other => {
                element.mark_all();
                self.note(format!("emitter `{other}` is left out"));
                return Ok(());
            }
        };
        self.set_environment(environment);
        Ok(())
    }

    /// A sun and a sky become one; otherwise the last environment wins.
    fn set_environment(&mut self, mut environment: EnvironmentDescription) {
        use EnvironmentDescription::SunSky;
        match (&mut environment, self.scene.environment.take()) {
            (
                SunSky {
                    sun,
                    sun_irradiance,
                    sun_aperture_deg,
                    sky,
                    scale,
                    ..
                },
                Some(SunSky {
                    sun: other_sun,
                    sun_irradiance: other_irradiance,
                    sun_aperture_deg: other_aperture,
                    sky: other_sky,
                    scale: other_scale,
                    ..
                }),
            ) => {
                // The sun is bright whatever the factor of the sky.
                let own = sun_irradiance.map(|rgb| (rgb, *scale));
                let other = other_irradiance.map(|rgb| (rgb, other_scale));
                if other_sky {
                    *scale = other_scale;
                }
                let irradiance = own.or(other);
                *sun_irradiance = irradiance.map(|(rgb, of)| rgb.map(|value| value * of / *scale));
                *sun_aperture_deg = sun_aperture_deg.or(other_aperture);
                *sun |= other_sun;
                *sky |= other_sky;
            }
            (_, Some(_)) => self.note("only the last of several environments is kept"),
            (_, None) => {}
        }
        self.scene.environment = Some(environment);
    }

    /// How often light is sampled changes nothing, but that a weight of 0 puts out what no path meets.
    pub(super) fn sampling_weight(&mut self, element: &'a Element) -> Result<(), SceneError> {
        if element.float("sampling_weight")? == Some(0.0) {
            let kind = element.kind();
            self.note(format!(
                "the sampling_weight of 0 of emitter `{kind}` is ignored: it shines"
            ));
        }
        Ok(())
    }

    pub(super) fn emitted(
        &mut self,
        element: &'a Element,
        name: &str,
    ) -> Result<[f32; 3], SceneError> {
        match element.child(name) {
            Some(value) => shining(self.resolved(value)?, name),
            None => Ok([1.0; 3]),
        }
    }

    fn sun_sky(
        &mut self,
        element: &'a Element,
        to_world: DMat4,
    ) -> Result<EnvironmentDescription, SceneError> {
        let direction = match element.child("sun_direction") {
            Some(d) => vector(d, 0.0)?,
            None => {
                self.note("the sun's direction is not given (date and place are not evaluated): 45° towards +x");
                {
                    let up = if self.version.0 == 0 {
                        DVec3::Y
                    } else {
                        DVec3::Z
                    };
                    DVec3::X + to_world.transform_vector3(up).normalize_or_zero()
                }
            }
        };
        // A direction of the world, whatever `to_world` says.
        let sun_direction = direction.normalize_or_zero();
        if sun_direction == DVec3::ZERO {
            return Err(element.error("the direction of the sun is zero"));
        }
        // Version 0.x has the zenith along its y axis, version 3 along z.
        let up = if self.version.0 == 0 {
            DVec3::Y
        } else {
            DVec3::Z
        };
        let zenith = to_world.transform_vector3(up).normalize_or_zero();
        if zenith == DVec3::ZERO {
            return Err(element.error("`to_world` of the sky has no inverse"));
        }
        if zenith.dot(sun_direction) < 0.0 {
            let message = format!(
                "the sun stands below the horizon: its direction is {sun_direction}, the zenith {zenith}"
            );
            return Err(element.error(message));
        }
        let number = |name: &str, default: f64| Ok(element.float(name)?.unwrap_or(default));
        let scale = number("scale", 1.0)?;
        let sky_scale = number("sky_scale", scale)?;
        let sun_scale = number("sun_scale", scale)?;
        let kind = element.kind();
        let (sun, sky) = (
            kind != "sky" && sun_scale > 0.0,
            kind != "sun" && sky_scale > 0.0,
        );
        let albedo = match element.child("albedo") {
            Some(value) => colour(self.resolved(value)?, true)?,
            None if self.version.0 == 0 => [0.15; 3],
            None => [0.3; 3],
        };
        let turbidity = number("turbidity", 3.0)?;
        if !(1.0..=10.0).contains(&turbidity) {
            let message = format!("`turbidity` is a number from 1 to 10, not {turbidity}");
            return Err(element.child("turbidity").unwrap_or(element).error(message));
        }
        let scale = if sky { sky_scale } else { sun_scale };
        let elevation_rad = zenith.dot(sun_direction).clamp(0.0, 1.0).asin();
        let sun_irradiance = solar_irradiance(turbidity, elevation_rad)
            .map(|irradiance| (irradiance * sun_scale / scale) as f32);
        Ok(EnvironmentDescription::SunSky {
            sun_direction,
            zenith,
            turbidity: turbidity as f32,
            albedo,
            sun,
            sun_irradiance: sun.then_some(sun_irradiance),
            sun_aperture_deg: sun_aperture(element)?.filter(|_| sun),
            sky,
            scale: scale as f32,
        })
    }
}

/// Degrees across the sun: as they are, or (version 0.x) as a multiple of what they are by default.
fn sun_aperture(element: &Element) -> Result<Option<f64>, SceneError> {
    const DEFAULT: f64 = 0.5358;
    let scaled = element.float("sun_radius_scale")?.map(|s| s * DEFAULT);
    let aperture = element.float("sun_aperture")?.or(scaled);
    match aperture.is_none_or(|a| (0.0..180.0).contains(&a)) {
        true => Ok(aperture),
        false => Err(element.error("the sun must be 0 to 180 degrees wide")),
    }
}

/// What a light emits, none below 0.
pub(super) fn shining(value: &Element, name: &str) -> Result<[f32; 3], SceneError> {
    let rgb = emitted_colour(value)?;
    match rgb.iter().all(|c| c.is_finite() && *c >= 0.0) {
        true => Ok(rgb),
        false => Err(value.error(format!(
            "the {name} of a light must be finite and not below 0"
        ))),
    }
}

/// The factor of an environment map, not below 0.
fn map_scale(element: &Element) -> Result<f32, SceneError> {
    let scale = element.float("scale")?.unwrap_or(1.0) as f32;
    match scale.is_finite() && scale >= 0.0 {
        true => Ok(scale),
        false => Err(element.error(format!("the scale of a map is {scale}: below 0"))),
    }
}
