//! How large a scene may be, and how far from its origin, for single precision to hold it.
//!
//! Normals and areas of triangles take the fourth power of their edges, the distance of a hit the third, of numbers
//! that single precision holds from 10⁻³⁸ to 3·10³⁸: renderings of one scene at many scales agree from a diagonal of
//! about 10⁻⁸ units to one of 10⁹; beyond that, first of those with caches, they drift, and end wrong or black.

use super::{Scene, SceneError};

/// Least diagonal of a scene, its own units.
const LEAST_DIAGONAL: f32 = 1e-8;
/// Largest diagonal of a scene, its own units.
const LARGEST_DIAGONAL: f32 = 1e9;
/// How many diagonals the centre may be away from the origin: double precision then still moves no corner by more than
/// 10⁻⁸ of the diagonal.
const FARTHEST_CENTRE: f64 = 1e8;

impl Scene {
    /// Refuses a scene that single precision cannot hold.
    ///
    /// # Errors
    /// What is too small, large or far, and what to do.
    pub(crate) fn check_extent(&self) -> Result<(), SceneError> {
        check(self.diagonal, self.origin.length()).map_err(|message| SceneError::Scene {
            scene: self.name.clone(),
            message,
        })
    }
}

/// Checks the diagonal of a scene, and how far its centre is from the origin.
fn check(diagonal: f32, distance: f64) -> Result<(), String> {
    if !(LEAST_DIAGONAL..=LARGEST_DIAGONAL).contains(&diagonal) {
        return Err(format!(
            "the diagonal of the box around all triangles is {diagonal:e} units, and single precision holds scenes of \
             {LEAST_DIAGONAL:e} to {LARGEST_DIAGONAL:e} units: give the scene another unit, for example by \
             transform = {{ scale = … }} of the config's [[scene]]"
        ));
    }
    if distance > FARTHEST_CENTRE * f64::from(diagonal) {
        return Err(format!(
            "the centre of the scene is {distance:e} units from the origin, more than {FARTHEST_CENTRE:e} times its \
             diagonal of {diagonal:e} units, so that its corners are rounded: move it nearer, or make it larger"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_that_single_precision_cannot_hold_are_refused() {
        for (diagonal, distance) in [(1e-8, 0.0), (3.0, 1e6), (1e9, 1e16)] {
            check(diagonal, distance).expect("held");
        }
        for (diagonal, distance, told) in [
            (1e-9, 0.0, "is 1e-9 units"),
            (0.0, 0.0, "1e-8 to 1e9 units: give the scene another unit"),
            (2e9, 0.0, "is 2e9 units"),
            (f32::INFINITY, 0.0, "is inf units"),
            (3.0, 1e30, "is 1e30 units from the origin"),
        ] {
            let error = check(diagonal, distance).expect_err(told);
            assert!(error.contains(told), "{error}");
        }
    }
}
