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

use super::EnvironmentSampler;
use crate::entry::{About, Bias, parameters};
use crate::environment::SamplerEntry;

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "product-ratio",
        module: crate::entry::head_comment!("product_ratio.rs"),
        aliases: &[],
        summary: "lights sampled by their contribution at each point, with a filtered visibility ratio",
        source: "own method; ratio estimator: Heitz, Hill & McGuire 2018; edges: Lee 1980",
        bias: Bias::Biased,
        version: 2,
        failures: &[
            "penumbrae narrower than the filter are somewhat soft at few rays",
            "highlights of very glossy surfaces are those of the lights' centres, widened by their spread",
            "a lattice pattern remains visible in penumbrae at few rays",
            "mirror reflections of smooth coatings are left out, as by all light sets",
        ],
        parameters: ProductRatio::PARAMETERS,
    },
    build: |table| {
        Ok(EnvironmentSampler::Product {
            parameters: ProductRatio::read(table)?,
            unbiased: false,
        })
    },
};

parameters! {
    /// Parameters of the estimator.
    #[derive(Clone, Copy, Debug)]
    pub struct ProductRatio {
        /// J: lights of the map.
        pub lights: usize = 2048, Within(1.0, 65536.0);
        /// Share of all light that neighbouring lights, as one, may take from a highlight by their spread before
        /// they are taken apart.
        pub detail: f32 = 3e-4, Within(0.0, 1.0);
        /// Random part of the number that chooses a pixel's lights; 0 is a lattice over the pixels.
        pub jitter: f32 = 0.0, Within(0.0, 1.0);
        /// Least shadow rays of a point that are cast together.
        pub bundle: usize = 24, AtLeast(0.0);
        /// Half the side of the filter's window for emissive texels.
        pub direct_reach: usize = 2, Within(0.0, 16.0), "px";
        /// Standard deviation of its Gaussian.
        pub direct_sigma: f32 = 1.5, Above(0.0), "px";
        /// Half the side of the filter's window for the other texels.
        pub indirect_reach: usize = 3, Within(0.0, 16.0), "px";
        /// Standard deviation of its Gaussian.
        pub indirect_sigma: f32 = 2.0, Above(0.0), "px";
        /// 1 − cosine of the normals at which a neighbour counts 1/e.
        pub normal_tolerance: f32 = 0.03, Above(0.0);
        /// Distance from the surface's plane, over the distance from the camera, at which a neighbour counts 1/e.
        pub plane_tolerance: f32 = 0.01, Above(0.0);
        /// Expected variance of E's own ratios, of that of independent samples; 0 keeps them whole.
        pub direct_noise: f32 = 0.5, AtLeast(0.0);
        /// The same for I.
        pub indirect_noise: f32 = 1.0, AtLeast(0.0);
    }
}
