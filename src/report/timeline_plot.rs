//! How a timeline is drawn.

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::Axis;
use super::plot::{self, FACE, LEGEND, Plot, Spot, TITLE, color, marker};
use super::{curves, number};

const WIDTH: u32 = 1080;
const HEIGHT: u32 = 290;
/// Height of the line that names viewers and the warm-up.
const KEYS: u32 = 36;
const SHADE: RGBAColor = RGBAColor(0, 0, 0, 0.08);
/// Markers of a line at most, about.
const MARKERS: usize = 10;
/// Lengths of dashes and of the spaces between them, by viewer; the first is solid.
const DASHES: [(u32, u32); 4] = [(0, 0), (10, 5), (3, 4), (18, 6)];

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

/// Everything that is drawn, whatever the backend.
pub struct Sheet {
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

impl Sheet {
    fn keyed(&self) -> bool {
        self.has_warm_up || !self.viewers.is_empty()
    }

    /// Rows of panels for each column.
    fn rows(&self) -> usize {
        self.columns[0].len().div_ceil(self.across).max(1)
    }

    /// Pixels.
    pub fn size(&self) -> (u32, u32) {
        let rows = (self.rows() * self.columns.len()) as u32;
        let keys = if self.keyed() { KEYS } else { 0 };
        let width = if self.across > 1 {
            WIDTH * 5 / 4
        } else {
            WIDTH
        };
        (width, TITLE + HEIGHT * rows + keys + LEGEND)
    }

    /// Viewers by their dashes and the shade of the warm-up.
    fn keys<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let middle = Pos::new(HPos::Left, VPos::Center);
        let style = (FACE, 18).into_font().color(&BLACK).pos(middle);
        let shade = self.has_warm_up.then_some("warm-up");
        let names = self.viewers.iter().map(String::as_str);
        let wide = |name: &str| 68 + 9 * name.chars().count() as i32;
        let total: i32 = names.clone().chain(shade).map(wide).sum();
        let (width, height) = area.dim_in_pixel();
        let (mut x, y) = (((width as i32 - total) / 2).max(4), height as i32 / 2);
        for (viewer, name) in names.enumerate() {
            let ends = vec![(x, y), (x + 44, y)];
            let (dash, space) = DASHES[viewer % DASHES.len()];
            let stroke = BLACK.stroke_width(2);
            match dash {
                0 => area.draw(&PathElement::new(ends, stroke))?,
                _ => area.draw(&DashedPathElement::new(ends, dash, space, stroke))?,
            }
            area.draw(&Text::new(name.to_owned(), (x + 52, y), style.clone()))?;
            x += wide(name);
        }
        if let Some(name) = shade {
            let corners = [(x + 16, y - 9), (x + 44, y + 9)];
            area.draw(&Rectangle::new(corners, SHADE.filled()))?;
            area.draw(&Rectangle::new(corners, BLACK.mix(0.3).stroke_width(1)))?;
            area.draw(&Text::new(name, (x + 52, y), style))?;
        }
        Ok(())
    }
}

impl Plot for Sheet {
    fn draw_on<B: DrawingBackend>(
        &self,
        root: &DrawingArea<B, Shift>,
        spots: &mut Vec<Spot>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let (mut sheets, legend) = plot::titled(root, &self.title)?;
        if self.keyed() {
            let (_, height) = sheets.dim_in_pixel();
            let (above, keys) = sheets.split_vertically(height - KEYS);
            self.keys(&keys)?;
            sheets = above;
        }
        let rows = self.rows();
        let cells = sheets.split_evenly((rows * self.columns.len(), self.across));
        for (column, panels) in self.columns.iter().enumerate() {
            let own = cells.iter().skip(column * rows * self.across);
            let is_last = column + 1 == self.columns.len();
            for (area, panel) in own.zip(panels) {
                let look = Look {
                    names_x: is_last,
                    methods: &self.methods,
                };
                draw_panel(area, panel, (look, spots))?;
            }
        }
        let entries = self.methods.iter().map(|(index, l)| (*index, l.as_str()));
        plot::legend(&legend, &entries.collect::<Vec<_>>())
    }
}

/// What a panel does not say of itself.
struct Look<'a> {
    names_x: bool,
    methods: &'a [(usize, String)],
}

fn draw_panel<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    panel: &Panel,
    (Look { names_x, methods }, spots): (Look, &mut Vec<Spot>),
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let [(_, x), (_, y)] = [&panel.x, &panel.y];
    let mut builder = ChartBuilder::on(area);
    if !panel.title.is_empty() {
        builder.caption(&panel.title, (FACE, 20));
    }
    let mut chart = builder
        .margin_left(12)
        .margin_right(28)
        .margin_top(10)
        .x_label_area_size(if names_x { 52 } else { 30 })
        .y_label_area_size(82)
        .build_cartesian_2d(x.clone(), y.clone())?;
    if let Some(end) = panel.warm_up_end {
        let corners = [(x.low(), y.low()), (end, y.high())];
        chart.draw_series([Rectangle::new(corners, SHADE.filled())])?;
    }
    let x_name = if names_x { panel.x.0.as_str() } else { "" };
    chart
        .configure_mesh()
        .x_desc(x_name)
        .y_desc(panel.y.0.clone())
        .label_style((FACE, 18))
        .axis_desc_style((FACE, 20))
        .bold_line_style(BLACK.mix(0.12))
        .light_line_style(TRANSPARENT)
        .draw()?;
    for line in &panel.lines {
        let color = color(line.method);
        for run in line.runs() {
            if run.iter().any(|p| p.half > 0.0) {
                let end = |p: &Point, half: f64| (p.x, (p.y + half).clamp(y.low(), y.high()));
                let upper = run.iter().map(|p| end(p, p.half));
                let lower = run.iter().rev().map(|p| end(p, -p.half));
                let outline: Vec<_> = upper.chain(lower).collect();
                chart.draw_series([Polygon::new(outline, color.mix(0.16))])?;
            }
        }
        let stroke = color.stroke_width(2);
        let (dash, space) = DASHES[line.viewer % DASHES.len()];
        for run in line.runs() {
            let points = run.iter().map(|p| (p.x, p.y));
            match dash {
                0 => drop(chart.draw_series(LineSeries::new(points, stroke))?),
                _ => drop(chart.draw_series(DashedLineSeries::new(points, dash, space, stroke))?),
            }
        }
        chart.draw_series(line.marked().map(|p| {
            EmptyElement::at((p.x, p.y)) + Polygon::new(marker(line.method), color.filled())
        }))?;
        let label = methods.iter().find(|(index, _)| *index == line.method);
        let label = label.map_or("", |(_, label)| label.as_str());
        spots.extend(line.points.iter().map(|p| Spot {
            at: chart.plotting_area().map_coordinate(&(p.x, p.y)),
            text: format!(
                "{label}: {} {}, {}",
                panel.x.0,
                number::lone(p.x),
                curves::value(&panel.y.0, p.y, p.half)
            ),
        }));
    }
    Ok(())
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
