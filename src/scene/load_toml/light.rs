//! `[environment]` and `[[light]]`.

use std::ops::RangeInclusive;

use glam::{DMat4, DVec3};

use super::Loader;
use super::keys::Keys;
use crate::environment::{EnvironmentDescription, EnvironmentRows};
use crate::scene::{LightDescription, LightKind, SceneError};

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
                path: self.file(&keys)?,
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

    pub(super) fn light(&mut self, keys: &mut Keys) -> Result<(), SceneError> {
        let kind = keys.kind(&["point", "spot", "directional"])?;
        let name = match keys.string("name")? {
            Some(name) => name.to_owned(),
            None => format!("{kind} {}", self.scene.lights.len()),
        };
        keys.what = format!("[[light]] ({kind})");
        let kind = match kind {
            "point" => LightKind::Point {
                position: keys.required("position", keys.vector("position")?)?,
                intensity: keys.required("intensity", keys.colour("intensity")?)?,
            },
            "spot" => spot(keys)?,
            _ => LightKind::Directional {
                direction: unit(keys, keys.required("direction", keys.vector("direction")?)?)?,
                irradiance: keys.required("irradiance", keys.colour("irradiance")?)?,
            },
        };
        keys.finish()?;
        self.scene.lights.push(LightDescription { name, kind });
        Ok(())
    }
}

/// Angles count from the axis; without a beam width it is three quarters of the cutoff angle.
fn spot(keys: &Keys) -> Result<LightKind, SceneError> {
    let position = keys.required("position", keys.vector("position")?)?;
    let direction = match (keys.vector("target")?, keys.vector("direction")?) {
        (Some(target), None) => target - position,
        (None, Some(direction)) => direction,
        _ => return Err(keys.error("a spot light needs either `target` or `direction`")),
    };
    let cutoff_deg = keys.required("cutoff_deg", keys.positive("cutoff_deg")?)?;
    let beam_width_deg = keys.non_negative("beam_width_deg")?;
    for (key, angle, most) in [
        ("cutoff_deg", Some(cutoff_deg), 180.0),
        ("beam_width_deg", beam_width_deg, cutoff_deg),
    ] {
        if let (Some(value), true) = (keys.get(key), angle.is_some_and(|angle| angle > most)) {
            let expected = format!("an angle from the axis of at most {most}");
            return Err(keys.wrong(key, value, &expected));
        }
    }
    Ok(LightKind::Spot {
        position,
        direction: unit(keys, direction)?,
        intensity: keys.required("intensity", keys.colour("intensity")?)?,
        beam_width_deg: beam_width_deg.unwrap_or(0.75 * cutoff_deg),
        cutoff_deg,
    })
}

/// The direction of a light, of length 1.
fn unit(keys: &Keys, direction: DVec3) -> Result<DVec3, SceneError> {
    match direction.normalize_or_zero() {
        DVec3::ZERO => Err(keys.error("the direction of a light must not be zero")),
        direction => Ok(direction),
    }
}

