//! Environments of what a scene declares.

use std::path::Path;

use glam::{DMat4, DQuat, DVec3};

use super::{
    Environment, EnvironmentDescription, EnvironmentError, EnvironmentOptions, SunSky,
    embedded_map, sun_sky_image,
};
use crate::image::Picture;

impl Environment {
    /// Reads or generates what a scene declares.
    ///
    /// # Errors
    /// Unreadable or empty maps, transforms other than rotations, suns below the horizon.
    pub fn from_description(
        description: &EnvironmentDescription,
    ) -> Result<Self, EnvironmentError> {
        match description {
            EnvironmentDescription::Constant { radiance } => Ok(Self::constant(*radiance)),
            EnvironmentDescription::SunSky {
                sun_direction,
                zenith,
                turbidity,
                albedo,
                sun,
                sun_irradiance,
                sun_aperture_deg,
                sky,
                scale,
            } => {
                // The image has the zenith in its top row.
                let upright = match *zenith == DVec3::Y {
                    true => DQuat::IDENTITY,
                    false => DQuat::from_rotation_arc(DVec3::Y, *zenith),
                };
                let image = sun_sky_image(&SunSky {
                    sun_direction: upright.inverse() * *sun_direction,
                    turbidity: *turbidity,
                    albedo: *albedo,
                    sun: *sun,
                    sun_irradiance: *sun_irradiance,
                    sun_aperture_deg: *sun_aperture_deg,
                    sky: *sky,
                })?;
                let options = EnvironmentOptions {
                    scale: *scale,
                    to_world: DMat4::from_quat(upright),
                    ..EnvironmentOptions::default()
                };
                Self::from_image(&image, &options)
            }
            EnvironmentDescription::Embedded {
                name,
                scale,
                to_world,
            } => {
                let image = embedded_map(name)
                    .ok_or_else(|| EnvironmentError::Unknown { name: name.clone() })?;
                let options = EnvironmentOptions {
                    scale: *scale,
                    to_world: *to_world,
                    ..EnvironmentOptions::default()
                };
                Self::from_image(&image, &options)
            }
            EnvironmentDescription::Map {
                path,
                scale,
                to_world,
                rows,
            } => {
                let fail = |message: String| EnvironmentError::Read {
                    path: path.clone(),
                    message,
                };
                let picture = crate::image::read_picture(path);
                let picture = picture.map_err(|error| fail(error.without_path()))?;
                if let Some(window) = &picture.window {
                    return Err(fail(format!("{window}; a map needs all directions")));
                }
                if picture.cube {
                    let what = "its six sides are those of a cube (envmap)";
                    return Err(fail(format!("{what}; a map has a row to a latitude")));
                }
                let unheeded = unheeded(path, &picture);
                let image = picture.into_linear();
                let options = EnvironmentOptions {
                    scale: *scale,
                    to_world: *to_world,
                    rows: *rows,
                };
                // What is no number or below 0 shines no more than 0 does.
                let shines = |channel: &f32| channel.is_finite() && *channel > 0.0;
                let is_black = !image.pixels.iter().flatten().any(shines);
                let mut environment = Self::from_image(&image, &options)?;
                environment.unheeded = unheeded;
                environment.black_file = is_black.then(|| path.clone());
                Ok(environment)
            }
        }
    }

    /// What was replaced in its image, and what is not followed of its file.
    pub fn notes(&self) -> impl Iterator<Item = String> + '_ {
        self.sanitised
            .note()
            .into_iter()
            .chain(self.unheeded.iter().cloned())
    }

    /// The file that it was read from, if no texel in it shines.
    pub fn black_file(&self) -> Option<&Path> {
        self.black_file.as_deref()
    }
}

/// What is not followed of the file of a map, or is unusual in it.
fn unheeded(path: &Path, picture: &Picture) -> Vec<String> {
    let mut notes = picture.unheeded.clone();
    if picture.translucent > 0 {
        let pixels = picture.translucent;
        notes.push(format!(
            "{pixels} pixels are not opaque; their alpha is left out"
        ));
    }
    let (width, height) = (picture.image.width, picture.image.height);
    // Strips of one texel are made on purpose.
    if width.min(height) > 1 && width != 2 * height {
        notes.push(format!(
            "{width}x{height} pixels are not twice as wide as high: they are stretched over all directions, a row to a \
             latitude"
        ));
    }
    let place = |note: String| format!("environment map {}: {note}", path.display());
    notes.into_iter().map(place).collect()
}
