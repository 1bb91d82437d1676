//! Light from infinity: maps, skies and (later) their samplers.

/// A latitude–longitude radiance map with its orientation and sampling tables.
#[derive(Clone, Debug, Default)]
pub struct Environment {}