/// Azimuth 0 is towards +z, 90 towards +x.
fn sky(keys: &Keys) -> Result<EnvironmentDescription, SceneError> {
    let within = |key: &'static str, default: f64, range: RangeInclusive<f64>, expected: &str| {
        let number = keys.number(key)?.unwrap_or(default);
        match (range.contains(&number), keys.get(key)) {
            (false, Some(value)) => Err(keys.wrong(key, value, expected)),
            _ => Ok(number),
        }
    };
    let upward = "0 to 180 degrees above the horizon";
    let elevation = within("sun_elevation_deg", 45.0, 0.0..=180.0, upward)?.to_radians();
    let turbidity = within("turbidity", 3.0, 1.0..=10.0, "a number from 1 to 10")?;
    let albedo = within("albedo", 0.2, 0.0..=1.0, "a number from 0 to 1")?;
    let azimuth = keys.number("sun_azimuth_deg")?.unwrap_or(0.0).to_radians();
    Ok(EnvironmentDescription::SunSky {
        sun_direction: DVec3::new(
            azimuth.sin() * elevation.cos(),
            elevation.sin(),
            azimuth.cos() * elevation.cos(),
        ),
        zenith: DVec3::Y,
        turbidity: turbidity as f32,
        albedo: [albedo as f32; 3],
        sun: keys.boolean("sun", true)?,
        sun_irradiance: None,
        sun_aperture_deg: None,
        sky: keys.boolean("sky", true)?,
        scale: keys.non_negative("scale")?.unwrap_or(1.0) as f32,
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::parse_toml;
    use super::*;

    const HEAD: &str = "[[view]]\norigin = [0, 0, 9]\ntarget = [0, 0, 0]\nfov_deg = 45\n\
                        [[shape]]\nkind = \"cube\"\n[[light]]\n";

    fn load(light: &str) -> Result<LightKind, String> {
        let text = format!("{HEAD}{light}");
        let scene = parse_toml(&text, Some(Path::new("scene.toml")), "s");
        scene
            .map(|mut scene| scene.lights.remove(0).kind)
            .map_err(|e| e.to_string())
    }

    #[test]
    fn lights_without_extent() {
        for (text, expected) in [
            (
                "kind = \"point\"\nposition = [1, 2, 3]\nintensity = 4",
                "Point { position: DVec3(1.0, 2.0, 3.0), intensity: [4.0, 4.0, 4.0] }",
            ),
            (
                "kind = \"spot\"\nposition = [0, 2, 0]\ntarget = [0, 1, 0]\nintensity = [1, 2, 3]\ncutoff_deg = 40",
                "Spot { position: DVec3(0.0, 2.0, 0.0), direction: DVec3(0.0, -1.0, 0.0), intensity: [1.0, 2.0, 3.0], beam_width_deg: 30.0, cutoff_deg: 40.0 }",
            ),
            (
                "kind = \"spot\"\nposition = [0, 2, 0]\ndirection = [3, 0, 0]\nintensity = 1\ncutoff_deg = 180\nbeam_width_deg = 180",
                "Spot { position: DVec3(0.0, 2.0, 0.0), direction: DVec3(1.0, 0.0, 0.0), intensity: [1.0, 1.0, 1.0], beam_width_deg: 180.0, cutoff_deg: 180.0 }",
            ),
        ] {
            assert_eq!(format!("{:?}", load(text).unwrap()), expected);
        }
    }

    #[test]
    fn wrong_skies_have_places() {
        let load = |keys: &str| {
            let text = format!(
                "environment = {{ kind = \"sky\", {keys} }}\n{}",
                HEAD.replace("[[light]]\n", "")
            );
            let scene = parse_toml(&text, Some(Path::new("scene.toml")), "s");
            scene.map(drop).map_err(|error| error.to_string())
        };
        load("turbidity = 10, albedo = 1, sun_elevation_deg = 0").expect("a sky");
        for (keys, expected) in [
            (
                "turbidity = 40",
                "turbidity` of [environment] (sky): expected a number from 1 to 10, found 40",
            ),
            (
                "albedo = 1.5",
                "albedo` of [environment] (sky): expected a number from 0 to 1, found 1.5",
            ),
            (
                "sun_elevation_deg = -5",
                "sun_elevation_deg` of [environment] (sky): expected 0 to 180 degrees above the horizon, found -5",
            ),
        ] {
            let error = load(keys).expect_err(keys);
            assert!(
                error.starts_with("scene.toml:1:") && error.contains(expected),
                "{error}"
            );
        }
    }

    #[test]
    fn wrong_lights_have_places() {
        let spot = "kind = \"spot\"\nposition = [0, 2, 0]\n";
        for (text, place, expected) in [
            ("kind = \"spott\"".to_owned(), "8:8", "did you mean `spot`?"),
            (
                "kind = \"point\"\nintensity = 1".to_owned(),
                "7:1",
                "[[light]] (point) needs `position`",
            ),
            (
                "kind = \"point\"\nposition = [0, 0, 0]\nintensity = [1, -1, 0]".to_owned(),
                "10:13",
                "none below 0",
            ),
            (
                "kind = \"point\"\nposition = [0, 0, 0]\nintensity = inf".to_owned(),
                "10:13",
                "`intensity`",
            ),
            (
                "kind = \"point\"\nposition = [0, 1e308, 0]\nintensity = 1".to_owned(),
                "9:12",
                "3 finite numbers of at most 3.4e38",
            ),
            (
                "kind = \"point\"\nposition = [0, 0, 0]\nintensity = 1e39".to_owned(),
                "10:13",
                "`intensity`",
            ),
            (
                "kind = \"point\"\nposition = [nan, 0, 0]\nintensity = 1".to_owned(),
                "9:12",
                "`position`",
            ),
            (
                "kind = \"point\"\nposition = [0, 0, 0]\nintensity = 1\ncutoff_deg = 3".to_owned(),
                "11:1",
                "unknown key `cutoff_deg`",
            ),
            (
                format!("{spot}target = [0, 2, 0]\nintensity = 1\ncutoff_deg = 3"),
                "7:1",
                "must not be zero",
            ),
            (
                format!("{spot}intensity = 1\ncutoff_deg = 3"),
                "7:1",
                "either `target` or `direction`",
            ),
            (
                format!("{spot}direction = [0, 1, 0]\nintensity = 1\ncutoff_deg = 180.5"),
                "12:14",
                "at most 180",
            ),
            (
                format!(
                    "{spot}direction = [0, 1, 0]\nintensity = 1\ncutoff_deg = 9\nbeam_width_deg = 10"
                ),
                "13:18",
                "at most 9",
            ),
        ] {
            let error = load(&text).unwrap_err();
            assert!(
                error.starts_with(&format!("scene.toml:{place}:")),
                "{error}"
            );
            assert!(error.contains(expected), "{error} ({expected})");
        }
    }
}
