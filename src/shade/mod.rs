//! Scattering, direct light and path tracing: the truths.

pub mod bsdf;
