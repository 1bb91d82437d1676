//! `[[path]]`.

use glam::DVec3;

use super::Loader;
use super::keys::Keys;
use super::view::{fov_axes, look_at};
use crate::scene::path::{CameraPath, KeyedPath, Pace, PathKey, PathSource};
use crate::scene::{FovAxis, SceneError, View};

/// What the keys of a path share, and what a key leaves to the one before.
struct Shared {
    size: Option<[usize; 2]>,
    fov_axis: Option<FovAxis>,
    fov_deg: Option<f64>,
}

impl Loader {
    pub(super) fn camera_path(&mut self, keys: &mut Keys) -> Result<(), SceneError> {
        let number = self.scene.paths.len() + 1;
        let name = keys.string("name")?;
        let name = name.map_or(format!("path{number}"), str::to_owned);
        keys.what = format!("path `{name}`");
        if self.scene.paths.iter().any(|path| path.name == name) {
            return Err(keys.error(format!("there are two paths called `{name}`")));
        }
        let pace = keys.word(
            "speed",
            &[("keyed", Pace::Keyed), ("constant", Pace::Constant)],
        )?;
        let eye_distance_m = keys.positive("eye_distance_m")?;
        let mut shared = Shared {
            size: keys.image_size("size")?,
            fov_axis: match keys.get("fov_axis") {
                Some(_) => Some(keys.word("fov_axis", &fov_axes())?),
                None => None,
            },
            fov_deg: keys.field_of_view("fov_deg")?,
        };
        let mut tables = keys.tables("keys")?;
        let frames = tables
            .iter_mut()
            .enumerate()
            .map(|(i, table)| {
                table.what = format!("key {i} of path `{name}`");
                self.path_key(table, &mut shared)
            })
            .collect::<Result<Vec<PathKey>, _>>()?;
        keys.finish()?;
        let path = KeyedPath::new(frames, pace).map_err(|(i, message)| {
            let at = tables.get(i).unwrap_or(keys);
            at.error(format!("{}: {message}", at.what))
        })?;
        self.scene.paths.push(CameraPath {
            name,
            eye_distance_m,
            source: PathSource::Keys(path),
        });
        Ok(())
    }

    fn path_key(&self, keys: &Keys, shared: &mut Shared) -> Result<PathKey, SceneError> {
        let time_s = keys.required("time", keys.number("time")?)?;
        let fov_deg = keys.field_of_view("fov_deg")?;
        let mut view = match keys.string("view")? {
            Some(name) => self.seen_from(keys, name)?,
            None => from_points(keys, fov_deg, shared)?,
        };
        keys.finish()?;
        let axis = *shared.fov_axis.get_or_insert(view.fov_axis);
        match fov_deg {
            Some(degrees) => view.fov_deg = degrees,
            None if axis != view.fov_axis => {
                let message = "its view has a field of view along another side of the film than the \
                               path: give `fov_deg`";
                return Err(keys.error(format!("{}: {message}", keys.what)));
            }
            None => {}
        }
        view.fov_axis = axis;
        shared.fov_deg = Some(view.fov_deg);
        let [width, height] = *shared.size.get_or_insert([view.width, view.height]);
        (view.width, view.height) = (width, height);
        Ok(PathKey { time_s, view })
    }

    /// A view of the scene, moved along its own right, up and forward, or turned to a target.
    fn seen_from(&self, keys: &Keys, name: &str) -> Result<View, SceneError> {
        let views = &self.scene.views;
        let Some(view) = views.iter().find(|view| view.name == name) else {
            let known: Vec<&str> = views.iter().map(|view| view.name.as_str()).collect();
            return Err(keys.unknown("view", name, &known));
        };
        let mut view = view.clone();
        if let Some([right, up, forward]) = keys.numbers::<3>("move")? {
            view.origin += view.right * right + view.up * up + view.forward * forward;
        }
        if let Some(target) = keys.vector("target")? {
            let mirrored = view.forward.cross(view.up).dot(view.right) < 0.0;
            let points = [view.origin, target, view.up];
            let turned = look_at(keys, name, points, view.fov_deg)?;
            view.right = if mirrored {
                -turned.right
            } else {
                turned.right
            };
            (view.up, view.forward) = (turned.up, turned.forward);
        }
        Ok(view)
    }
}

fn from_points(keys: &Keys, fov_deg: Option<f64>, shared: &Shared) -> Result<View, SceneError> {
    let origin = keys.required("origin", keys.vector("origin")?)?;
    let target = keys.required("target", keys.vector("target")?)?;
    let up = keys.vector("up")?.unwrap_or(DVec3::Y);
    let fov_deg = keys.required("fov_deg", fov_deg.or(shared.fov_deg))?;
    let mut view = look_at(keys, "", [origin, target, up], fov_deg)?;
    view.fov_axis = shared.fov_axis.unwrap_or(FovAxis::X);
    Ok(view)
}

#[cfg(test)]
mod tests;
