//! `[[view]]`.

use glam::DVec3;

use super::Loader;
use super::keys::Keys;
use crate::scene::{FovAxis, SceneError, View};

/// Default size of images, pixels.
const SIZE: [usize; 2] = [1920, 1080];

impl Loader {
    pub(super) fn view(&self, keys: &mut Keys) -> Result<View, SceneError> {
        let default_name = match self.scene.views.len() {
            0 => "main".to_owned(),
            n => format!("view{}", n + 1),
        };
        let name = keys.string("name")?.map_or(default_name, str::to_owned);
        keys.what = format!("view `{name}`");
        let origin = keys.required("origin", keys.vector("origin")?)?;
        let target = keys.required("target", keys.vector("target")?)?;
        let up = keys.vector("up")?.unwrap_or(DVec3::Y);
        let fov_deg = keys.required("fov_deg", keys.field_of_view("fov_deg")?)?;
        let fov_axis = keys.word("fov_axis", &fov_axes())?;
        let [width, height] = keys.image_size("size")?.unwrap_or(SIZE);
        keys.finish()?;
        Ok(View {
            fov_axis,
            width,
            height,
            ..look_at(keys, &name, [origin, target, up], fov_deg)?
        })
    }
}

/// The sides that a field of view may span.
pub(super) fn fov_axes() -> [(&'static str, FovAxis); 5] {
    [
        ("x", FovAxis::X),
        ("y", FovAxis::Y),
        ("smaller", FovAxis::Smaller),
        ("larger", FovAxis::Larger),
        ("diagonal", FovAxis::Diagonal),
    ]
}

/// A named camera from origin, target and up, which must tell a direction and a horizon.
pub(super) fn look_at(
    keys: &Keys,
    name: &str,
    [origin, target, up]: [DVec3; 3],
    fov_deg: f64,
) -> Result<View, SceneError> {
    let sine = (target - origin).normalize_or_zero().cross(up).length();
    if sine < 1e-6 * up.length().max(1e-300) {
        let message = "`origin` and `target` coincide or `up` is parallel to the view";
        return Err(keys.error(format!("{}: {message}", keys.what)));
    }
    Ok(View::look_at(name, [origin, target, up], fov_deg, SIZE))
}

impl Keys<'_> {
    /// An angle above 0 and below 180.
    pub(super) fn field_of_view(&self, key: &'static str) -> Result<Option<f64>, SceneError> {
        match (self.positive(key)?, self.get(key)) {
            (Some(degrees), Some(value)) if degrees >= 180.0 => {
                Err(self.wrong(key, value, "an angle below 180"))
            }
            (degrees, _) => Ok(degrees),
        }
    }

    /// Width and height in pixels.
    pub(super) fn image_size(&self, key: &'static str) -> Result<Option<[usize; 2]>, SceneError> {
        let fits = |side: &f64| side.fract() == 0.0 && (1.0..=65536.0).contains(side);
        match (self.numbers::<2>(key)?, self.get(key)) {
            (Some(size), Some(value)) if !size.iter().all(fits) => {
                Err(self.wrong(key, value, "[width, height] in pixels"))
            }
            (size, _) => Ok(size.map(|size| size.map(|side| side as usize))),
        }
    }
}
