//! Product sampling without ratio and filter: the unbiased estimator beneath `product-ratio`.
//!
//! Shadow rays are chosen as there: systematically along the map's lights in proportion to their
//! unshadowed contribution, then a texel of the light by its luminance. Each is weighed by scattering
//! and radiance in its own direction over the density of that direction. A light counts wherever a
//! part of it may be above the surface.

use super::EnvironmentSampler;
use super::product_ratio::ProductRatio;
use crate::entry::{About, Bias, parameters};
use crate::environment::SamplerEntry;

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "product-ratio-unbiased",
        module: crate::entry::head_comment!("product_ratio_unbiased.rs"),
        aliases: &["product"],
        summary: "lights sampled by their contribution at each point, without bias",
        source: "own method",
        bias: Bias::Unbiased,
        version: 2,
        failures: &[
            "noise at few samples",
            "mirror reflections of smooth coatings are left out, as by all light sets",
        ],
        parameters: Parameters::PARAMETERS,
    },
    build: |table| {
        let Parameters { lights } = Parameters::read(table)?;
        Ok(EnvironmentSampler::Product {
            parameters: ProductRatio {
                lights,
                ..ProductRatio::default()
            },
            unbiased: true,
        })
    },
};

parameters! {
    struct Parameters {
        /// J: lights of the map.
        lights: usize = 512, Within(1.0, 65536.0);
    }
}
