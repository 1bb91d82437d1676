//! Colours: `<rgb>`, `<srgb>`, `<spectrum>`, `<blackbody>` as linear Rec.709.

use super::cie::{DAYLIGHT, FIRST_NM, LAST_NM, OBSERVER, STEP_NM};
use super::element::Element;
use crate::image::srgb_decode;
use crate::scene::SceneError;

/// The radiance or irradiance of an element. A flat `<spectrum>` has the chromaticity of equal
/// energy, (1.205, 0.948, 0.909), as in Mitsuba's RGB modes.
pub(super) fn emitted_colour(element: &Element) -> Result<[f32; 3], SceneError> {
    let rgb = colour(element, false)?;
    let flat = element.tag == "spectrum"
        && element.attribute("value").is_some_and(|v| {
            !v.contains(':') && element.numbers("value").is_ok_and(|n| n.len() == 1)
        });
    if !flat {
        return Ok(rgb);
    }
    let white = of_spectrum(&[[FIRST_NM, 1.0], [LAST_NM, 1.0]], false);
    Ok(std::array::from_fn(|c| rgb[c] * white[c] as f32))
}

/// The colour of an element; `bounded` ones (reflectances) are clamped to [0, 1].
///
/// As in Mitsuba's RGB modes, the spectrum of a reflectance is seen under daylight (D65, so that a
/// flat one is grey), any other under equal energy.
pub(super) fn colour(element: &Element, bounded: bool) -> Result<[f32; 3], SceneError> {
    element.used.set(true);
    let result = match element.tag.as_str() {
        "srgb" => srgb(element)?,
        "blackbody" => blackbody(element)?,
        "spectrum" | "texture" if !element.kind().is_empty() => of_plugin(element, bounded)?,
        "spectrum" if element.attribute("filename").is_some() => {
            let pairs = spectrum_file(element)?;
            of_spectrum(&pairs, bounded)
        }
        "spectrum" if element.attribute("value").is_some_and(|v| v.contains(':')) => {
            of_spectrum(&pairs(element)?, bounded)
        }
        "rgb" | "color" | "spectrum" | "float" | "integer" => match element.numbers("value")?[..] {
            [grey] => [grey; 3],
            [r, g, b] => [r, g, b],
            ref other => {
                let message = format!("a colour has one or three numbers, not {}", other.len());
                return Err(element.error(message));
            }
        },
        other => return Err(element.error(format!("<{other}> is not a colour"))),
    };
    if result.iter().any(|v| !v.is_finite()) {
        return Err(element.error("the colour is not finite"));
    }
    Ok(result.map(|v| v as f32))
}

/// A spectrum that is a plugin.
fn of_plugin(element: &Element, bounded: bool) -> Result<[f64; 3], SceneError> {
    Ok(match element.kind() {
        // Daylight is the white of Rec.709.
        "d65" => match element.child("color") {
            Some(inner) => colour(inner, bounded)?.map(f64::from),
            None => [element.float("scale")?.unwrap_or(1.0); 3],
        },
        "uniform" => [element.float("value")?.unwrap_or(1.0); 3],
        "srgb" | "rgb" => match element.child("color") {
            Some(inner) => colour(inner, bounded)?.map(f64::from),
            None => return Err(element.error("a colour needs a `color`")),
        },
        "regular" => {
            let values = list(element, "values")?;
            let [first, last] = [("min", 360.0), ("max", 830.0)].map(|(end, default)| {
                let named = |word: &str| element.float(&format!("{word}_{end}"));
                let found = named("wavelength").and_then(|w| Ok(w.or(named("lambda")?)));
                found.map(|w| w.unwrap_or(default))
            });
            let (first, last) = (first?, last?);
            let step = (last - first) / (values.len().max(2) - 1) as f64;
            let pairs = values.iter().enumerate();
            let pairs = pairs.map(|(i, v)| [first + step * i as f64, *v]).collect();
            of_spectrum(&increasing(element, pairs)?, bounded)
        }
        "irregular" => {
            let [wavelengths, values] = [list(element, "wavelengths")?, list(element, "values")?];
            if wavelengths.len() != values.len() {
                let message = format!(
                    "{} wavelengths have {} values",
                    wavelengths.len(),
                    values.len()
                );
                return Err(element.error(message));
            }
            let pairs = wavelengths.into_iter().zip(values);
            let pairs = pairs.map(<[f64; 2]>::from).collect();
            of_spectrum(&increasing(element, pairs)?, bounded)
        }
        "blackbody" => match element.float("temperature")? {
            Some(temperature) if temperature > 0.0 => planck(temperature, 1.0),
            _ => return Err(element.error("a black body needs a `temperature` above 0, in kelvin")),
        },
        other => {
            let known = "d65, uniform, srgb, regular, irregular and blackbody are read";
            return Err(element.error(format!("the spectrum `{other}` is not read here: {known}")));
        }
    })
}

