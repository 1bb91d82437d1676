//! What an experiment file asks its report for: tables, figures, claims and gates, and the numbers of a paper beside them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::arrays;

/// A table over rows: mean and 95 % interval over repeats of each metric.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TableSpec {
    /// File name of the table.
    pub name: String,
    /// Heading in the report; empty: the name.
    #[serde(default)]
    pub title: String,
    /// `methods` (one line a method, columns scene × metric), `averages` (one line a method, means over
    /// the scenes and mean ranks; `[[published]]` numbers of scene `*` stand beside), `stages` (processor seconds, one line a stage,
    /// columns scene × method), `sweep` (one line a method, columns the swept values), `change` (one line a method,
    /// its error against the first method's at the same budgets), `equal-cost` (at equal `cost`),
    /// `equal-error` (its `cost` against the first method's at equal error).
    #[serde(default = "methods_kind")]
    pub kind: TableKind,
    /// Row columns: `rmse`, `flip_ldr`, `cpu_seconds_total`, `shadow_rays`, …
    #[serde(default = "default_metrics")]
    pub metrics: Vec<String>,
    /// `equal-cost`, `equal-error`: the row column of the cost, `all_rays` or `cpu_seconds_total`, say.
    #[serde(default = "default_cost")]
    pub cost: String,
}

/// What the lines and columns of a table are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TableKind {
    /// A line for each method, columns scene × metric.
    Methods,
    /// A line for each method: means over the scenes, and mean ranks.
    Averages,
    /// A line for each stage: its processor seconds, columns scene × method.
    Stages,
    /// A line for each method, columns the swept values.
    Sweep,
    /// A line for each method: its error over that of the first one at the same budgets.
    Change,
    /// A line for each method: its error over that of the first one where it costs as much.
    EqualCost,
    /// A line for each method: its cost over that of the first one where it errs as much.
    EqualError,
}

impl TableKind {
    /// Whether its columns are those that `metrics` names.
    pub fn shows_metrics(self) -> bool {
        self != Self::Stages
    }
}

fn default_cost() -> String {
    "all_rays".into()
}

fn methods_kind() -> TableKind {
    TableKind::Methods
}

fn default_metrics() -> Vec<String> {
    vec!["rmse".into(), "flip_ldr".into()]
}

/// A figure from rows and images.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FigureSpec {
    /// File name of the figure.
    pub name: String,
    /// Heading in the report; empty: the name.
    #[serde(default)]
    pub title: String,
    /// What is drawn.
    pub kind: FigureKind,
    /// Scenes to show (resolved names or glob patterns); default all.
    #[serde(default)]
    pub scenes: Vec<String>,
    /// Labels of methods to show; default all.
    #[serde(default)]
    pub methods: Vec<String>,
    /// Insets of `side-by-side`, as fractions `[x, y, width, height]` of the image. Without any,
    /// they are placed where the methods differ most.
    #[serde(default, deserialize_with = "arrays::each")]
    pub insets: Vec<[f64; 4]>,
    /// `curves`: the row column on the horizontal axis, and those on the vertical axes; `ranking`: only
    /// those, `rmse` and `flip_ldr` by default; `timeline`: `frame` or `time` and columns of `frames.csv`.
    #[serde(default)]
    pub x: Option<String>,
    /// The row columns, or of `timeline` those of `frames.csv`, on the vertical axes; see `x`.
    #[serde(default)]
    pub y: Vec<String>,
    /// `timeline`: a line for each viewer in place of their mean; `frames`: rows for each viewer in place of the
    /// first.
    #[serde(default)]
    pub per_viewer: bool,
    /// Panels, frames, or methods of `side-by-side`, in a row; by default as many as suit their size.
    #[serde(default)]
    pub columns: Option<std::num::NonZeroUsize>,
    /// Width on paper, millimetres; by default an inch has 300 pixels of a picture, and a panel of a plot is 85 mm wide.
    #[serde(default)]
    pub width_mm: Option<f64>,
    /// Size of common text on paper, points; default 5.8, of plots 7.2. What has no room is set smaller.
    #[serde(default)]
    pub font_pt: Option<f64>,
}

impl FigureKind {
    /// Whether it takes what jobs keep of their lights when such a figure is asked for.
    pub fn shows_lights(self) -> bool {
        matches!(self, Self::Lights | Self::Classification | Self::Components)
    }

    /// Whether it is a plot, made of numbers alone.
    pub fn is_plot(self) -> bool {
        matches!(self, Self::Curves | Self::Ranking | Self::Timeline)
    }

    /// Whether it is about the frames of sequences.
    pub fn is_about_frames(self) -> bool {
        matches!(self, Self::Timeline | Self::Frames)
    }
}

/// What a figure shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FigureKind {
    /// Reference and contenders with insets, error values and FLIP maps.
    SideBySide,
    /// Metrics against a swept or measured quantity.
    Curves,
    /// Record positions over the image, first stage and refinement in two colours.
    Records,
    /// The map that guided the refinement.
    Discontinuity,
    /// Lights on the tone-mapped environment map, direct and indirect in two colours.
    Lights,
    /// Emissive and other texels of the environment map in two colours.
    Classification,
    /// The classified environment map, then the image of each method, such as the parts of one.
    Components,
    /// Ranks of the methods under each environment map, for each metric of `y`.
    Ranking,
    /// Columns of `frames.csv` over the frames of a sequence.
    Timeline,
    /// Kept frames of a sequence: the reference and each method a row, the frames columns.
    Frames,
}

/// A statement of the paper about rows.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ClaimSpec {
    /// What the paper says, in a sentence.
    pub text: String,
    /// Where the paper says so.
    #[serde(rename = "where")]
    pub place: String,
    /// For example `rmse(VGC+DGS) < rmse(VGC)`; judged for every scene and swept value.
    pub expect: String,
    /// Scenes it is about (names of rows, or the paper's); default all.
    #[serde(default)]
    pub scenes: Vec<String>,
}

/// A bound that decides the exit code.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GateSpec {
    /// What must hold, in a sentence.
    pub text: String,
    /// The comparison that must hold, written as in [`ClaimSpec::expect`].
    pub expect: String,
    /// Scenes it is about (names of rows, or the paper's); default all.
    #[serde(default)]
    pub scenes: Vec<String>,
}

/// A number the paper printed.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// "Table 2".
    #[serde(rename = "where")]
    pub place: String,
    /// The paper's scene name.
    pub scene: String,
    /// The label of our method.
    pub method: String,
    /// For sweeps: the swept key and value it belongs to.
    #[serde(default)]
    pub at: BTreeMap<String, f64>,
    /// Column → value, for example `rmse = 0.0840`.
    pub values: BTreeMap<String, f64>,
}
