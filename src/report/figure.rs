//! The figures of a config, one file for each scene, and what stands in the report about them.

use std::io;
use std::num::NonZeroUsize;

use glob::Pattern;
use serde::Serialize;

use super::data::{Data, SceneOf};
use super::font::Fonts;
use super::look;
use super::paper::{self, Print};
use super::pictures::{self, Pictures};
use super::pixels::Shelf;
use super::sheet::Sheet;
use super::viewer::{self, Viewer};
use super::{
    components, contact_sheet, curves, escape, light_map, overlay, ranking, side_by_side, timeline,
};
use crate::experiment::{FigureKind, FigureSpec};

/// Scale of figures of pictures: an inch has 300 of their pixels, which are pixels of the PNG too.
const PICTURES: Scale = Scale {
    units_per_inch: 300.0,
    em: 24.0,
    pixels: 1,
};
/// Scale of plots: a panel is as wide as a column of a paper.
const PLOTS: Scale = Scale {
    units_per_inch: 180.0,
    em: look::EM,
    pixels: 2,
};
const MM_PER_INCH: f64 = 25.4;
const POINTS_PER_INCH: f64 = 72.0;
/// How many times larger than usual text is drawn at most.
const LARGEST: f32 = 4.0;

/// Sizes of a figure where the config does not say them.
struct Scale {
    /// Units of the sheet in an inch of paper.
    units_per_inch: f64,
    /// Size of common text, units.
    em: f32,
    /// Pixels of the PNG in a unit.
    pixels: usize,
}

/// A figure that was written.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    pub title: String,
    /// How to read it.
    pub caption: String,
    /// Paths relative to the results folder; the first is shown.
    pub files: Vec<String>,
    /// Size on the page, pixels: an inch of every figure has as many, so that all text is of one size.
    pub width: usize,
    pub height: usize,
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
                let asked = Asked {
                    data,
                    spec,
                    index,
                    scene: Some(&scene.name),
                };
                one_scene(&asked, &fonts, scene, &shown, &mut drawn)?;
            }
        }
        let viewer = viewer::write(data, scene, &pictures, shelf, &mut drawn.notes)?;
        drawn.viewers.extend(viewer);
    }
    for (index, spec) in data.config.figure.iter().enumerate() {
        let of_scene = |scene| Asked {
            data,
            spec,
            index,
            scene,
        };
        let asked = of_scene(None);
        let title = title_of(spec);
        match spec.kind {
            FigureKind::Curves => {
                drawn.add(&asked, &spec.name, title, &fonts, |fonts| {
                    curves::draw(fonts, data, spec)
                })?;
            }
            FigureKind::Ranking => {
                drawn.add(&asked, &spec.name, title, &fonts, |fonts| {
                    ranking::draw(fonts, data, spec)
                })?;
            }
            FigureKind::Timeline => {
                for scene in data.scenes.iter().filter(|scene| shows_scene(spec, scene)) {
                    let timeline = timeline::of_scene(data, spec, scene, &mut drawn.notes);
                    let name = format!("{}-{}", spec.name, scene.name);
                    let asked = of_scene(Some(&scene.name));
                    drawn.add(&asked, &name, title, &fonts, |fonts| {
                        let (timeline, caption) = timeline.as_ref().map_err(String::clone)?;
                        Ok(Drawing {
                            sheet: timeline.draw(fonts),
                            caption: caption.clone(),
                        })
                    })?;
                }
            }
            _ => {}
        }
    }
    drawn.figures.sort_by_key(|f| f.spec);
    drawn.notes.extend(data.references.notes());
    drawn.notes.sort();
    drawn.notes.dedup();
    Ok(drawn)
}

/// A figure that a config asks for, and its position there; of which scene, if it is of one.
struct Asked<'a> {
    data: &'a Data,
    spec: &'a FigureSpec,
    index: usize,
    scene: Option<&'a str>,
}

impl Asked<'_> {
    fn scale(&self) -> Scale {
        match self.spec.kind.is_plot() {
            true => PLOTS,
            false => PICTURES,
        }
    }

    /// A drawing and its width on paper. It is drawn again until its text has the size that is asked for: how wide it
    /// is may depend on that.
    fn sized(
        &self,
        fonts: &Fonts,
        draw: impl Fn(&Fonts) -> Result<Drawing, String>,
    ) -> Result<(Drawing, f64), String> {
        let scale = self.scale();
        let mut em = scale.em;
        let mut drawing = draw(&fonts.at(em))?;
        for _ in 0..4 {
            let Some(points) = self.spec.font_pt else {
                break;
            };
            let units_per_inch = drawing.sheet.width as f64 / self.inches(&drawing);
            let right = (points / POINTS_PER_INCH * units_per_inch) as f32;
            let right = right.min(LARGEST * scale.em);
            if (right / em - 1.0).abs() < 0.01 {
                break;
            }
            em = right;
            drawing = draw(&fonts.at(em))?;
        }
        let width_mm = self.inches(&drawing) * MM_PER_INCH;
        Ok((drawing, width_mm))
    }

    /// Width on paper.
    fn inches(&self, drawing: &Drawing) -> f64 {
        match self.spec.width_mm {
            Some(width_mm) => width_mm / MM_PER_INCH,
            None => drawing.sheet.width as f64 / self.scale().units_per_inch,
        }
    }
}