/// The numbers of a string parameter.
pub(super) fn list(element: &Element, name: &str) -> Result<Vec<f64>, SceneError> {
    match element.child(name) {
        Some(child) => child.numbers("value"),
        None => Err(element.error(format!("`{}` needs `{name}`", element.kind()))),
    }
}

/// `#rrggbb` or three sRGB-coded numbers in [0, 1].
fn srgb(element: &Element) -> Result<[f64; 3], SceneError> {
    let text = element.required("value")?.trim();
    let coded = match text.strip_prefix('#') {
        Some(hex) if hex.len() == 6 && hex.is_ascii() => {
            let channel = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16);
            match (channel(0), channel(2), channel(4)) {
                (Ok(r), Ok(g), Ok(b)) => [r, g, b].map(|v| f64::from(v) / 255.0),
                _ => return Err(element.error(format!("`{text}` is not a colour like #80ff00"))),
            }
        }
        Some(_) => return Err(element.error(format!("`{text}` is not a colour like #80ff00"))),
        None => match element.numbers("value")?[..] {
            [grey] => [grey; 3],
            [r, g, b] => [r, g, b],
            _ => return Err(element.error("a colour has one or three numbers")),
        },
    };
    Ok(coded.map(|v| f64::from(srgb_decode(v as f32))))
}

/// `wavelength:value` pairs, wavelengths (nm) increasing.
fn pairs(element: &Element) -> Result<Vec<[f64; 2]>, SceneError> {
    let text = element.required("value")?;
    let words = text
        .split([',', ' ', '\t', '\n', '\r'])
        .filter(|w| !w.is_empty());
    let pairs: Result<Vec<_>, _> = words
        .map(|word| {
            let pair = word.split_once(':').and_then(|(w, v)| {
                Some([w.trim().parse::<f64>().ok()?, v.trim().parse::<f64>().ok()?])
            });
            pair.ok_or_else(|| element.error(format!("`{word}` is not wavelength:value")))
        })
        .collect();
    increasing(element, pairs?)
}

/// The lines of an `.spd` file beside the scene.
fn spectrum_file(element: &Element) -> Result<Vec<[f64; 2]>, SceneError> {
    let folder = element.file.parent().unwrap_or("".as_ref());
    let path = folder.join(element.required("filename")?);
    let text = crate::files::check_ends(&path)
        .and_then(|()| std::fs::read_to_string(&path))
        .map_err(|e| element.error(format!("{}: {e}", path.display())))?;
    let mut pairs = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if line.is_empty() {
            continue;
        }
        let numbers: Vec<f64> = line
            .split_whitespace()
            .filter_map(|w| w.parse().ok())
            .collect();
        let [wavelength, value] = numbers[..] else {
            return Err(SceneError::At {
                file: path,
                line: number + 1,
                column: 1,
                message: "expected a wavelength and a value".into(),
            });
        };
        pairs.push([wavelength, value]);
    }
    increasing(element, pairs)
}

