//! Colours of EXR and Radiance files whose channels are not those of Rec.709.

use glam::{DMat3, DVec3};

/// Red, green, blue and white of Rec.709 in CIE xy.
pub(super) const REC709: [[f32; 2]; 4] =
    [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];

/// Those that Radiance takes where a file names none.
const RADIANCE: [[f32; 2]; 4] = [[0.64, 0.33], [0.29, 0.60], [0.15, 0.06], [0.3333, 0.3333]];

/// Red, green and blue of files whose channels are X, Y and Z.
const XYZ: [[f32; 2]; 3] = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];

/// Files give the numbers of Rec.709 with three or four places.
const ROUNDING: f32 = 1e-3;

/// The matrix that makes linear Rec.709 of linear colours with these red, green, blue and white in CIE xy; white stays
/// as bright and is not adapted. `None` where they are those of Rec.709.
///
/// # Errors
/// A sentence, where the three primaries lie on a line.
pub(super) fn to_rec709(chromaticities: &[[f32; 2]; 4]) -> Result<Option<DMat3>, String> {
    let near = |(a, b): (&f32, &f32)| (a - b).abs() <= ROUNDING;
    let mut pairs = chromaticities.iter().flatten().zip(REC709.iter().flatten());
    if pairs.all(near) {
        return Ok(None);
    }
    match (to_xyz(chromaticities), to_xyz(&REC709)) {
        (Some(from), Some(to)) => Ok(Some(to.inverse() * from)),
        _ => Err(format!(
            "its chromaticities {chromaticities:?} are not those of three colours"
        )),
    }
}

/// As [`to_rec709`], of Radiance files: those that name the primaries of Radiance itself (white 1/3, 1/3) are taken as those
/// that name none, which everyone reads as Rec.709.
pub(super) fn hdr_to_rec709(primaries: &[[f32; 2]; 4]) -> Result<Option<DMat3>, String> {
    let near = |(a, b): (&f32, &f32)| (a - b).abs() <= ROUNDING;
    let mut pairs = primaries.iter().flatten().zip(RADIANCE.iter().flatten());
    match pairs.all(near) {
        true => Ok(None),
        false => to_rec709(primaries),
    }
}

/// From linear RGB to XYZ, with Y = 1 for white. Channels that are X, Y and Z stay, whatever white the file names.
fn to_xyz(chromaticities: &[[f32; 2]; 4]) -> Option<DMat3> {
    if chromaticities[..3] == XYZ {
        return Some(DMat3::IDENTITY);
    }
    let [red, green, blue, white] = chromaticities.map(|[x, y]| {
        let [x, y] = [f64::from(x), f64::from(y)];
        DVec3::new(x, y, 1.0 - x - y)
    });
    let primaries = DMat3::from_cols(red, green, blue);
    let sound = primaries.is_finite() && primaries.determinant().abs() > 1e-9 && white.y > 0.0;
    sound.then(|| primaries * DMat3::from_diagonal(primaries.inverse() * (white / white.y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn xyz_becomes_rec709_and_rec709_stays() {
        assert_eq!(to_rec709(&REC709), Ok(None));
        let third = 1.0 / 3.0;
        let xyz = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [third, third]];
        let matrix = to_rec709(&xyz).unwrap().unwrap();
        let daylight = [xyz[0], xyz[1], xyz[2], REC709[3]];
        assert_eq!(to_rec709(&daylight), Ok(Some(matrix)));
        // The white of Rec.709 in XYZ, and its red (IEC 61966-2-1).
        let white = matrix * DVec3::new(0.95046, 1.0, 1.08906);
        assert!(white.distance(DVec3::ONE) < 1e-3, "{white}");
        let red = matrix * DVec3::new(0.41239, 0.21264, 0.01933);
        assert!(red.distance(DVec3::X) < 1e-3, "{red}");
    }

    #[test]
    fn colours_on_a_line_are_refused() {
        let line = [[0.1, 0.1], [0.2, 0.2], [0.3, 0.3], [0.3, 0.3]];
        assert!(to_rec709(&line).is_err());
        assert!(to_rec709(&[[f32::NAN; 2]; 4]).is_err());
    }
}
