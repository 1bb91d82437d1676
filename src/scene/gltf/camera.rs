//! Cameras, and a view for files without one.

use ::gltf::json::camera::{Camera, Perspective};
use glam::DVec3;

use super::Importer;
use super::document::named;
use super::node::Placed;
use crate::scene::{Clip, FovAxis, SceneError, View};

/// Rows of a view, and columns of one whose aspect ratio is not given.
const HEIGHT: usize = 720;
const WIDTH: usize = 1280;

/// Vertical field of view of the view that stands in for a camera, degrees.
const STAND_IN_FOV_DEG: f64 = 40.0;

/// From where it looks, seen from the middle of the scene.
const STAND_IN_SIDE: DVec3 = DVec3::new(0.6, 0.45, 1.0);

impl Importer<'_> {
    /// Adds the camera of a node: it looks along the node's −z, +y is up.
    pub(super) fn camera(&mut self, index: usize, placed: &Placed) -> Result<(), SceneError> {
        let Some(camera) = self.file.root().cameras.get(index) else {
            return Err(self.file.error(format!("camera {index}"), "is not there"));
        };
        let place = named("camera", index, camera.name.as_deref());
        let Some(perspective) = &camera.perspective else {
            self.note(format!("{place} is orthographic and left out"));
            return Ok(());
        };
        let fail = |message: &str| self.file.error(&place, message);
        let fov_deg = f64::from(perspective.yfov).to_degrees();
        if !(fov_deg > 0.0 && fov_deg < 180.0) {
            return Err(fail("its yfov must be between 0 and π"));
        }
        let [width, height] =
            size(perspective).ok_or_else(|| fail("its aspectRatio must be above 0"))?;
        let axis = |column: usize| placed.to_world.col(column).truncate();
        let forward = (-axis(2)).normalize_or_zero();
        // Without skew and scale, and with the handedness of the node.
        let up = axis(1).reject_from_normalized(forward).normalize_or_zero();
        let right = axis(0)
            .reject_from_normalized(forward)
            .reject_from_normalized(up);
        let right = right.normalize_or_zero();
        if [forward, up, right].contains(&DVec3::ZERO) {
            return Err(fail("a node above it is singular"));
        }
        let name = self.camera_name(camera, index, placed.node);
        let index = self.scene.views.len();
        self.carried(placed).views.push(index);
        self.scene.clips.push(Clip {
            view: index,
            near: f64::from(perspective.znear),
            far: perspective.zfar.map_or(f64::INFINITY, f64::from),
        });
        self.scene.views.push(View {
            name,
            origin: axis(3),
            right,
            up,
            forward,
            fov_deg,
            fov_axis: FovAxis::Y,
            shift: [0.0; 2],
            width,
            height,
        });
        Ok(())
    }

    /// The name of the camera or else of its node; a second one of the same name gets its node's index.
    fn camera_name(&self, camera: &Camera, index: usize, node: usize) -> String {
        let of_node = self.file.root().nodes[node].name.as_deref();
        let named = [camera.name.as_deref(), of_node]
            .into_iter()
            .flatten()
            .find(|n| !n.is_empty());
        let name = named.map_or(format!("camera{index}"), str::to_owned);
        match self.scene.views.iter().any(|view| view.name == name) {
            true => format!("{name} {node}"),
            false => name,
        }
    }

    /// A view from outside that sees everything, for a file without a camera.
    pub(super) fn stand_in_view(&mut self, low: DVec3, high: DVec3) {
        self.note(
            "the file has no perspective camera: view `main` sees the whole scene from outside",
        );
        let centre = (low + high) * 0.5;
        let radius = (0.5 * (high - low).length()).max(f64::MIN_POSITIVE);
        let distance = 1.05 * radius / (0.5 * STAND_IN_FOV_DEG).to_radians().sin();
        let origin = centre + STAND_IN_SIDE.normalize() * distance;
        let points = [origin, centre, DVec3::Y];
        let mut view = View::look_at("main", points, STAND_IN_FOV_DEG, [WIDTH, HEIGHT]);
        view.fov_axis = FovAxis::Y;
        self.scene.views.push(view);
    }
}

/// Columns and rows of an aspect ratio: the shorter side has [`HEIGHT`] pixels.
fn size(perspective: &Perspective) -> Option<[usize; 2]> {
    let Some(aspect) = perspective.aspect_ratio else {
        return Some([WIDTH, HEIGHT]);
    };
    let longer = |ratio: f32| (HEIGHT as f32 * ratio).round().clamp(1.0, 65536.0) as usize;
    match aspect {
        _ if !(aspect > 0.0 && aspect.is_finite()) => None,
        _ if aspect >= 1.0 => Some([longer(aspect), HEIGHT]),
        _ => Some([HEIGHT, longer(1.0 / aspect)]),
    }
}
