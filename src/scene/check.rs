//! What `scene check` tells about a scene.

use glam::DVec3;

use super::path::CameraPath;
use super::{
    BuildReport, FovAxis, LightDescription, LightKind, Needs, Scene, SceneDescription, SceneError,
    View,
};

/// A summary of a scene, loaded once in full.
#[derive(Clone, Debug, serde::Serialize)]
pub struct SceneCheck {
    pub name: String,
    pub title: String,
    pub file: Option<String>,
    pub views: Vec<CheckedView>,
    pub paths: Vec<CheckedPath>,
    /// How many motions there are.
    pub motions: usize,
    pub shapes: usize,
    pub emitting_shapes: usize,
    pub materials: usize,
    pub textures: usize,
    /// Lights without extent, one a line.
    pub lights: Vec<String>,
    pub has_environment: bool,
    /// Scene units.
    pub diagonal: f32,
    pub ao_distance: f32,
    pub metres_per_unit: f64,
    /// Whether the unit is a guess; a note says which.
    pub unit_is_assumed: bool,
    pub max_depth: u32,
    pub report: BuildReport,
}

/// A view, in the coordinates of the scene's file.
#[derive(Clone, Debug, serde::Serialize)]
pub struct CheckedView {
    pub name: String,
    pub origin: DVec3,
    pub forward: DVec3,
    pub up: DVec3,
    pub fov_deg: f64,
    pub fov_axis: FovAxis,
    /// Pixels.
    pub width: usize,
    pub height: usize,
}

/// A camera path.
#[derive(Clone, Debug, serde::Serialize)]
pub struct CheckedPath {
    pub name: String,
    /// First and last time.
    pub span_s: [f64; 2],
    /// 2 for a stereo pair.
    pub viewers: usize,
    /// Where it begins and ends.
    pub start: CheckedView,
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
    Ok(SceneCheck {
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