fn increasing(element: &Element, pairs: Vec<[f64; 2]>) -> Result<Vec<[f64; 2]>, SceneError> {
    if pairs.is_empty() || pairs.windows(2).any(|w| w[0][0] >= w[1][0]) {
        return Err(element.error("the wavelengths of a spectrum must increase"));
    }
    Ok(pairs)
}

/// A black body of `temperature` kelvin, radiance in W/(m² sr nm), times `scale`.
fn blackbody(element: &Element) -> Result<[f64; 3], SceneError> {
    let text = element.required("temperature")?.trim();
    let number = text.trim_end_matches(['k', 'K']).trim();
    let temperature: f64 = number
        .parse()
        .map_err(|_| element.error(format!("`{text}` is not a temperature like 5000K")))?;
    let scale = match element.attribute("scale") {
        Some(_) => element.numbers("scale")?.first().copied().unwrap_or(1.0),
        None => 1.0,
    };
    Ok(planck(temperature, scale))
}

/// A black body of so many kelvin, times a scale.
fn planck(temperature: f64, scale: f64) -> [f64; 3] {
    const SPEED: f64 = 299_792_458.0;
    const PLANCK: f64 = 6.626_070_15e-34;
    const BOLTZMANN: f64 = 1.380_649e-23;
    let radiance = |nm: f64| {
        let wavelength = nm * 1e-9;
        let exponent = PLANCK * SPEED / (wavelength * BOLTZMANN * temperature);
        2.0 * PLANCK * SPEED * SPEED / (wavelength.powi(5) * exponent.exp_m1()) * 1e-9 * scale
    };
    let pairs: Vec<[f64; 2]> = (0..81)
        .map(|i| FIRST_NM + STEP_NM * f64::from(i))
        .map(|nm| [nm, radiance(nm)])
        .collect();
    of_spectrum(&pairs, false)
}

/// Linear Rec.709 of a piecewise linear spectrum (zero outside its ends), normalized so that a flat
/// spectrum of 1 has luminance 1; negative values are clamped. Bounded ones are seen under D65.
fn of_spectrum(pairs: &[[f64; 2]], bounded: bool) -> [f64; 3] {
    let mut xyz = [0.0; 3];
    let mut total_y = 0.0;
    let steps = 1600;
    for i in 0..=steps {
        let nm = FIRST_NM + (LAST_NM - FIRST_NM) * f64::from(i) / f64::from(steps);
        let light = if bounded { daylight(nm) } else { 1.0 };
        let matching = observer(nm).map(|m| m * light);
        total_y += matching[1];
        let value = interpolated(pairs, nm);
        for (sum, m) in xyz.iter_mut().zip(matching) {
            *sum += m * value;
        }
    }
    let [x, y, z] = xyz.map(|v| v / total_y);
    let rgb = [
        3.240_479 * x - 1.537_150 * y - 0.498_535 * z,
        -0.969_256 * x + 1.875_991 * y + 0.041_556 * z,
        0.055_648 * x - 0.204_043 * y + 1.057_311 * z,
    ];
    rgb.map(|v| v.clamp(0.0, if bounded { 1.0 } else { f64::MAX }))
}

/// Relative power of CIE D65.
fn daylight(nm: f64) -> f64 {
    let at = ((nm - FIRST_NM) / (2.0 * STEP_NM)).clamp(0.0, (DAYLIGHT.len() - 1) as f64);
    let index = (at as usize).min(DAYLIGHT.len() - 2);
    let t = at - index as f64;
    DAYLIGHT[index] * (1.0 - t) + DAYLIGHT[index + 1] * t
}

