//! The charts of a scene. They are found once for each geometry: a job takes those of the job before where they fit, and is
//! charged with what finding them took all the same, so that its cost does not depend on what ran before it.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use crate::cache::surface::Charts;
use crate::scene::Scene;
use crate::technique::{Clock, Seconds};

/// Charts, and what finding them took.
#[derive(Clone)]
pub(super) struct Found {
    pub charts: Arc<Charts>,
    pub seconds: Seconds,
    geometry: blake3::Hash,
}

/// Those that were found last.
static LAST: Mutex<Option<Found>> = Mutex::new(None);

impl Found {
    /// The charts of a scene as it lies now.
    pub fn of(scene: &Scene) -> Self {
        let meshes: Vec<_> = scene.shapes.iter().map(|shape| shape.triangles()).collect();
        let geometry = hash_of(scene, &meshes);
        let last = || LAST.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = last().as_ref().filter(|found| found.geometry == geometry) {
            return found.clone();
        }
        let clock = Clock::start();
        let charts = Charts::new(&scene.positions, &scene.triangles, &meshes);
        let found = Self {
            charts: Arc::new(charts),
            seconds: clock.seconds(),
            geometry,
        };
        *last() = Some(found.clone());
        found
    }
}

/// Of all that charts depend on.
fn hash_of(scene: &Scene, meshes: &[Range<usize>]) -> blake3::Hash {
    const TOGETHER: usize = 1024;
    let mut hasher = blake3::Hasher::new();
    let mut bytes = Vec::with_capacity(12 * TOGETHER);
    let mut add = |words: &mut dyn Iterator<Item = u32>| {
        bytes.clear();
        bytes.extend(words.flat_map(u32::to_le_bytes));
        hasher.update(&bytes);
    };
    for positions in scene.positions.chunks(TOGETHER) {
        add(&mut positions
            .iter()
            .flat_map(|p| p.to_array().map(f32::to_bits)));
    }
    for triangles in scene.triangles.chunks(TOGETHER) {
        add(&mut triangles.iter().flatten().copied());
    }
    // Lengths tell where one list ends and the next begins.
    let lengths = [scene.positions.len(), scene.triangles.len()];
    add(&mut lengths.map(|length| length as u32).into_iter());
    add(&mut meshes.iter().map(|mesh| mesh.end as u32));
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::scene::{Needs, SceneDescription, ShapeDescription, ShapeSource};

    fn scene(side: f64) -> Scene {
        let cube = ShapeDescription {
            to_world: glam::DMat4::from_scale(glam::DVec3::splat(side)),
            ..ShapeDescription::new("cube", ShapeSource::Cube)
        };
        let description = SceneDescription {
            shapes: vec![cube],
            ..SceneDescription::default()
        };
        Scene::build(&description, Needs::default()).expect("a cube")
    }

    #[test]
    fn the_same_geometry_has_the_same_charts_and_cost_and_another_has_others() {
        // Other tests find charts of their own meanwhile: those of this geometry are the same whoever made them.
        let [one, again, other] = [1.0, 1.0, 2.0].map(|side| Found::of(&scene(side)));
        assert_eq!(one.charts, again.charts);
        assert_eq!(one.geometry, again.geometry);
        assert_ne!(one.geometry, other.geometry);
        assert_ne!(one.charts.size(0), other.charts.size(0));
        let mut moved = scene(1.0);
        moved.positions[0] += Vec3::X;
        assert_ne!(Found::of(&moved).geometry, one.geometry);
    }

    #[test]
    fn where_one_mesh_ends_and_the_next_begins_counts() {
        let scene = scene(1.0);
        let count = scene.triangles.len();
        let one = hash_of(&scene, std::slice::from_ref(&(0..count)));
        let two = hash_of(&scene, &[0..2, 2..count]);
        assert_ne!(one, two);
        assert_eq!(one, hash_of(&scene, std::slice::from_ref(&(0..count))));
    }
}
