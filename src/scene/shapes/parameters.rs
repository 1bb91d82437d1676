//! What a scene file may set of a generator.

use std::collections::BTreeMap;

/// Checked parameters of a generator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Factor on the number of facets along a curve.
    pub detail: f64,
    /// Key of whatever is scattered at random.
    pub seed: u64,
}

impl Parameters {
    /// Reads `detail` and `seed`; anything else, or a value out of range, is an error.
    pub fn new(given: &BTreeMap<String, f64>) -> Result<Self, String> {
        let mut out = Self {
            detail: 1.0,
            seed: 1,
        };
        for (name, &value) in given {
            match name.as_str() {
                "detail" if (0.1..=4.0).contains(&value) => out.detail = value,
                "seed" if value >= 0.0 && value.fract() == 0.0 && value <= 2f64.powi(53) => {
                    out.seed = value as u64;
                }
                "detail" => return Err(format!("`detail` must be from 0.1 to 4, not {value}")),
                "seed" => {
                    return Err(format!("`seed` must be a whole number from 0, not {value}"));
                }
                _ => {
                    return Err(format!(
                        "generated shapes have no parameter `{name}`; known are `detail`, `seed`"
                    ));
                }
            }
        }
        Ok(out)
    }

    /// `n` facets scaled by the detail, at least 3.
    pub fn steps(&self, n: usize) -> usize {
        ((n as f64 * self.detail).round() as usize).max(3)
    }

    /// A lattice cell of `size` metres divided by the detail.
    pub fn cell(&self, size: f32) -> f32 {
        size / self.detail as f32
    }
}
