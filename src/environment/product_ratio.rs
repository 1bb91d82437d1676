//! Product-ratio sampling, our own method: shadow rays by the product of light and scattering at
//! every shading point, and a filtered ratio of shadowed to unshadowed light.
//!
//! The map becomes two thousand lights, emissive ones (E) and others (I), each with 16 directions
//! drawn from its texels in advance. At a point every light has an unshadowed contribution c_j; U_E and
//! U_I are their sums. K points of equal distance along the list of lights, weighted by c_j, choose lights
//! (one number a pixel, which differs much among neighbours); a shadow ray goes in one of each light's
//! directions. With a = Σc / (K c_j), shadowed (a · contribution · visibility) and unshadowed
//! (a · contribution) sums give a ratio r for E and for I, whose sums are filtered over pixels of the same
//! object, alike in normal and in the plane of their surface. The result is U_E r_E + U_I r_I: where
//! nothing blocks light it has no noise, and texture and highlights are never blurred.
//!
//! Where the pixels' own ratios in the filter's window vary more than samples of one ratio would, there
//! is a shadow edge, and a pixel keeps so much of its own ratio (as the filter of Lee 1980).
//!
//! What makes it fast: eight lights at a time in loops over arrays; 64 neighbouring lights looked at as one,
//! and taken apart, into eight and then into lights, only where a highlight is sharper than they are spread
//! (what a chosen light brings has its own cosine nevertheless);
//! the diffuse part of U from a table of the irradiance by normal; rays in the order of the list, cast
//! together when they are many.

use serde::{Deserialize, Serialize};

use super::EnvironmentSampler;
use crate::entry::{About, Bias, Parameter, ParameterError};
use crate::environment::SamplerEntry;

const fn parameter(
    [key, default]: [&'static str; 2],
    [unit, meaning]: [&'static str; 2],
) -> Parameter {
    Parameter {
        key,
        default,
        unit,
        meaning,
    }
}

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "product-ratio",
        module: include_str!("product_ratio.rs"),
        aliases: &[],
        summary: "lights sampled by their contribution at each point, with a filtered visibility ratio",
        source: "own method; ratio estimator: Heitz, Hill & McGuire 2018; edges: Lee 1980",
        bias: Bias::Biased,
        version: 1,
        failures: &[
            "penumbrae narrower than the filter are somewhat soft at few rays",
            "highlights of very glossy surfaces are those of the lights' centres, widened by their spread",
            "a lattice pattern remains visible in penumbrae at few rays",
            "mirror reflections of smooth coatings are left out, as by all light sets",
        ],
        parameters: &[
            parameter(["lights", "2048"], ["", "J: lights of the map"]),
            parameter(
                ["detail", "0.0003"],
                [
                    "",
                    "share of all light that neighbouring lights, as one, may take from a highlight by their spread before they are taken apart",
                ],
            ),
            parameter(
                ["jitter", "0"],
                [
                    "",
                    "random part of the number that chooses a pixel's lights; 0 is a lattice over the pixels",
                ],
            ),
            parameter(
                ["bundle", "24"],
                ["", "least shadow rays of a point that are cast together"],
            ),
            parameter(
                ["direct_reach", "2"],
                [
                    "px",
                    "half the side of the filter's window for emissive texels",
                ],
            ),
            parameter(
                ["direct_sigma", "1.5"],
                ["px", "standard deviation of its Gaussian"],
            ),
            parameter(
                ["indirect_reach", "3"],
                [
                    "px",
                    "half the side of the filter's window for the other texels",
                ],
            ),
            parameter(
                ["indirect_sigma", "2"],
                ["px", "standard deviation of its Gaussian"],
            ),
            parameter(
                ["normal_tolerance", "0.03"],
                [
                    "",
                    "1 − cosine of the normals at which a neighbour counts 1/e",
                ],
            ),
            parameter(
                ["plane_tolerance", "0.01"],
                [
                    "",
                    "distance from the surface's plane, over the distance from the camera, at which a neighbour counts 1/e",
                ],
            ),
            parameter(
                ["direct_noise", "0.5"],
                [
                    "",
                    "expected variance of E's own ratios, of that of independent samples; 0 keeps them whole",
                ],
            ),
            parameter(["indirect_noise", "1"], ["", "the same for I"]),
        ],
    },
    build: |table| {
        let parameters: ProductRatio = crate::entry::parameters(table)?;
        parameters.validate()?;
        Ok(EnvironmentSampler::Product(parameters))
    },
};

/// Parameters of the estimator.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ProductRatio {
    /// J.
    pub lights: usize,
    /// Share of all light that a highlight may lose to the spread of a chunk of lights before the chunk
    /// is taken apart.
    pub detail: f32,
    /// Random part of the numbers that choose lights, in [0, 1].
    pub jitter: f32,
    /// Least shadow rays of a point that are cast together.
    pub bundle: usize,
    /// Half the sides of the filter's windows, pixels.
    pub direct_reach: usize,
    pub indirect_reach: usize,
    /// Standard deviations of the filter's Gaussians, pixels.
    pub direct_sigma: f32,
    pub indirect_sigma: f32,
    /// Fall-off of the filter with 1 − n·n′.
    pub normal_tolerance: f32,
    /// Fall-off of the filter with the distance from the plane, over the distance from the camera.
    pub plane_tolerance: f32,
    /// Share of the variance of independent samples that the own ratios are expected to have.
    pub direct_noise: f32,
    pub indirect_noise: f32,
    /// Whether texels are lit as they are, without ratio and filter.
    #[serde(skip)]
    pub unbiased: bool,
}

impl Default for ProductRatio {
    fn default() -> Self {
        Self {
            lights: 2048,
            detail: 3e-4,
            jitter: 0.0,
            bundle: 24,
            direct_reach: 2,
            indirect_reach: 3,
            direct_sigma: 1.5,
            indirect_sigma: 2.0,
            normal_tolerance: 0.03,
            plane_tolerance: 0.01,
            direct_noise: 0.5,
            indirect_noise: 1.0,
            unbiased: false,
        }
    }
}

impl ProductRatio {
    fn validate(&self) -> Result<(), ParameterError> {
        let error = |key: &str, expected: &str| {
            Err(ParameterError {
                key: Some(key.into()),
                message: format!("{key}: expected {expected}"),
            })
        };
        if !(1..=1 << 16).contains(&self.lights) {
            return error("lights", "1 to 65536");
        }
        let reaches = [
            ("direct_reach", self.direct_reach),
            ("indirect_reach", self.indirect_reach),
        ];
        if let Some((key, _)) = reaches.iter().find(|(_, reach)| *reach > 16) {
            return error(key, "0 to 16 pixels");
        }
        let positive = [
            ("direct_sigma", self.direct_sigma),
            ("indirect_sigma", self.indirect_sigma),
            ("normal_tolerance", self.normal_tolerance),
            ("plane_tolerance", self.plane_tolerance),
        ];
        if let Some((key, _)) = positive.iter().find(|(_, v)| !v.is_finite() || *v <= 0.0) {
            return error(key, "a positive number");
        }
        let noise = [
            ("direct_noise", self.direct_noise),
            ("indirect_noise", self.indirect_noise),
        ];
        if !(0.0..=1.0).contains(&self.jitter) {
            return error("jitter", "a share from 0 to 1");
        }
        if !(0.0..=1.0).contains(&self.detail) {
            return error("detail", "a share from 0 to 1");
        }
        if let Some((key, _)) = noise.iter().find(|(_, v)| !v.is_finite() || *v < 0.0) {
            return error(key, "a number that is not negative");
        }
        Ok(())
    }
}
