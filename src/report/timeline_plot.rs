//! How a timeline is drawn.

use glam::Vec2;

use super::axis::Axis;
use super::chart::{Around, Chart, left_room};
use super::font::Fonts;
use super::legend::{Mark, SHADE};
use super::look::{color, marker, unit};
use super::plot::Plot;
use super::sheet::{Sheet, Stroke};
use super::{curves, number};

/// Width of all panels side by side, and height of the inner part of one.
const WIDTH: f32 = 1200.0;
const HEIGHT: f32 = 200.0;
/// Markers of a line at most, about.
const MARKERS: usize = 10;
/// Lengths of dashes and of the spaces between them, by viewer; the first is solid.
const DASHES: [Option<(f32, f32)>; 4] =
    [None, Some((10.0, 5.0)), Some((3.0, 4.0)), Some((18.0, 6.0))];

/// A frame's value.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Position of the frame in the sequence.
    pub place: usize,
    pub x: f64,
    pub y: f64,
    /// Half width of the interval of y.
    pub half: f64,
}

/// A method's values over frames.
#[derive(Debug)]
pub struct Line {
    /// Position of the method in the config: decides colour and marker.
    pub method: usize,
    /// Decides the dashes.
    pub viewer: usize,
    pub points: Vec<Point>,
}

/// A column at a swept value.
#[derive(Debug)]
pub struct Panel {
    /// The swept value.
    pub title: String,
    pub x: (String, Axis),
    pub y: (String, Axis),
    pub lines: Vec<Line>,
    /// Where the shade of the warm-up ends.
    pub warm_up_end: Option<f64>,
}

/// Everything that is drawn.
pub struct Timeline {
    pub title: String,
    /// The panels of each column of `frames.csv`.
    pub columns: Vec<Vec<Panel>>,
    /// Panels side by side.
    pub across: usize,
    /// Positions in the config, and labels.
    pub methods: Vec<(usize, String)>,
    /// Names, where viewers have lines of their own.
    pub viewers: Vec<String>,
    pub has_warm_up: bool,
}

impl Panel {
    /// Whether no frame has a value.
    pub fn is_empty(&self) -> bool {
        self.lines.iter().all(|line| line.points.is_empty())
    }
}

impl Line {
    /// The points in runs of neighbours: a line is not drawn over frames that lack a value.
    fn runs(&self) -> impl Iterator<Item = &[Point]> {
        let steps = self.points.windows(2).map(|p| p[1].place - p[0].place);
        let step = steps.min().unwrap_or(1);
        self.points.chunk_by(move |a, b| b.place - a.place <= step)
    }

    /// Points that are marked, so that lines are told apart without colours and on top of one another: some, at
    /// other places for each method; all that stand alone.
    fn marked(&self) -> impl Iterator<Item = &Point> {
        let every = self.points.len().div_ceil(MARKERS).max(1);
        let first = self.method * every.div_ceil(5) % every;
        let regular = self.points.iter().skip(first).step_by(every);
        let alone = self.runs().filter(|run| run.len() == 1).flatten();
        regular.chain(alone)
    }
}

impl Timeline {
    /// Draws all panels; the horizontal axes of the last column of `frames.csv` are named.
    pub fn draw(&self, fonts: &Fonts) -> Sheet {
        let panels: Vec<(bool, &Panel)> = self.in_rows();
        let left = left_room(fonts, panels.iter().map(|(_, panel)| &panel.y.1));
        let around = panels.iter().map(|(is_last, panel)| Around {
            title: &panel.title,
            x: (if *is_last { &panel.x.0 } else { "" }, &panel.x.1),
            y: (&panel.y.0, &panel.y.1),
            names: &[],
            left,
        });
        let around: Vec<Around> = around.collect();
        // Each column of `frames.csv` begins a row.
        let columns = around.chunks(self.columns[0].len());
        let rows: Vec<&[Around]> = columns.flat_map(|c| c.chunks(self.across)).collect();
        let plot = Plot {
            title: &self.title,
            legend: self.legend(fonts),
            columns: self.across,
            panel: (WIDTH / self.across as f32, HEIGHT),
        };
        plot.draw(fonts, &rows, |sheet, index, chart| {
            self.paint(sheet, fonts, panels[index].1, chart);
        })
    }