impl Drawn {
    /// Writes a figure, given its file name and title, or notes why it is not there.
    fn add(
        &mut self,
        asked: &Asked,
        name: &str,
        title: &str,
        fonts: &Fonts,
        draw: impl Fn(&Fonts) -> Result<Drawing, String>,
    ) -> io::Result<()> {
        let spec = asked.spec;
        let note = |reason: &str| match asked.scene {
            Some(scene) => format!("figure `{}` of {scene}: {reason}", spec.name),
            None => format!("figure `{}`: {reason}", spec.name),
        };
        let (Drawing { sheet, caption }, width_mm) = match asked.sized(fonts, draw) {
            Ok(drawing) => drawing,
            Err(reason) => {
                self.notes.push(note(&reason));
                return Ok(());
            }
        };
        let name = escape::file_name(name);
        let folder = asked.data.store.folder.join("figures");
        let print = Print {
            sheet: &sheet,
            width_mm,
            pixels: asked.scale().pixels,
        };
        match paper::write(&folder, &name, fonts, &print)? {
            Ok(clashes) => self.notes.extend(clashes.iter().map(|clash| note(clash))),
            Err(reason) => {
                self.notes.push(note(&reason));
                return Ok(());
            }
        }
        let on_page = |units: usize| {
            (units as f64 * PLOTS.units_per_inch / asked.scale().units_per_inch).round() as usize
        };
        // Points of a plot tell what they stand for on the page: its SVG is shown.
        let endings = match spec.kind.is_plot() {
            true => ["svg", "png", "pdf"],
            false => ["png", "svg", "pdf"],
        };
        self.figures.push(Figure {
            title: title.to_owned(),
            caption,
            files: endings
                .map(|ending| format!("figures/{name}.{ending}"))
                .to_vec(),
            width: on_page(sheet.width),
            height: on_page(sheet.height),
            spec: asked.index,
        });
        Ok(())
    }
}

/// Whether a figure is about a scene; names may be glob patterns.
pub fn shows_scene(spec: &FigureSpec, scene: &SceneOf) -> bool {
    let is = |pattern: &str, name: &str| {
        pattern == name || Pattern::new(pattern).is_ok_and(|glob| glob.matches(name))
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

/// The methods of a figure of pictures, in the order that it asks for them.
fn shown<'a>(
    data: &'a Data,
    spec: &FigureSpec,
    pictures: &'a [Option<Pictures>],
) -> Vec<Shown<'a, 'a>> {
    let mut shown: Vec<Shown> = data
        .labels()
        .iter()
        .zip(pictures)
        .filter(|(label, _)| shows_method(spec, label))
        .map(|(label, pictures)| (label.as_str(), pictures.as_ref()))
        .collect();
    shown.sort_by_key(|(label, _)| spec.methods.iter().position(|asked| asked == label));
    shown
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
    asked: &Asked,
    fonts: &Fonts,
    scene: &SceneOf,
    shown: &[Shown],
    drawn: &mut Drawn,
) -> io::Result<()> {
    let Asked { data, spec, .. } = *asked;
    let moment = match spec.kind.is_about_frames() {
        true => String::new(),
        false => moment_of(data, scene),
    };
    let title = format!("{} — {}{moment}", title_of(spec), scene.title());
    let head = Head {
        title: &title,
        columns: spec.columns.map(NonZeroUsize::get),
    };
    let draw = |fonts: &Fonts| match spec.kind {
        FigureKind::SideBySide => side_by_side::draw(fonts, shown, head, &spec.insets),
        FigureKind::Records => overlay::records(fonts, shown, head),
        FigureKind::Discontinuity => overlay::discontinuity(fonts, shown, head),
        FigureKind::Lights => light_map::lights(fonts, shown, head),
        FigureKind::Classification => light_map::classes(fonts, shown, head),
        FigureKind::Components => components::draw(fonts, shown, head),
        FigureKind::Frames => contact_sheet::draw(fonts, data, scene, shown, head, spec.per_viewer),
        FigureKind::Curves | FigureKind::Ranking | FigureKind::Timeline => {
            Err("a plot is not about one scene's images".into())
        }
    };
    let name = format!("{}-{}", spec.name, scene.name);
    drawn.add(asked, &name, &title, fonts, draw)
}
