//! Counter-based random numbers, direction sets, warps and discrete distributions.

mod hemisphere;
mod rng;

pub use hemisphere::{Frame, equal_area_hemisphere, square_to_hemisphere};
pub use rng::{Rng, hash};
