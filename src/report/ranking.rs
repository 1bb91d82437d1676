//! The ranks of the methods under each map: one panel per metric, the maps side by side.

use std::io;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::curves::Files;
use super::data::{Asked, Data, SceneOf};
use super::estimate::{Estimate, ranks};
use super::figure::{shows_method, shows_scene};
use super::plot::{self, FACE, LEGEND, Plot, Spot, TITLE, color, marker};
use crate::experiment::Column;
use crate::experiment::{Case, FigureSpec};

/// Widths of a map and of the rest, height of a rank and of the rest without the names, pixels.
const MAP: u32 = 44;
const LEAST_WIDTH: u32 = 760;
const SIDES: u32 = 110;
const RANK: u32 = 34;
const HEAD: u32 = 60;
/// Height of a character of a map's name, which stands upright.
const CHARACTER: u32 = 9;

/// One metric.
struct Panel {
    title: String,
    /// For each method that is shown its rank under each map; `None` where a method has no value.
    ranks: Vec<Vec<Option<f64>>>,
}

struct Sheet<'a> {
    title: &'a str,
    maps: Vec<String>,
    /// Positions in the config, and labels.
    methods: Vec<(usize, &'a str)>,
    panels: Vec<Panel>,
}

/// Writes the plot; says why when there is nothing to draw.
pub fn draw(data: &Data, spec: &FigureSpec) -> io::Result<Result<Files, String>> {
    let shown = data.labels().iter().enumerate();
    let methods: Vec<(usize, &str)> = shown
        .filter(|(_, label)| shows_method(spec, label))
        .map(|(index, label)| (index, label.as_str()))
        .collect();
    let maps = maps(data, spec);
    let metrics = match &spec.y[..] {
        [] => &["rmse".to_owned(), "flip_ldr".to_owned()],
        given => given,
    };
    let panels: Vec<Panel> = metrics
        .iter()
        .map(|key| {
            let column = Column::of(key);
            let of_map =
                |(_, scenes): &(String, Vec<&SceneOf>)| of_map(data, (&methods, scenes), &column);
            let by_map: Vec<Option<Vec<f64>>> = maps.iter().map(of_map).collect();
            let of_method = |m: usize| by_map.iter().map(|r| r.as_ref().map(|r| r[m])).collect();
            Panel {
                title: column.heading,
                ranks: (0..methods.len()).map(of_method).collect(),
            }
        })
        .collect();
    if panels
        .iter()
        .all(|p| p.ranks.iter().flatten().all(Option::is_none))
    {
        let reason = "no map has a value of every method, or the metrics have no better and worse";
        return Ok(Err(reason.into()));
    }
    let sheet = Sheet {
        title: if spec.title.is_empty() {
            &spec.name
        } else {
            &spec.title
        },
        maps: maps.into_iter().map(|(name, _)| name).collect(),
        methods,
        panels,
    };
    let caption =
        "Ranks of the methods under each map, 1 the best, by the mean over its scenes and seeds.";
    let files = plot::write(data, (&spec.name, spec.width_mm), (sheet.size(), &sheet))?;
    Ok(files.map(|files| (files, caption.into())))
}

/// The maps of a plan with the scenes under each, in its order; a scene without a map of its own
/// stands alone.
fn maps<'a>(data: &'a Data, spec: &FigureSpec) -> Vec<(String, Vec<&'a SceneOf>)> {
    let mut maps: Vec<(String, Vec<&SceneOf>)> = Vec::new();
    for scene in data.scenes.iter().filter(|scene| shows_scene(spec, scene)) {
        let job = data
            .plan
            .jobs
            .iter()
            .find(|job| Case::of_job(job).place == scene.place);
        let map = job.and_then(|job| job.environment.as_ref());
        let name = map.unwrap_or(&scene.name);
        match maps.iter_mut().find(|(known, _)| known == name) {
            Some((_, scenes)) => scenes.push(scene),
            None => maps.push((name.clone(), vec![scene])),
        }
    }
    maps
}

