//! Counter-based random numbers, direction sets, warps and discrete distributions.

mod additive;
mod edges;
mod hemisphere;
mod rng;

pub use additive::additive;
pub use edges::{HemisphereEdges, is_set};
pub use hemisphere::{Frame, equal_area_hemisphere, hemisphere_to_square, square_to_hemisphere};
pub use rng::{Rng, hash};
