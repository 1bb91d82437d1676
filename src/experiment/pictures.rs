//! What jobs leave to look at.

use std::io;
use std::path::Path;

use super::Job;
use super::light_files::write_lights;
use crate::image::{Attributes, Image, Layer, Plane, write_exr, write_png};
use crate::metric::Comparison;
use crate::technique::{Rendered, Shot};

/// An image of a contender, and what it was measured against.
pub(super) struct Shown<'a> {
    pub shot: &'a Shot<'a>,
    pub rendered: &'a Rendered,
    /// The reference and how far from it the image is; `None` for frames that are not measured.
    pub measured: Option<(&'a Image, &'a Comparison)>,
    /// Key of the reference in its store.
    pub key: &'a str,
    /// Stops.
    pub exposure: f32,
}

impl Shown<'_> {
    /// Writes `<exr>.exr`, whose layers are the image, its error, its records, FLIP, what guided the refinement and the
    /// cells that it shows, and `<png>.png`. The reference lies in its store, by the key among the attributes.
    pub fn write(&self, folder: &Path, job: &Job, exr: &str, png: &str) -> io::Result<()> {
        let image = &self.rendered.image;
        let plane = |values: Vec<f32>| Plane {
            width: image.width,
            height: image.height,
            values,
        };
        let mut layers = vec![Layer::color("beauty", image.clone())];
        if let Some((reference, _)) = self.measured {
            layers.push(Layer::color("error", difference(image, reference)));
        }
        layers.push(Layer::gray("records", plane(self.record_map())));
        if let Some(maps) = self.measured.and_then(|(_, c)| c.maps.as_ref()) {
            layers.push(Layer::gray("flip", maps.flip_ldr.clone()));
        }
        if let Some(map) = &self.rendered.discontinuity {
            layers.push(Layer::gray("discontinuity", plane(map.clone())));
        }
        if let Some(map) = &self.rendered.cells {
            layers.push(Layer::gray("cells", plane(map.clone())));
        }
        let mut attributes = Attributes::new();
        let told = [
            ("job", job.id.clone()),
            ("scene", job.scene.clone()),
            ("view", self.shot.view.name.clone()),
            ("method", job.method.clone()),
            ("label", job.label.clone()),
            ("budget", job.budget.to_string()),
            ("reference", self.key.to_owned()),
        ];
        for (key, value) in told {
            attributes.insert(key.into(), value.into());
        }
        attributes.insert("frame".into(), self.shot.frame.into());
        attributes.insert("viewer".into(), self.shot.viewer.into());
        attributes.insert("exposure".into(), f64::from(self.exposure).into());
        let path = |name: &str, extension: &str| folder.join(format!("{name}.{extension}"));
        write_exr(&path(exr, "exr"), &layers, &attributes).map_err(io::Error::other)?;
        write_png(&path(png, "png"), image, self.exposure).map_err(io::Error::other)
    }

    /// Writes the lights of the image and the map they are of, if it has both.
    pub fn write_lights(&self, folder: &Path) -> io::Result<()> {
        match (&self.rendered.lights, &self.shot.scene.environment) {
            (Some(set), Some(map)) => write_lights(folder, set, map),
            _ => Ok(()),
        }
    }

    /// 1 where the first stage put a record, 2 where the refinement did.
    fn record_map(&self) -> Vec<f32> {
        let mut map = vec![0.0; self.rendered.image.pixels.len()];
        for record in &self.rendered.records {
            map[record.pixel as usize] = f32::from(record.stage) + 1.0;
        }
        map
    }
}

/// An image less its reference.
pub(super) fn difference(image: &Image, reference: &Image) -> Image {
    let mut error = image.clone();
    for (e, r) in error.pixels.iter_mut().zip(&reference.pixels) {
        (0..3).for_each(|c| e[c] -= r[c]);
    }
    error
}
