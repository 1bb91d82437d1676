//! Product sampling without ratio and filter: the unbiased estimator beneath `product-ratio`.
//!
//! Shadow rays are chosen as there: systematically along the map's lights in proportion to their
//! unshadowed contribution, then a texel of the light by its luminance. Each is weighed by scattering
//! and radiance in its own direction over the density of that direction. A light counts wherever a
//! part of it may be above the surface.

use serde::Deserialize;

use super::EnvironmentSampler;
use super::product_ratio::ProductRatio;
use crate::entry::{About, Bias, Parameter, ParameterError};
use crate::environment::SamplerEntry;

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "product-ratio-unbiased",
        module: include_str!("product_ratio_unbiased.rs"),
        aliases: &["product"],
        summary: "lights sampled by their contribution at each point, without bias",
        source: "own method",
        bias: Bias::Unbiased,
        version: 1,
        failures: &[
            "noise at few samples",
            "mirror reflections of smooth coatings are left out, as by all light sets",
        ],
        parameters: &[Parameter {
            key: "lights",
            default: "512",
            unit: "",
            meaning: "J: lights of the map",
        }],
    },
    build: |table| {
        let Parameters { lights } = crate::entry::parameters(table)?;
        if !(1..=1 << 16).contains(&lights) {
            return Err(ParameterError {
                key: Some("lights".into()),
                message: "lights: expected 1 to 65536".into(),
            });
        }
        Ok(EnvironmentSampler::Product(ProductRatio {
            lights,
            unbiased: true,
            ..ProductRatio::default()
        }))
    },
};

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Parameters {
    lights: usize,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { lights: 512 }
    }
}
