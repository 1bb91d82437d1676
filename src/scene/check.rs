//! What `scene check` tells about a scene.

use std::collections::HashSet;

use glam::DVec3;

use super::path::CameraPath;
use super::{
    BuildReport, FovAxis, LightDescription, LightKind, Needs, Scene, SceneDescription, SceneError,
    View,
};

/// A summary of a scene, loaded once in full.
#[derive(Clone, Debug, serde::Serialize)]
pub struct SceneCheck {
    /// What rows and result folders call it.
    pub name: String,
    /// For people; empty where the file gives none.
    pub title: String,
    /// The scene file; `None` for scenes that no file holds.
    pub file: Option<String>,
    /// In the order of the file.
    pub views: Vec<CheckedView>,
    /// In the order of the file.
    pub paths: Vec<CheckedPath>,
    /// How many motions there are.
    pub motions: usize,
    /// What motions call shapes: each name once, in the order of the file, that of an object before its parts.
    pub movable_shapes: Vec<String>,
    /// What motions call lights without extent.
    pub movable_lights: Vec<String>,
    /// How many the file declares, those with absent meshes included.
    pub shapes: usize,
    /// Those that emit light.
    pub emitting_shapes: usize,
    /// How many the file declares, used or not.
    pub materials: usize,
    /// How many the file declares, used or not.
    pub textures: usize,
    /// Lights without extent, one a line.
    pub lights: Vec<String>,
    /// Whether light comes from infinity.
    pub has_environment: bool,
    /// Scene units.
    pub diagonal: f32,
    /// Maximum length of ambient-occlusion rays, scene units.
    pub ao_distance: f32,
    /// Length of a scene unit in metres.
    pub metres_per_unit: f64,
    /// Whether the unit is a guess; a note says which.
    pub unit_is_assumed: bool,
    /// Path edges after the camera.
    pub max_depth: u32,
    /// What loading found, repaired, dropped and cost.
    pub report: BuildReport,
}

/// A view, in the coordinates of the scene's file.
#[derive(Clone, Debug, serde::Serialize)]
pub struct CheckedView {
    /// What `--view` takes.
    pub name: String,
    /// Position of the eye, scene units.
    pub origin: DVec3,
    /// Unit vector into the middle of the image.
    pub forward: DVec3,
    /// Unit vector towards the top of the image.
    pub up: DVec3,
    /// Full angle of view along `fov_axis`.
    pub fov_deg: f64,
    /// Which side of the image the angle belongs to.
    pub fov_axis: FovAxis,
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
}

/// A camera path.
#[derive(Clone, Debug, serde::Serialize)]
pub struct CheckedPath {
    /// What configs call it.
    pub name: String,
    /// First and last time.
    pub span_s: [f64; 2],
    /// 2 for a stereo pair.
    pub viewers: usize,
    /// Where it begins and ends.
    pub start: CheckedView,
    /// The view at the last time.
    pub end: CheckedView,
}

impl CheckedView {
    fn of(view: &View) -> Self {
        Self {
            name: view.name.clone(),
            origin: view.origin,
            forward: view.forward,
            up: view.up,
            fov_deg: view.fov_deg,
            fov_axis: view.fov_axis,
            width: view.width,
            height: view.height,
        }
    }
}

impl CheckedPath {
    fn of(path: &CameraPath) -> Self {
        let span_s = path.span_s();
        let [start, end] = span_s.map(|time_s| CheckedView::of(&path.view(time_s)));
        Self {
            name: path.name.clone(),
            span_s,
            viewers: path.viewers(),
            start,
            end,
        }
    }
}

/// Loads everything once and reports it. `report.cost.of(needs)` gives the bytes for the needs of a
/// technique. Fails as [`Scene::build`] does.
pub fn check_scene(description: &SceneDescription) -> Result<SceneCheck, SceneError> {
    let scene = Scene::build(description, Needs::ALL)?;
    let shapes = description.shapes.iter();
    let lights = description.lights.iter();
    Ok(SceneCheck {
        movable_shapes: each_once(shapes.flat_map(|shape| [shape.object(), &shape.name])),
        movable_lights: each_once(lights.map(|light| light.name.as_str())),
        name: description.name.clone(),
        title: description.title.clone(),
        file: description.file.as_ref().map(|f| f.display().to_string()),
        views: description.views.iter().map(CheckedView::of).collect(),
        paths: description.paths.iter().map(CheckedPath::of).collect(),
        motions: description.motions.len(),
        shapes: description.shapes.len(),
        emitting_shapes: description
            .shapes
            .iter()
            .filter(|s| s.emission.is_some())
            .count(),
        materials: description.materials.len(),
        textures: description.textures.len(),
        lights: description.lights.iter().map(line).collect(),
        has_environment: description.environment.is_some(),
        diagonal: scene.diagonal,
        ao_distance: scene.ao_distance,
        metres_per_unit: scene.metres_per_unit,
        unit_is_assumed: scene.unit_is_assumed,
        max_depth: scene.max_depth,
        report: scene.report,
    })
}

/// Names that are not empty, each once.
fn each_once<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut seen = HashSet::from([""]);
    let names = names.filter(|name| seen.insert(*name));
    names.map(str::to_owned).collect()
}

fn line(light: &LightDescription) -> String {
    match &light.kind {
        LightKind::Directional {
            direction,
            irradiance,
        } => format!("directional along {direction:.4}, irradiance {irradiance:?} W/m²"),
        LightKind::Point {
            position,
            intensity,
        } => format!("point at {position:.4}, intensity {intensity:?} W/sr"),
        LightKind::Spot {
            position,
            direction,
            intensity,
            beam_width_deg,
            cutoff_deg,
        } => format!(
            "spot at {position:.4} along {direction:.4}, intensity {intensity:?} W/sr to {beam_width_deg}°, \
             none from {cutoff_deg}°"
        ),
    }
}
