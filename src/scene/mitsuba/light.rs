//! Emitters without extent: `directional`, `point` and `spot`.

use glam::{DMat4, DVec3};

use super::Importer;
use super::element::Element;
use super::transform::vector;
use crate::scene::{LightDescription, LightKind, SceneError};

impl<'a> Importer<'a> {
    pub(super) fn light_without_extent(
        &mut self,
        element: &'a Element,
        to_world: DMat4,
    ) -> Result<LightDescription, SceneError> {
        let place = to_world.transform_point3(DVec3::ZERO);
        let forward = to_world.transform_vector3(DVec3::Z);
        let kind = match element.kind() {
            "directional" => LightKind::Directional {
                direction: unit(element, own(element, "direction")?.unwrap_or(forward))?,
                irradiance: self.emitted(element, "irradiance")?,
            },
            "point" => LightKind::Point {
                position: own(element, "position")?.unwrap_or(place),
                intensity: self.emitted(element, "intensity")?,
            },
            _ => {
                if !keeps_angles(&to_world) {
                    self.note(
                        "the cone of a spot light stays round under a to_world that does not",
                    );
                }
                let [beam_width_deg, cutoff_deg] = angles(element)?;
                LightKind::Spot {
                    position: place,
                    direction: unit(element, forward)?,
                    intensity: self.emitted(element, "intensity")?,
                    beam_width_deg,
                    cutoff_deg,
                }
            }
        };
        let name = element.id().unwrap_or(element.kind());
        Ok(LightDescription {
            name: name.to_owned(),
            kind,
        })
    }
}

/// A parameter that stands in place of `to_world`.
fn own(element: &Element, name: &str) -> Result<Option<DVec3>, SceneError> {
    let Some(child) = element.child(name) else {
        return Ok(None);
    };
    if element.child("to_world").is_some() {
        let message = format!("a light has either `{name}` or `to_world`, not both");
        return Err(child.error(message));
    }
    let value = vector(child, 0.0)?;
    match value.is_finite() {
        true => Ok(Some(value)),
        false => Err(child.error(format!("the {name} of the light is not finite"))),
    }
}

fn unit(element: &Element, direction: DVec3) -> Result<DVec3, SceneError> {
    match direction.normalize_or_zero() {
        DVec3::ZERO => Err(element.error("the direction of the light is zero")),
        direction => Ok(direction),
    }
}

/// Beam width and cutoff angle of a spot light, degrees from its axis.
fn angles(element: &Element) -> Result<[f64; 2], SceneError> {
    let cutoff = element.float("cutoff_angle")?.unwrap_or(20.0);
    let beam_width = element.float("beam_width")?.unwrap_or(0.75 * cutoff);
    for (name, sound, expected) in [
        (
            "cutoff_angle",
            cutoff > 0.0 && cutoff <= 180.0,
            "above 0 and at most 180",
        ),
        (
            "beam_width",
            (0.0..=cutoff).contains(&beam_width),
            "of at least 0 and at most the cutoff angle",
        ),
    ] {
        if !sound {
            let place = element.child(name).unwrap_or(element);
            return Err(place.error(format!("`{name}` must be an angle in degrees {expected}")));
        }
    }
    Ok([beam_width, cutoff])
}

