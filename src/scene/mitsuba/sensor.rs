//! Perspective sensors.

use glam::DVec3;

use super::Importer;
use super::element::Element;
use super::transform::transform;
use crate::scene::{Clip, FovAxis, SceneError, View};

/// Mitsuba's film size where none is given.
const DEFAULT_SIZE: [usize; 2] = [768, 576];

/// Depths between which Mitsuba's cameras see where nothing else is said.
const NEAR: f64 = 0.01;
const FAR: f64 = 10_000.0;

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
            Some(t) => transform(t)?,
            None => glam::DMat4::IDENTITY,
        };
        let [width, height] = self.film(element)?;
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
        self.scene.views.push(View {
            name,
            origin: axis(3),
            right,
            up,
            forward,
            fov_deg,
            fov_axis,
            width,
            height,
        });
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

    fn film(&mut self, element: &'a Element) -> Result<[usize; 2], SceneError> {
        let Some(film) = self.nested(element, "film")?.first().copied() else {
            return Ok(DEFAULT_SIZE);
        };
        let mut size = DEFAULT_SIZE;
        for (value, name) in size.iter_mut().zip(["width", "height"]) {
            if let Some(pixels) = film.float(name)? {
                if !(1.0..=65536.0).contains(&pixels) {
                    return Err(film.error(format!("a film {name} of {pixels} pixels cannot be")));
                }
                *value = pixels as usize;
            }
        }
        if film.children.iter().any(|c| c.name().starts_with("crop_")) {
            self.note("the crop window of the film is ignored");
        }
        let filter = film.tagged("rfilter").next().map(Element::kind);
        match filter {
            Some("box") => {}
            Some(kind) => self.note(format!("reconstruction filter `{kind}` becomes a box")),
            None => self.note("the default reconstruction filter `gaussian` becomes a box"),
        }
        film.mark_all();
        Ok(size)
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
