//! Shading points, nearest-record search and interpolation weights, cells in world space, texels on surfaces and cones of light,
//! shared by cached techniques.

pub mod cones;
pub mod hash;
pub mod interpolation;
mod metric;
mod points;
mod search;
pub mod surface;
mod tile;
mod tree;

pub use interpolation::{Extrapolation, Gradient, Interpolation};
pub use metric::{DistanceMetric, Ranking, TangentMetric, Weighted, inverse_distance_weights};
pub use points::{NO_POINT, ShadingPoints, Sight};
pub use search::{Neighbour, RecordSearch, SearchRule, SearchSpace};
