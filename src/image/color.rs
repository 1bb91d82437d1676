//! The sRGB curve, and values as a display takes them.

use super::Image;

/// Decodes an sRGB-coded value to linear light (IEC 61966-2-1).
///
/// Values outside `[0, 1]` are continued by the same formula; negative ones linearly.
pub fn srgb_decode(coded: f32) -> f32 {
    if coded <= 0.04045 {
        coded / 12.92
    } else {
        ((coded + 0.055) / 1.055).powf(2.4)
    }
}

/// Codes linear light as sRGB; the inverse of [`srgb_decode`].
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// The value clamped to `[0, 1]`; NaN becomes 0.
pub fn clamp_unit(value: f32) -> f32 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// A copy of an sRGB-coded image in linear light.
pub fn decode_srgb(coded: &Image) -> Image {
    coded.map(|pixel| pixel.map(srgb_decode))
}

/// A copy of a linear image with sRGB-coded values.
pub fn encode_srgb(linear: &Image) -> Image {
    linear.map(|pixel| pixel.map(srgb_encode))
}

/// The display-referred form of a linear image: scaled by 2^`exposure`, clamped to `[0, 1]` and coded
/// as sRGB; NaN becomes 0.
pub fn to_display(linear: &Image, exposure: f32) -> Image {
    let scale = exposure.exp2();
    linear.map(|pixel| pixel.map(|value| srgb_encode(clamp_unit(value * scale))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn srgb_round_trips_and_meets_the_standard() {
        for i in 0..=1000 {
            let linear = i as f32 / 1000.0;
            assert_abs_diff_eq!(srgb_decode(srgb_encode(linear)), linear, epsilon = 1e-6);
        }
        assert_abs_diff_eq!(srgb_encode(0.5), 0.735_357, epsilon = 1e-5);
        assert_abs_diff_eq!(srgb_decode(0.5), 0.214_041, epsilon = 1e-5);
        assert_eq!(srgb_encode(0.0), 0.0);
        assert_abs_diff_eq!(srgb_encode(1.0), 1.0, epsilon = 1e-6);
    }

    #[test]
    fn display_form_is_exposed_clamped_and_never_nan() {
        let mut image = Image::new(1, 1);
        image.pixels[0] = [0.25, f32::NAN, f32::INFINITY];
        let shown = to_display(&image, 1.0).pixels[0];
        assert_abs_diff_eq!(shown[0], srgb_encode(0.5), epsilon = 1e-6);
        assert_eq!(shown[1], 0.0);
        assert_abs_diff_eq!(shown[2], 1.0, epsilon = 1e-6);
    }
}
