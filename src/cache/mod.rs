//! Shading points, nearest-record search and interpolation weights, and cells in world space, shared by cached techniques.

pub mod hash;
pub mod interpolation;
mod metric;
mod points;
mod search;
mod tile;
mod tree;

pub use interpolation::{Extrapolation, Gradient, Interpolation};
pub use metric::{DistanceMetric, Ranking, TangentMetric, inverse_distance_weights};
pub use points::{NO_POINT, ShadingPoints, Sight};
pub use search::{Neighbour, RecordSearch, SearchRule, SearchSpace};
