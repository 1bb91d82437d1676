//! The images that the HTML report flips between: reference, methods, and their error maps.

use std::io;

use serde::Serialize;

use super::canvas::painted;
use super::data::{Data, SceneOf};
use super::escape;
use super::number::{self, Style};
use super::pictures::Pictures;
use super::side_by_side::bright_end;
use crate::experiment::Unit;
use crate::image::{Image, Plane, to_display, write_png_coded};

/// One scene's images, all of one size.
#[derive(Clone, Debug, Serialize)]
pub struct Viewer {
    pub scene: String,
    pub width: usize,
    pub height: usize,
    pub frames: Vec<Frame>,
    /// The error that the brightest colour of the error maps stands for.
    pub error_end: String,
}

/// The images of a method, or of the reference.
#[derive(Clone, Debug, Serialize)]
pub struct Frame {
    pub label: String,
    pub image: String,
    pub flip: Option<String>,
    pub error: Option<String>,
    /// `RMSE 0.0840 · FLIP 0.0245`, empty for the reference.
    pub values: String,
}

/// Writes the images of a scene's viewer; `None` when there are none.
pub fn write(
    data: &Data,
    scene: &SceneOf,
    pictures: &[Option<Pictures>],
) -> io::Result<Option<Viewer>> {
    let there: Vec<&Pictures> = pictures.iter().flatten().collect();
    let Some(first) = there.first() else {
        return Ok(None);
    };
    let size = (first.beauty.width, first.beauty.height);
    let errors: Vec<Option<Plane>> = there.iter().map(|p| p.error()).collect();
    let end = bright_end(&errors.iter().flatten().collect::<Vec<_>>());
    let put = |name: String, image: &Image| -> io::Result<String> {
        let file = format!(
            "figures/viewer/{}.png",
            escape::file_name(&format!("{}-{name}", scene.name))
        );
        write_png_coded(&data.store.folder.join(&file), image).map_err(io::Error::other)?;
        Ok(escape::link(&file))
    };
    let style = |column: &str| {
        let values: Vec<f64> = there.iter().filter_map(|p| p.row.number(column)).collect();
        Style::of(Unit::None, values.into_iter())
    };
    let styles = [style("rmse"), style("flip_ldr")];
    let mut frames = Vec::new();
    if let Some(reference) = there.iter().find_map(|p| p.reference.as_ref()) {
        frames.push(Frame {
            label: "reference".into(),
            image: put("_reference".into(), &to_display(reference, first.exposure))?,
            flip: None,
            error: None,
            values: String::new(),
        });
    }
    for (pictures, error) in there.iter().zip(&errors) {
        let label = &pictures.row.label;
        let map = |plane: &Plane, end: f32| painted(plane, end, size);
        let flip = pictures
            .flip
            .as_ref()
            .map(|f| put(format!("{label}_flip"), &map(f, 1.0)));
        let error = error
            .as_ref()
            .map(|e| put(format!("{label}_error"), &map(e, end)));
        let value = |column: &str, style: &Style| {
            pictures
                .row
                .number(column)
                .map_or_else(|| "—".to_owned(), |v| style.number(v))
        };
        frames.push(Frame {
            label: label.clone(),
            image: put(
                format!("{label}_image"),
                &to_display(&pictures.beauty, pictures.exposure),
            )?,
            flip: flip.transpose()?,
            error: error.transpose()?,
            values: format!(
                "RMSE {} · FLIP {}",
                value("rmse", &styles[0]),
                value("flip_ldr", &styles[1])
            ),
        });
    }
    Ok(Some(Viewer {
        scene: scene.title(),
        width: size.0,
        height: size.1,
        frames,
        error_end: number::lone(f64::from(end)),
    }))
}
