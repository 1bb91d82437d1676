//! The figures of a config, one file for each scene, and what stands in the report about them.

use std::io;
use std::num::NonZeroUsize;

use globset::Glob;
use serde::Serialize;

use super::data::{Data, SceneOf};
use super::font::Fonts;
use super::pictures::{self, Pictures};
use super::pixels::Shelf;
use super::sheet::Sheet;
use super::viewer::{self, Viewer};
use super::{
    components, contact_sheet, curves, escape, light_map, overlay, ranking, side_by_side, timeline,
};
use crate::experiment::{FigureKind, FigureSpec};
use crate::image::write_png_coded;

/// A figure that was written.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    pub title: String,
    /// How to read it.
    pub caption: String,
    /// Paths relative to the results folder; the first is shown.
    pub files: Vec<String>,
    #[serde(skip)]
    spec: usize,
}

/// All figures and viewers, and why some are not there.
#[derive(Clone, Debug, Default)]
pub struct Drawn {
    pub figures: Vec<Figure>,
    pub viewers: Vec<Viewer>,
    pub notes: Vec<String>,
}

/// A method of a figure: its label and its pictures, if they are there.
pub type Shown<'a, 'b> = (&'a str, Option<&'b Pictures<'b>>);

/// What stands above the panels of a figure, and how many are side by side, if the config says so.
#[derive(Clone, Copy)]
pub struct Head<'a> {
    pub title: &'a str,
    pub columns: Option<usize>,
}

/// A drawing and the text below it.
pub struct Drawing {
    pub sheet: Sheet,
    pub caption: String,
}

/// Draws everything; figures whose images are missing become notes. One scene's images are held at
/// a time.
pub fn draw_all(data: &Data, shelf: &mut Shelf) -> io::Result<Drawn> {
    let mut drawn = Drawn::default();
    let fonts = match Fonts::load() {
        Ok(fonts) => fonts,
        Err(reason) => {
            drawn.notes.push(reason);
            return Ok(drawn);
        }
    };
    for scene in &data.scenes {
        let pictures = pictures::of_scene(data, scene, &mut drawn.notes);
        for (index, spec) in data.config.figure.iter().enumerate() {
            if !spec.kind.is_plot() && shows_scene(spec, scene) {
                let shown = shown(data, spec, &pictures);
                one_scene(data, (&fonts, spec, index), (scene, &shown), &mut drawn)?;
            }
        }
        let viewer = viewer::write(data, (scene, &pictures), (shelf, &mut drawn.notes))?;
        drawn.viewers.extend(viewer);
    }
    for (index, spec) in data.config.figure.iter().enumerate() {
        match spec.kind {
            FigureKind::Curves => drawn.add((spec, index), curves::draw(data, spec)?),
            FigureKind::Ranking => drawn.add((spec, index), ranking::draw(data, spec)?),
            FigureKind::Timeline => {
                for scene in data.scenes.iter().filter(|scene| shows_scene(spec, scene)) {
                    let plot = timeline::draw(data, (spec, scene), &mut drawn.notes)?;
                    let plot = plot.map_err(|reason| format!("{}: {reason}", scene.name));
                    drawn.add((spec, index), plot);
                }
            }
            _ => {}
        }
    }
    drawn.figures.sort_by_key(|f| f.spec);
    drawn.notes.sort();
    drawn.notes.dedup();
    Ok(drawn)
}

impl Drawn {
    /// A plot, or why it is not there.
    fn add(&mut self, (spec, index): (&FigureSpec, usize), plot: Result<curves::Files, String>) {
        match plot {
            Ok((files, caption)) => self.figures.push(Figure {
                title: title_of(spec).to_owned(),
                caption,
                files,
                spec: index,
            }),
            Err(reason) => self.notes.push(format!("figure `{}`: {reason}", spec.name)),
        }
    }
}

