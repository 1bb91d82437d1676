//! The ranks of the methods under each map: one panel per metric, the maps side by side.

use std::num::NonZeroUsize;

use glam::Vec2;

use super::axis::Axis;
use super::chart::{Around, Chart, left_room};
use super::data::{Asked, Data, SceneOf};
use super::estimate::{Estimate, ranks};
use super::figure::{Drawing, shows_method, shows_scene, title_of};
use super::font::Fonts;
use super::legend::Mark;
use super::look::{EM, color, marker, unit};
use super::plot::Plot;
use super::sheet::{Sheet, Stroke};
use crate::experiment::Column;
use crate::experiment::{Case, FigureSpec};

/// Widths of a map and of the rest, and height of a rank.
const MAP: f32 = 44.0;
const LEAST_WIDTH: f32 = 600.0;
const SIDES: f32 = 110.0;
const RANK: f32 = 34.0;

/// One metric.
struct Panel {
    title: String,
    /// For each method that is shown its rank under each map; `None` where a method has no value.
    ranks: Vec<Vec<Option<f64>>>,
}

/// Draws the plot; says why when there is nothing to draw.
pub fn draw(fonts: &Fonts, data: &Data, spec: &FigureSpec) -> Result<Drawing, String> {
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
                |(_, scenes): &(String, Vec<&SceneOf>)| of_map(data, &methods, scenes, &column);
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
        return Err(reason.into());
    }
    let names: Vec<String> = maps.into_iter().map(|(name, _)| name).collect();
    let (x, y) = (Axis::places(names.len()), Axis::ranks(methods.len()));
    let left = left_room(fonts, [&y].into_iter());
    let around = panels.iter().map(|panel| Around {
        title: &panel.title,
        x: ("", &x),
        y: ("rank", &y),
        names: &names,
        left,
    });
    let around: Vec<Around> = around.collect();
    let labels = methods.iter();
    let plot = Plot {
        title: title_of(spec),
        legend: labels
            .map(|(index, label)| (Mark::Method(*index), (*label).to_owned()))
            .collect(),
        columns: spec.columns.map_or(1, NonZeroUsize::get).min(panels.len()),
        panel: (
            (SIDES + MAP * names.len() as f32).max(LEAST_WIDTH),
            RANK * methods.len() as f32 * fonts.em / EM,
        ),
    };
    let rows: Vec<&[Around]> = around.chunks(plot.columns).collect();
    Ok(Drawing {
        sheet: plot.draw(fonts, &rows, |sheet, index, chart| {
            let painted = Painted {
                panel: &panels[index],
                chart,
                methods: &methods,
                maps: &names,
            };
            paint(sheet, fonts, painted);
        }),
        caption:
            "Ranks of the methods under each map, 1 the best, by the mean over its scenes and seeds."
                .into(),
    })
}

/// A panel and where it is drawn.
struct Painted<'a> {
    panel: &'a Panel,
    chart: &'a Chart<'a>,
    /// With their positions in the config.
    methods: &'a [(usize, &'a str)],
    /// Names of the maps.
    maps: &'a [String],
}

/// The ranks of each method from map to map.
fn paint(sheet: &mut Sheet, fonts: &Fonts, painted: Painted) {
    let Painted {
        panel,
        chart,
        methods,
        maps,
    } = painted;
    let unit = unit(fonts);
    for ((index, label), ranks) in methods.iter().zip(&panel.ranks) {
        let color = color(*index);
        let there = ranks.iter().enumerate();
        let there = there.filter_map(|(map, rank)| Some((map, (*rank)?)));
        let there: Vec<(usize, f64)> = there.collect();
        let place = |(map, rank): &(usize, f64)| chart.at(*map as f64, *rank);
        let places: Vec<Vec2> = there.iter().map(place).collect();
        sheet.line(&places, Stroke::solid(color, 2.0 * unit));
        for ((map, rank), place) in there.iter().zip(places) {
            sheet.polygon(&marker(*index, place, unit), color, 1.0);
            let text = format!("{label}, {}: {} rank {rank}", maps[*map], panel.title);
            sheet.spot(place, &text);
        }
    }
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
    methods: &[(usize, &str)],
    scenes: &[&SceneOf],
    column: &Column,
) -> Option<Vec<f64>> {
    let mean = |label: &str| -> Option<Estimate> {
        let values = scenes.iter().map(|scene| {
            let case = Asked {
                scene,
                label,
                point: &data.points()[0],
            };
            Some(data.whole(case, &column.key)?.mean)
        });
        let values: Vec<f64> = values.collect::<Option<_>>()?;
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        Estimate::new([(0, mean)].into())
    };
    let means: Vec<Option<Estimate>> = methods.iter().map(|(_, label)| mean(label)).collect();
    let rivals: Vec<Option<&Estimate>> = means.iter().map(Option::as_ref).collect();
    ranks(&rivals, column.lower_is_better?)
}
