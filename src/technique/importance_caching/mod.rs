//! Importance caching (Georgiev et al. 2012; Wu & Shen, section 4.2).

mod distributions;
mod estimator;

pub use distributions::Distributions;
pub use estimator::{Choice, Heuristic, KINDS, Rule};