/// The rank of each method by its mean over the scenes, at the first swept value.
fn of_map(
    data: &Data,
    (methods, scenes): (&[(usize, &str)], &[&SceneOf]),
    column: &Column,
) -> Option<Vec<f64>> {
    let mean = |label: &str| -> Option<Estimate> {
        let values = scenes.iter().map(|scene| {
            let case = Asked {
                scene,
                label,
                point: &data.points()[0],
            };
            Some(data.estimate(case, &column.key)?.mean)
        });
        let values: Vec<f64> = values.collect::<Option<_>>()?;
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        Estimate::new([(0, mean)].into())
    };
    let means: Vec<Option<Estimate>> = methods.iter().map(|(_, label)| mean(label)).collect();
    let rivals: Vec<Option<&Estimate>> = means.iter().map(Option::as_ref).collect();
    ranks(&rivals, column.lower_is_better?)
}

impl Sheet<'_> {
    fn names_height(&self) -> u32 {
        let longest = self.maps.iter().map(|name| name.chars().count()).max();
        CHARACTER * longest.unwrap_or(0) as u32 + 16
    }

    fn size(&self) -> (u32, u32) {
        let width = (SIDES + MAP * self.maps.len() as u32).max(LEAST_WIDTH);
        let panel = HEAD + RANK * (self.methods.len() as u32 + 1) + self.names_height();
        (width, TITLE + panel * self.panels.len() as u32 + LEGEND)
    }

    fn draw_panel<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        panel: &Panel,
        spots: &mut Vec<Spot>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let (maps, last) = (self.maps.len() as f64, self.methods.len() as f64);
        // The best rank is on top.
        let (x, y) = (-0.5..maps - 0.5, last + 0.5..0.5);
        let mut chart = ChartBuilder::on(area)
            .caption(&panel.title, (FACE, 22))
            .margin_left(12)
            .margin_right(20)
            .margin_top(6)
            .x_label_area_size(self.names_height())
            .y_label_area_size(64)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .x_labels(0)
            .y_labels(self.methods.len() + 1)
            .y_label_formatter(&|rank| format!("{rank:.0}"))
            .y_desc("rank")
            .label_style((FACE, 18))
            .axis_desc_style((FACE, 20))
            .bold_line_style(BLACK.mix(0.12))
            .light_line_style(TRANSPARENT)
            .draw()?;
        let upright = (FACE, 17)
            .into_font()
            .transform(FontTransform::Rotate270)
            .color(&BLACK)
            .pos(Pos::new(HPos::Right, VPos::Center));
        let (left, top) = area.get_base_pixel();
        for (position, name) in self.maps.iter().enumerate() {
            let line = BLACK.mix(0.08);
            let x = position as f64;
            chart.draw_series([PathElement::new(vec![(x, 0.5), (x, last + 0.5)], line)])?;
            let foot = chart.plotting_area().map_coordinate(&(x, last + 0.5));
            let at = (foot.0 - left, foot.1 - top + 10);
            area.draw(&Text::new(name.clone(), at, upright.clone()))?;
        }
        for ((index, label), ranks) in self.methods.iter().zip(&panel.ranks) {
            let color = color(*index);
            let there: Vec<(f64, f64)> = (0..)
                .zip(ranks)
                .filter_map(|(map, rank)| Some((f64::from(map), (*rank)?)))
                .collect();
            chart.draw_series(LineSeries::new(
                there.iter().copied(),
                color.stroke_width(2),
            ))?;
            chart.draw_series(
                there
                    .iter()
                    .map(|&at| EmptyElement::at(at) + Polygon::new(marker(*index), color.filled())),
            )?;
            spots.extend(there.iter().map(|at| Spot {
                at: chart.plotting_area().map_coordinate(at),
                text: format!(
                    "{label}, {}: {} rank {}",
                    self.maps[at.0 as usize], panel.title, at.1
                ),
            }));
        }
        Ok(())
    }
}

impl Plot for Sheet<'_> {
    fn draw_on<B: DrawingBackend>(
        &self,
        root: &DrawingArea<B, Shift>,
        spots: &mut Vec<Spot>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let (panels, legend) = plot::titled(root, self.title)?;
        let areas = panels.split_evenly((self.panels.len(), 1));
        for (area, panel) in areas.iter().zip(&self.panels) {
            self.draw_panel(area, panel, spots)?;
        }
        plot::legend(&legend, &self.methods)
    }
}
