//! Shading points, nearest-record search and interpolation weights, shared by cached techniques.

mod points;
mod search;

pub use points::{NO_POINT, ShadingPoints};
pub use search::{DistanceMetric, Neighbour, RecordSearch, SearchRule};
