//! From a config to rows: overrides, plan, run, store, claims and gates.

mod budget;
mod case;
mod cases;

mod check;
mod claim;
mod columns;
mod config;
mod equal_time;
mod expression;
mod identity;
mod light_files;
mod locate;
mod overrides;
mod panics;
mod plan;
mod progress;
mod provenance;
mod reference;
mod row;
mod run;
mod scale;
mod scenes;
mod store;
mod suite;

pub use budget::Budget;
pub use case::{Case, NamedPlace, Place, Swept};
pub use cases::{Cases, RowNote};
pub use claim::{EVERY_SCENE, Judged, Verdict, judge, overall};
pub use columns::{COLUMNS, Cells, Column, ColumnEntry, FOUND, Unit};
pub use config::{
    ClaimSpec, Config, ConfigError, FigureKind, FigureSpec, GateSpec, OneOrMore, Published,
    SceneChoice, SceneTransform, Source, TableKind, TableSpec, line_column,
};
pub use equal_time::FOUND as LIGHTS_IN_TIME;
pub use expression::{Expression, Measured};
pub use identity::{hash, scene_key};
pub use light_files::{LIGHTS_FILE, LightFile, MAP_FILE};
pub use overrides::Override;
pub use plan::{Job, Plan, plan};
pub use provenance::{Provenance, kernel, machine, program};
pub use reference::{Reference, ReferenceStore};
pub use row::{Row, to_csv};
pub use run::{Outcome, RunError, RunOptions, build_technique, load_world, run, shot_of};
pub use scale::Scale;
pub use store::Store;
pub use suite::{Member, Suite};