fn observer(nm: f64) -> [f64; 3] {
    let at = ((nm - FIRST_NM) / STEP_NM).clamp(0.0, (OBSERVER.len() - 1) as f64);
    let index = (at as usize).min(OBSERVER.len() - 2);
    let t = at - index as f64;
    std::array::from_fn(|c| OBSERVER[index][c] * (1.0 - t) + OBSERVER[index + 1][c] * t)
}

fn interpolated(pairs: &[[f64; 2]], nm: f64) -> f64 {
    let next = pairs.partition_point(|p| p[0] <= nm);
    match (next.checked_sub(1).map(|i| pairs[i]), pairs.get(next)) {
        (Some([w0, v0]), Some([w1, v1])) => v0 + (v1 - v0) * (nm - w0) / (w1 - w0),
        (Some([w, v]), None) if w == nm => v,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::parse::parse_document;
    use super::*;

    fn of(xml: &str) -> [f32; 3] {
        let text = format!("<scene version='3.0.0'>{xml}</scene>");
        let document = parse_document(Path::new("s.xml"), &text).unwrap();
        colour(&document.root.children[0], false).unwrap()
    }

    fn assert_near(actual: [f32; 3], expected: [f32; 3], tolerance: f32) {
        for (a, e) in actual.iter().zip(expected) {
            assert!(
                (a - e).abs() <= tolerance * e.abs().max(0.01),
                "{actual:?} {expected:?}"
            );
        }
    }

    #[test]
    fn flat_spectra_and_plain_numbers() {
        assert_near(
            of("<spectrum value='300:1 900:1'/>"),
            [1.2048, 0.9483, 0.9087],
            2e-3,
        );
        assert_eq!(of("<spectrum value='16000'/>"), [16000.0; 3]);
        assert_eq!(of("<rgb value='0.1, 0.2 0.3'/>"), [0.1, 0.2, 0.3]);
        assert_near(of("<srgb value='#ff00bc'/>"), [1.0, 0.0, 0.502_886], 1e-4);
    }

    #[test]
    fn daylight_is_white() {
        assert_eq!(
            of("<spectrum type='d65'><float name='scale' value='10'/></spectrum>"),
            [10.0; 3]
        );
        assert_eq!(of("<spectrum type='d65'/>"), [1.0; 3]);
    }

    #[test]
    fn spectra_may_be_plugins() {
        let plugin =
            |kind: &str, inner: &str| of(&format!("<spectrum type='{kind}'>{inner}</spectrum>"));
        assert_eq!(
            plugin("uniform", "<float name='value' value='3'/>"),
            [3.0; 3]
        );
        assert_eq!(
            plugin("srgb", "<rgb name='color' value='0.3 0.2 0.1'/>"),
            [0.3, 0.2, 0.1]
        );
        let pairs = of("<spectrum value='400:1 500:2 600:3 700:4'/>");
        let values = "<string name='values' value='1, 2, 3, 4'/>";
        let ends =
            "<float name='wavelength_min' value='400'/><float name='wavelength_max' value='700'/>";
        assert_eq!(plugin("regular", &format!("{values}{ends}")), pairs);
        let places = "<string name='wavelengths' value='400, 500, 600, 700'/>";
        assert_eq!(plugin("irregular", &format!("{values}{places}")), pairs);
        assert_eq!(
            plugin("blackbody", "<float name='temperature' value='4000'/>"),
            of("<blackbody temperature='4000'/>")
        );
        let refused = "<scene version='3.0.0'><spectrum type='discrete'/></scene>";
        let document = parse_document(Path::new("s.xml"), refused).unwrap();
        let error = colour(&document.root.children[0], false)
            .unwrap_err()
            .to_string();
        assert!(error.contains("`discrete` is not read here"), "{error}");
    }

    #[test]
    fn black_bodies_redden_as_they_cool() {
        let warm = of("<blackbody temperature='2700K'/>");
        let cool = of("<blackbody temperature='9000' scale='0.01'/>");
        assert!(warm[0] > 2.0 * warm[2]);
        assert!(cool[2] > cool[0]);
    }
}
