//! Shading points, nearest-record search and interpolation weights, shared by cached techniques.

mod metric;
mod points;
mod search;
mod tile;
mod tree;

pub use metric::{DistanceMetric, inverse_distance_weights};
pub use points::{NO_POINT, ShadingPoints};
pub use search::{Neighbour, RecordSearch, SearchRule};
