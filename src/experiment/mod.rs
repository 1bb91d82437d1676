//! From a config to rows: overrides, plan, run, store, claims and gates.

mod afford;
mod arrays;
mod budget;
mod case;
mod cases;

mod check;
mod claim;
mod columns;
mod config;
#[cfg(test)]
mod config_page;
mod darkness;
mod expression;
mod foresee;
mod identity;
mod image;
mod known_names;
mod light_files;
mod limits;
mod loaded;
mod locate;
mod lock;
mod named;
mod overrides;
mod panics;
mod pictures;
mod plan;
mod play;
mod progress;
mod provenance;
mod reference;
mod reference_store;
mod remaining;
mod reported;
mod row;
mod run;
mod scale;
mod scenes;
mod sequence;
mod shipped;
mod store;
mod suite;
mod sweep;
mod truths;

pub use afford::FOUND as AFFORDABLE;
pub use budget::Budget;
pub use case::{Case, NamedPlace, Place, Swept};
pub use cases::{Cases, RowNote};
pub use claim::{EVERY_SCENE, Judged, Verdict, judge, overall};
pub use columns::{COLUMNS, Cells, Column, ColumnEntry, FOUND, Unit, is_declared};
pub use config::{
    Config, ConfigError, OneOrMore, SceneChoice, SceneTransform, Source, line_column,
};
pub use expression::{Expression, Measured};
pub use foresee::{JobMemory, foresee};
pub use identity::{hash, scene_key};
pub use image::{EXACT, exact, plan_image, render_job};
pub use light_files::{LIGHTS_FILE, LightFile, MAP_FILE};
pub(crate) use limits::check_folder_name;
pub use loaded::{Loaded, build_technique};
pub use overrides::Override;
pub use plan::{Job, Plan, plan};
pub use provenance::{Provenance, kernel, machine, program};
pub use reference::Reference;
pub use reference_store::{ReferenceStore, Stored};
pub use reported::{ClaimSpec, FigureKind, FigureSpec, GateSpec, Published, TableKind, TableSpec};
pub use row::{Row, SEARCH_STAGE, to_csv};
pub use run::{Outcome, RunError, RunOptions, run};
pub use scale::Scale;
pub use scenes::Additions;
pub use sequence::{
    FrameRecord, Frames, Keep, KeepWord, Sequence, SequenceSpec, Viewer, ViewerRule, ViewersSpec,
    frame_column, spread,
};
pub use shipped::shipped_configs;
pub use store::{Store, described};
pub use suite::{Member, Suite};