    /// The panels one after another, and whether their column is the last.
    fn in_rows(&self) -> Vec<(bool, &Panel)> {
        let columns = self.columns.iter().enumerate();
        let panels = columns.flat_map(|(index, panels)| {
            let is_last = index + 1 == self.columns.len();
            panels.iter().map(move |panel| (is_last, panel))
        });
        panels.collect()
    }

    fn legend(&self, fonts: &Fonts) -> Vec<(Mark, String)> {
        let methods = self.methods.iter();
        let methods = methods.map(|(index, label)| (Mark::Method(*index), label.clone()));
        let viewers = self.viewers.iter().enumerate();
        let viewers = viewers.map(|(viewer, name)| (Mark::Line(dash(fonts, viewer)), name.clone()));
        let shade = self
            .has_warm_up
            .then(|| (Mark::Shade, "warm-up".to_owned()));
        methods.chain(viewers).chain(shade).collect()
    }

    fn paint(&self, sheet: &mut Sheet, fonts: &Fonts, panel: &Panel, chart: &Chart) {
        let y_axis = &panel.y.1;
        let unit = unit(fonts);
        if let Some(end) = panel.warm_up_end {
            let area = chart.area;
            let end = chart.at(end, y_axis.low()).x;
            let (left, top, bottom) = (area.left, area.top, area.bottom);
            let corners = [(left, top), (end, top), (end, bottom), (left, bottom)];
            let corners = corners.map(|(x, y)| Vec2::new(x, y));
            sheet.polygon(&corners, [0.0; 3], SHADE);
        }
        for line in &panel.lines {
            let color = color(line.method);
            for run in line.runs().filter(|run| run.iter().any(|p| p.half > 0.0)) {
                let end = |p: &Point, half: f64| {
                    chart.at(p.x, (p.y + half).clamp(y_axis.low(), y_axis.high()))
                };
                let upper = run.iter().map(|p| end(p, p.half));
                let lower = run.iter().rev().map(|p| end(p, -p.half));
                let outline: Vec<Vec2> = upper.chain(lower).collect();
                sheet.polygon(&outline, color, 0.16);
            }
            let stroke = Stroke {
                dash: dash(fonts, line.viewer),
                ..Stroke::solid(color, 2.0 * unit)
            };
            for run in line.runs().filter(|run| run.len() > 1) {
                let places: Vec<Vec2> = run.iter().map(|p| chart.at(p.x, p.y)).collect();
                sheet.line(&places, stroke);
            }
            for point in line.marked() {
                let place = chart.at(point.x, point.y);
                sheet.polygon(&marker(line.method, place, unit), color, 1.0);
            }
            let label = self.methods.iter().find(|(index, _)| *index == line.method);
            let label = label.map_or("", |(_, label)| label.as_str());
            for point in &line.points {
                let text = format!(
                    "{label}: {} {}, {}",
                    panel.x.0,
                    number::lone(point.x),
                    curves::value(&panel.y.0, point.y, point.half)
                );
                sheet.spot(chart.at(point.x, point.y), &text);
            }
        }
    }
}

/// The dashes of a viewer at the size of the text.
fn dash(fonts: &Fonts, viewer: usize) -> Option<(f32, f32)> {
    let dash = DASHES[viewer % DASHES.len()];
    dash.map(|(dash, space)| (dash * unit(fonts), space * unit(fonts)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_stop_at_frames_without_a_value_and_lone_points_are_marked() {
        let point = |place: usize| Point {
            place,
            x: place as f64,
            y: 1.0,
            half: 0.0,
        };
        // One frame in two is measured; that at 6 has no value.
        let line = Line {
            method: 1,
            viewer: 0,
            points: [2, 4, 8].map(point).to_vec(),
        };
        let runs: Vec<usize> = line.runs().map(<[Point]>::len).collect();
        assert_eq!(runs, [2, 1]);
        assert!(line.marked().any(|p| p.place == 8));
    }
}
