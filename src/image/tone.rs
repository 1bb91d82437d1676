//! Tone curves by name.

use super::luminance;
use std::fmt;
use std::str::FromStr;

/// A tone curve from linear radiance to linear display values (METHODS 9.4; Andersson et al. 2021).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ToneCurve {
    /// Narkowicz' fit of the ACES curve, with its pre-exposure cancelled.
    #[default]
    Aces,
    /// Hable's filmic curve.
    Hable,
    /// Reinhard's `x / (1 + Y(x))`, on luminance.
    Reinhard,
}

/// Beyond this every curve has reached its limit; keeps squares of huge values finite.
const LARGEST_INPUT: f32 = 1e15;

impl ToneCurve {
    /// All curves, the default first.
    pub const ALL: [Self; 3] = [Self::Aces, Self::Hable, Self::Reinhard];

    /// The coefficients `(k0 x² + k1 x + k2) / (k3 x² + k4 x + k5)`; Reinhard on a gray input.
    fn coefficients(self) -> [f32; 6] {
        match self {
            Self::Aces => [
                0.6 * 0.6 * 2.51,
                0.6 * 0.03,
                0.0,
                0.6 * 0.6 * 2.43,
                0.6 * 0.59,
                0.14,
            ],
            Self::Hable => [0.231_683, 0.013_791, 0.0, 0.18, 0.3, 0.018],
            Self::Reinhard => [0.0, 1.0, 0.0, 0.0, 1.0, 1.0],
        }
    }

    /// Maps a finite, non-negative linear colour; the result is not clamped and may exceed 1.
    pub fn apply(self, rgb: [f32; 3]) -> [f32; 3] {
        if self == Self::Reinhard {
            let rgb = rgb.map(|value| value.min(LARGEST_INPUT));
            let divisor = 1.0 + luminance(rgb);
            return rgb.map(|value| value / divisor);
        }
        let [k0, k1, k2, k3, k4, k5] = self.coefficients();
        rgb.map(|value| {
            let x = value.min(LARGEST_INPUT);
            (x * x * k0 + x * k1 + k2) / (x * x * k3 + x * k4 + k5)
        })
    }

    /// The gray input that the curve maps to `output`: the larger root.
    ///
    /// `output` must lie in (0, limit of the curve).
    pub fn inverse(self, output: f32) -> f32 {
        let [k0, k1, k2, k3, k4, k5] = self.coefficients();
        let (a, b, c) = (k0 - output * k3, k1 - output * k4, k2 - output * k5);
        if a == 0.0 {
            return -c / b;
        }
        let middle = -0.5 * (b / a);
        middle + (middle * middle - c / a).sqrt()
    }
}

impl fmt::Display for ToneCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Aces => "aces",
            Self::Hable => "hable",
            Self::Reinhard => "reinhard",
        })
    }
}

/// A name that is none of the tone curves.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown tone curve '{0}'; choose aces, hable or reinhard")]
pub struct UnknownToneCurve(pub String);

impl FromStr for ToneCurve {
    type Err = UnknownToneCurve;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|curve| curve.to_string() == name.to_ascii_lowercase())
            .ok_or_else(|| UnknownToneCurve(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn white_points_are_those_of_the_paper() {
        let expected = [2.11887, 3.12775, 5.66667];
        for (curve, x_max) in ToneCurve::ALL.into_iter().zip(expected) {
            assert_abs_diff_eq!(curve.inverse(0.85), x_max, epsilon = 1e-4);
            let shown = curve.apply([x_max; 3]);
            assert_abs_diff_eq!(shown[1], 0.85, epsilon = 1e-5);
        }
    }

    #[test]
    fn curves_rise_from_zero_and_stay_finite() {
        for curve in ToneCurve::ALL {
            assert_eq!(curve.apply([0.0; 3]), [0.0; 3]);
            let mut last = 0.0;
            for exponent in -30..=38 {
                let y = curve.apply([10.0_f32.powi(exponent); 3])[0];
                // Rounding may move the plateau by a few units in the last place.
                assert!(
                    y.is_finite() && y >= last * (1.0 - 4.0 * f32::EPSILON),
                    "{curve} at 1e{exponent}: {y}"
                );
                last = y;
            }
        }
    }

    #[test]
    fn names_round_trip() {
        for curve in ToneCurve::ALL {
            assert_eq!(curve.to_string().parse(), Ok(curve));
        }
        assert!("gamma".parse::<ToneCurve>().is_err());
    }
}
