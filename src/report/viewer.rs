//! The images that the page compares: of the reference and of each method, at each kept frame and for each viewer.

use std::io;

use serde::Serialize;

use super::data::{Data, SceneOf};
use super::figure::moment_of;
use super::light_map;
use super::number::Style;
use super::pictures::Pictures;
use super::pixels::{Shelf, link_of};
use super::shots::{Frames, Previews};
use super::side_by_side::bright_end;
use crate::experiment::Unit;
use crate::image::Plane;

/// One scene's images, all of one size.
#[derive(Clone, Debug, Serialize)]
pub struct Viewer {
    pub scene: String,
    /// Which picture of a sequence is shown, after a comma; empty where all kept frames are.
    pub moment: String,
    /// Whether there are several frames.
    pub many: bool,
    pub previews: Vec<Previews>,
    /// [`Album`] as JSON.
    pub album: String,
}

/// What the viewer's script gets. A still is a sequence of one frame and one viewer.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Album {
    pub width: usize,
    pub height: usize,
    /// Stops.
    pub exposure: f32,
    /// The error that the brightest colour stands for at first.
    pub error_end: f32,
    pub labels: Vec<String>,
    /// The job of each label, relative to the results folder; null for the reference.
    pub jobs: Vec<Option<String>>,
    /// What each kept frame is called; the only one of a still is not.
    pub frames: Vec<String>,
    pub viewers: Vec<String>,
    /// Position of the frame that is shown first.
    pub start: usize,
    /// How long a frame is shown while the viewer plays.
    pub delay_ms: u32,
    /// By viewer, frame and label.
    pub cells: Vec<Vec<Vec<Cell>>>,
}

/// An image and its maps, by their names on the shelf.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Cell {
    pub image: Option<String>,
    pub flip: Option<String>,
    pub records: Option<String>,
    pub discontinuity: Option<String>,
    pub cells: Option<String>,
    /// Link to the environment map with the lights of the job, where it kept them.
    pub lights: Option<String>,
    /// Link to a picture of eight bits, where there are no pixels.
    pub picture: Option<String>,
    /// `RMSE 0.0840 · FLIP 0.0245`, empty for the reference.
    pub values: String,
}

/// Keeps the images of a scene's viewer; `None` when there are none.
pub fn write(
    data: &Data,
    scene: &SceneOf,
    pictures: &[Option<Pictures>],
    shelf: &mut Shelf,
    notes: &mut Vec<String>,
) -> io::Result<Option<Viewer>> {
    let there: Vec<&Pictures> = pictures.iter().flatten().collect();
    let Some(first) = there.first() else {
        return Ok(None);
    };
    let errors: Vec<Plane> = there.iter().filter_map(|p| p.error()).collect();
    let with_reference = there.iter().any(|p| p.reference.is_some());
    let mut album = Album {
        width: first.beauty.width,
        height: first.beauty.height,
        exposure: first.exposure,
        error_end: bright_end(&errors.iter().collect::<Vec<_>>()),
        ..Album::default()
    };
    if with_reference {
        album.labels.push("reference".into());
        album.jobs.push(None);
    }
    for pictures in &there {
        album.labels.push(pictures.row.label.clone());
        album.jobs.push(Some(pictures.row.job.clone()));
    }
    let sequence = data.sequence(scene, &data.points()[0]);
    let sequence = sequence.filter(|sequence| sequence.images() > 1);
    let mut previews = Vec::new();
    let mut kept = false;
    if let Some(sequence) = sequence {
        let frames = Frames {
            data,
            scene,
            sequence,
            pictures: &there,
            with_reference,
        };
        previews = frames.previews();
        kept = frames.write(&mut album, shelf, notes)?;
    }
    if !kept {
        let cells = stills(scene, &there, with_reference, shelf)?;
        album.frames = vec![String::new()];
        album.viewers = vec![String::new()];
        album.cells = vec![vec![cells]];
    }
    Ok(Some(Viewer {
        scene: scene.title(),
        moment: if kept {
            String::new()
        } else {
            moment_of(data, scene)
        },
        many: album.frames.len() > 1,
        previews,
        album: serde_json::to_string(&album)?,
    }))
}

/// The pictures that jobs leave in any case: of the reference, if it is there, and of each method.
fn stills(
    scene: &SceneOf,
    there: &[&Pictures],
    with_reference: bool,
    shelf: &mut Shelf,
) -> io::Result<Vec<Cell>> {
    let style = |column: &str| {
        let values: Vec<f64> = there.iter().filter_map(|p| p.row.number(column)).collect();
        Style::of(Unit::None, values.into_iter())
    };
    let styles = [style("rmse"), style("flip_ldr")];
    let mut cells = Vec::new();
    if let Some(reference) = there.iter().find_map(|p| p.reference.as_ref())
        && with_reference
    {
        cells.push(Cell {
            image: Some(shelf.picture(&format!("{}-_reference", scene.name), reference)?),
            ..Cell::default()
        });
    }
    for pictures in there {
        let row = pictures.row;
        let name = |what: &str| format!("{}-{}_{what}", scene.name, row.label);
        let value = |column: &str, style: &Style| {
            let number = row.number(column);
            number.map_or_else(|| "—".to_owned(), |v| style.number(v))
        };
        let lights = pictures.lights.as_ref();
        let lights = lights.map(|own| link_of(&light_map::marked(&own.map, own)));
        let mut map = |what: &str, plane: &Option<Plane>| {
            let plane = plane.as_ref();
            plane.map(|p| shelf.map(&name(what), p)).transpose()
        };
        cells.push(Cell {
            flip: map("flip", &pictures.flip)?,
            records: map("records", &any(&pictures.records))?,
            discontinuity: map("discontinuity", &pictures.discontinuity)?,
            cells: map("cells", &any(&pictures.cells))?,
            image: Some(shelf.picture(&name("image"), &pictures.beauty)?),
            lights: lights.transpose()?,
            picture: None,
            values: format!(
                "RMSE {} · FLIP {}",
                value("rmse", &styles[0]),
                value("flip_ldr", &styles[1])
            ),
        });
    }
    Ok(cells)
}

/// A map that is not zero everywhere.
pub fn any(plane: &Option<Plane>) -> Option<Plane> {
    plane.clone().filter(|p| p.values.iter().any(|v| *v != 0.0))
}