/// Whether a transform turns, moves and scales evenly, no more.
fn keeps_angles(transform: &DMat4) -> bool {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| transform.transform_vector3(axis));
    let squared = x.length_squared();
    let even = |other: f64| (other - squared).abs() <= 1e-5 * squared;
    let square = |a: DVec3, b: DVec3| a.dot(b).abs() <= 1e-5 * squared;
    even(y.length_squared())
        && even(z.length_squared())
        && square(x, y)
        && square(y, z)
        && square(z, x)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::import;
    use super::super::parse::parse_document;
    use super::*;

    fn load(emitters: &str) -> Result<(Vec<LightDescription>, Vec<String>), String> {
        let text =
            format!("<scene version='3.0.0'><sensor type='perspective'/>\n{emitters}</scene>");
        let document = parse_document(Path::new("s.xml"), &text).expect("XML");
        let scene = import(&document, Path::new("s.xml"), "s").map_err(|e| e.to_string())?;
        Ok((scene.lights, scene.notes))
    }

    #[test]
    fn lights_stand_where_their_parameter_or_transform_says() {
        let (lights, notes) = load(
            "<emitter type='point'><point name='position' value='1 2 3'/><rgb name='intensity' value='4 5 6'/></emitter>
             <emitter type='point'><transform name='to_world'><translate x='7'/></transform></emitter>
             <emitter type='spot'><transform name='to_world'><scale value='3'/><lookat origin='0,2,0' target='0,0,0' up='1,0,0'/></transform><float name='cutoffAngle' value='40'/></emitter>
             <emitter type='directional'><transform name='to_world'><rotate x='1' angle='90'/></transform></emitter>
             <emitter type='spot'><float name='beam_width' value='20'/><texture name='texture' type='bitmap'/><transform name='to_world'><scale x='2'/></transform></emitter>",
        )
        .unwrap();
        let expected = [
            "Point { position: DVec3(1.0, 2.0, 3.0), intensity: [4.0, 5.0, 6.0] }",
            "Point { position: DVec3(7.0, 0.0, 0.0), intensity: [1.0, 1.0, 1.0] }",
            "Spot { position: DVec3(0.0, 2.0, 0.0), direction: DVec3(0.0, -1.0, 0.0), intensity: [1.0, 1.0, 1.0], beam_width_deg: 30.0, cutoff_deg: 40.0 }",
        ];
        for (light, expected) in lights.iter().zip(expected) {
            assert_eq!(format!("{:?}", light.kind), expected);
        }
        assert!(
            matches!(&lights[3].kind, LightKind::Directional { direction, .. } if direction.distance(DVec3::NEG_Y) < 1e-12)
        );
        assert!(
            matches!(&lights[4].kind, LightKind::Spot { beam_width_deg, cutoff_deg, .. } if [*beam_width_deg, *cutoff_deg] == [20.0, 20.0])
        );
        assert_eq!(
            notes,
            [
                "parameter `texture` of emitter `spot` is ignored",
                "the cone of a spot light stays round under a to_world that does not"
            ]
        );
    }

    #[test]
    fn what_cannot_shine_has_a_place() {
        for (kind, parameters, expected) in [
            (
                "point",
                "<rgb name='intensity' value='1 -1 1'/>",
                "intensity",
            ),
            ("point", "<rgb name='intensity' value='1e39'/>", "intensity"),
            ("spot", "<rgb name='intensity' value='nan'/>", "not finite"),
            ("point", "<point name='position' x='inf'/>", "position"),
            (
                "point",
                "<point name='position' x='1'/><transform name='to_world'/>",
                "not both",
            ),
            (
                "spot",
                "<float name='cutoff_angle' value='181'/>",
                "cutoff_angle",
            ),
            (
                "spot",
                "<float name='cutoff_angle' value='0'/>",
                "cutoff_angle",
            ),
            (
                "spot",
                "<float name='cutoff_angle' value='nan'/>",
                "cutoff_angle",
            ),
            (
                "spot",
                "<float name='beam_width' value='21'/>",
                "beam_width",
            ),
            (
                "spot",
                "<float name='beam_width' value='-1'/>",
                "beam_width",
            ),
            (
                "spot",
                "<transform name='to_world'><scale z='0'/></transform>",
                "direction of the light is zero",
            ),
            (
                "directional",
                "<vector name='direction' x='0'/>",
                "direction of the light is zero",
            ),
        ] {
            let error =
                load(&format!("<emitter type='{kind}'>{parameters}</emitter>")).unwrap_err();
            assert!(error.starts_with("s.xml:2:"), "{error}");
            assert!(error.contains(expected), "{error} ({expected})");
        }
    }
}