/// Whether a figure is about a scene; names may be glob patterns.
pub fn shows_scene(spec: &FigureSpec, scene: &SceneOf) -> bool {
    let is = |pattern: &str, name: &str| {
        pattern == name || Glob::new(pattern).is_ok_and(|g| g.compile_matcher().is_match(name))
    };
    spec.scenes.is_empty()
        || spec.scenes.iter().any(|pattern| {
            is(pattern, &scene.name)
                || is(pattern, &scene.place.scene)
                || scene
                    .paper
                    .as_deref()
                    .is_some_and(|paper| is(pattern, paper))
        })
}

/// Whether a figure is about a method.
pub fn shows_method(spec: &FigureSpec, label: &str) -> bool {
    spec.methods.is_empty() || spec.methods.iter().any(|m| m == label)
}

fn shown<'a>(
    data: &'a Data,
    spec: &FigureSpec,
    pictures: &'a [Option<Pictures>],
) -> Vec<Shown<'a, 'a>> {
    data.labels()
        .iter()
        .zip(pictures)
        .filter(|(label, _)| shows_method(spec, label))
        .map(|(label, pictures)| (label.as_str(), pictures.as_ref()))
        .collect()
}

/// Which picture of a sequence stands for it, after a comma; nothing for a still.
pub fn moment_of(data: &Data, scene: &SceneOf) -> String {
    let sequence = data.sequence(scene, &data.points()[0]);
    match sequence.filter(|sequence| !sequence.is_still()) {
        None => String::new(),
        Some(sequence) => match &sequence.viewer_names()[..] {
            [_] => format!(", frame {}", sequence.representative()),
            names => format!(
                ", frame {} of viewer {}",
                sequence.representative(),
                names[0]
            ),
        },
    }
}

/// The title of a figure, or its name.
pub fn title_of(spec: &FigureSpec) -> &str {
    match spec.title.is_empty() {
        true => &spec.name,
        false => &spec.title,
    }
}

fn one_scene(
    data: &Data,
    (fonts, spec, index): (&Fonts, &FigureSpec, usize),
    (scene, shown): (&SceneOf, &[Shown]),
    drawn: &mut Drawn,
) -> io::Result<()> {
    let moment = match spec.kind.is_about_frames() {
        true => String::new(),
        false => moment_of(data, scene),
    };
    let title = format!("{} — {}{moment}", title_of(spec), scene.title());
    let head = Head {
        title: &title,
        columns: spec.columns.map(NonZeroUsize::get),
    };
    let drawing = match spec.kind {
        FigureKind::SideBySide => side_by_side::draw(fonts, shown, (&title, &spec.insets)),
        FigureKind::Records => overlay::records(fonts, shown, head),
        FigureKind::Discontinuity => overlay::discontinuity(fonts, shown, head),
        FigureKind::Lights => light_map::lights(fonts, shown, head),
        FigureKind::Classification => light_map::classes(fonts, shown, head),
        FigureKind::Components => components::draw(fonts, shown, head),
        FigureKind::Frames => {
            contact_sheet::draw(fonts, data, (scene, shown, &title), spec.per_viewer)
        }
        FigureKind::Curves | FigureKind::Ranking | FigureKind::Timeline => return Ok(()),
    };
    match drawing {
        Ok(Drawing { sheet, caption }) => {
            let name = escape::file_name(&format!("{}-{}", spec.name, scene.name));
            let clashes = sheet.clashes();
            let noted = clashes.iter().map(|c| format!("figure `{name}`: {c}"));
            drawn.notes.extend(noted);
            let files = ["png", "svg"].map(|kind| format!("figures/{name}.{kind}"));
            let path = data.store.folder.join(&files[0]);
            write_png_coded(&path, &sheet.image).map_err(io::Error::other)?;
            data.store
                .write(&files[1], &super::xml_text(&sheet.svg(spec.width_mm)))?;
            drawn.figures.push(Figure {
                title,
                caption,
                files: files.to_vec(),
                spec: index,
            });
        }
        Err(reason) => drawn.notes.push(format!(
            "figure `{}` of {}: {reason}",
            spec.name, scene.name
        )),
    }
    Ok(())
}
