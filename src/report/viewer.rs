//! The images that the HTML report flips between: reference, methods, and their error maps.

use std::io;

use serde::Serialize;

use super::canvas::painted;
use super::data::{Data, SceneOf};
use super::escape;
use super::figure::moment_of;
use super::number::{self, Style};
use super::pictures::Pictures;
use super::shots::{Frames, Previews, Shots};
use super::side_by_side::bright_end;
use crate::experiment::Unit;
use crate::image::{Image, Plane, to_display, write_png_coded};

/// One scene's images, all of one size.
#[derive(Clone, Debug, Serialize)]
pub struct Viewer {
    pub scene: String,
    pub width: usize,
    pub height: usize,
    /// Which picture of a sequence is shown, after a comma.
    pub moment: String,
    pub frames: Vec<Frame>,
    /// Kept frames of a sequence.
    pub shots: Option<Shots>,
    pub previews: Vec<Previews>,
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
    (scene, pictures): (&SceneOf, &[Option<Pictures>]),
    notes: &mut Vec<String>,
) -> io::Result<Option<Viewer>> {
    let there: Vec<&Pictures> = pictures.iter().flatten().collect();
    let Some(first) = there.first() else {
        return Ok(None);
    };
    let errors: Vec<Option<Plane>> = there.iter().map(|p| p.error()).collect();
    let end = bright_end(&errors.iter().flatten().collect::<Vec<_>>());
    let frames = stills(data, (scene, &there), (&errors, end))?;
    let mut viewer = Viewer {
        scene: scene.title(),
        width: first.beauty.width,
        height: first.beauty.height,
        moment: moment_of(data, scene),
        shots: None,
        previews: Vec::new(),
        error_end: number::lone(f64::from(end)),
        frames,
    };
    let sequence = data.sequence(scene, &data.points()[0]);
    if let Some(sequence) = sequence.filter(|sequence| sequence.images() > 1) {
        let shots = Frames {
            data,
            scene,
            sequence,
            pictures: &there,
            with_reference: viewer.frames.len() > there.len(),
            error_end: end,
        };
        viewer.previews = shots.previews();
        viewer.shots = shots.write(notes)?;
    }
    Ok(Some(viewer))
}

/// The pictures that jobs leave in any case: of the reference, if it is there, and of each method.
fn stills(
    data: &Data,
    (scene, there): (&SceneOf, &[&Pictures]),
    (errors, end): (&[Option<Plane>], f32),
) -> io::Result<Vec<Frame>> {
    let (size, exposure) = there.first().map_or(((0, 0), 0.0), |first| {
        ((first.beauty.width, first.beauty.height), first.exposure)
    });
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
            image: put("_reference".into(), &to_display(reference, exposure))?,
            flip: None,
            error: None,
            values: String::new(),
        });
    }
    for (pictures, error) in there.iter().zip(errors) {
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
    Ok(frames)
}
