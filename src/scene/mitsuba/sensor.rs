//! Perspective sensors.

use glam::DVec3;

use super::Importer;
use super::element::Element;
use crate::scene::{Clip, FovAxis, SceneError, View};

/// Mitsuba's film size where none is given.
const DEFAULT_SIZE: [usize; 2] = [768, 576];

/// Depths between which Mitsuba's cameras see where nothing else is said.
const NEAR: f64 = 0.01;
const FAR: f64 = 10_000.0;

/// The film of a sensor, pixels.
struct Film<'a> {
    element: Option<&'a Element>,
    size: [usize; 2],
    /// Offset and size of the part that is rendered.
    crop: [[usize; 2]; 2],
}

impl<'a> Importer<'a> {
    pub(super) fn sensor(&mut self, element: &'a Element) -> Result<(), SceneError> {
        element.used.set(true);
        match element.kind() {
            "perspective" => {}
            "thinlens" => self.note("a thin lens becomes a pinhole (everything is sharp)"),
            other => {
                element.mark_all();
                self.note(format!("sensor `{other}` is ignored"));
                return Ok(());
            }
        }
        for ignored in ["focus_distance", "shutter_open", "shutter_close"] {
            element.child(ignored);
        }
        element.tagged("sampler").for_each(Element::mark_all);
        let to_world = match element.child("to_world") {
            Some(t) => self.transform(t)?,
            None => glam::DMat4::IDENTITY,
        };
        let film = self.film(element)?;
        let [width, height] = film.size;
        let (fov_deg, fov_axis) = self.field_of_view(element)?;
        let axis = |column: usize| to_world.col(column).truncate();
        let forward = axis(2).normalize_or_zero();
        // Mitsuba's +x is image left; keep the given handedness and remove skew.
        let up = axis(1).reject_from_normalized(forward).normalize_or_zero();
        let sideways = -axis(0).reject_from_normalized(forward);
        let right = sideways.reject_from_normalized(up).normalize_or_zero();
        if [forward, up, right].contains(&DVec3::ZERO) {
            return Err(element.error("the camera transform is singular"));
        }
        let name = match self.scene.views.len() {
            0 => "main".to_owned(),
            n => element
                .id()
                .map_or_else(|| format!("view{}", n + 1), str::to_owned),
        };
        self.scene.clips.push(Clip {
            view: self.scene.views.len(),
            near: element.float("near_clip")?.unwrap_or(NEAR),
            far: element.float("far_clip")?.unwrap_or(FAR),
        });
        let mut view = View {
            name,
            origin: axis(3),
            right,
            up,
            forward,
            fov_deg,
            fov_axis,
            shift: [0.0; 2],
            width,
            height,
        };
        let [half_width, half_height] = view.half_tangents(width, height);
        let principal = |side: &str| {
            let offset = element.float(&format!("principal_point_offset_{side}"))?;
            Ok(offset.unwrap_or(0.0))
        };
        // Shares of the film, to the right and downwards.
        view.shift = [
            2.0 * half_width * principal("x")?,
            -2.0 * half_height * principal("y")?,
        ];
        let [offset, size] = film.crop;
        let view = view.cropped(offset, size).ok_or_else(|| {
            let place = film.element.unwrap_or(element);
            place.error(format!(
                "the crop window is not on the film of {width}x{height} pixels"
            ))
        })?;
        self.scene.views.push(view);
        Ok(())
    }

    fn field_of_view(&mut self, element: &Element) -> Result<(f64, FovAxis), SceneError> {
        let (fov_deg, given) = match element.float("fov")? {
            Some(fov) => (fov, true),
            None => (focal_fov_deg(element)?, false),
        };
        if !(fov_deg > 0.0 && fov_deg < 180.0) {
            let message = format!("a field of view of {fov_deg} degrees is not between 0 and 180");
            return Err(element.error(message));
        }
        let axis = match element.string("fov_axis")?.unwrap_or("x") {
            _ if !given => FovAxis::Diagonal,
            "x" => FovAxis::X,
            "y" => FovAxis::Y,
            "smaller" => FovAxis::Smaller,
            "larger" => FovAxis::Larger,
            "diagonal" => FovAxis::Diagonal,
            other => {
                let known = ["x", "y", "smaller", "larger", "diagonal"];
                return Err(Self::unknown_word(element, "fov axis", other, &known));
            }
        };
        Ok((fov_deg, axis))
    }

    fn film(&mut self, element: &'a Element) -> Result<Film<'a>, SceneError> {
        let Some(film) = self.nested(element, "film")?.first().copied() else {
            return Ok(Film {
                element: None,
                size: DEFAULT_SIZE,
                crop: [[0; 2], DEFAULT_SIZE],
            });
        };
        let pixels = |name: &str, least: usize, default: usize| match film.whole(name)? {
            None => Ok(default),
            Some(pixels) if (least..=65536).contains(&pixels) => Ok(pixels),
            Some(pixels) => Err(film.error(format!("a film {name} of {pixels} pixels cannot be"))),
        };
        let [width, height] = DEFAULT_SIZE;
        let size = [pixels("width", 1, width)?, pixels("height", 1, height)?];
        let crop = [
            [
                pixels("crop_offset_x", 0, 0)?,
                pixels("crop_offset_y", 0, 0)?,
            ],
            [
                pixels("crop_width", 1, size[0])?,
                pixels("crop_height", 1, size[1])?,
            ],
        ];
        let filter = film.tagged("rfilter").next().map(Element::kind);
        match filter {
            Some("box") => {}
            Some(kind) => self.note(format!("reconstruction filter `{kind}` becomes a box")),
            None => self.note("the default reconstruction filter `gaussian` becomes a box"),
        }
        film.mark_all();
        Ok(Film {
            element: Some(film),
            size,
            crop,
        })
    }
}

/// Diagonal field of view of a focal length like `50mm` (the default) on 36 × 24 mm film.
fn focal_fov_deg(element: &Element) -> Result<f64, SceneError> {
    let text = element.string("focal_length")?.unwrap_or("50mm");
    let millimetres: f64 = text
        .trim_end_matches("mm")
        .trim()
        .parse()
        .map_err(|_| element.error(format!("`{text}` is not a focal length like 50mm")))?;
    let diagonal = 36.0_f64.hypot(24.0);
    Ok(2.0 * (diagonal * 0.5 / millimetres).atan().to_degrees())
}
