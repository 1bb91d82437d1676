//! From a config to rows: overrides, plan, run, store, claims and gates.

mod budget;
mod case;
mod cases;
mod caught;
mod check;
mod claim;
mod columns;
mod config;
mod equal_time;
mod expression;
mod light_files;
mod locate;
mod overrides;
mod plan;
mod progress;
mod provenance;
mod reference;
mod row;
mod run;
mod scale;
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
pub use light_files::{LIGHTS_FILE, LightFile, MAP_FILE};
pub use overrides::Override;
pub use plan::{Job, Plan, hash, plan};
pub use reference::{Reference, ReferenceStore};
pub use row::{Row, to_csv};
pub use run::{
    Outcome, RunError, RunOptions, build_method, build_technique, frame_of, load_scene, run,
};
pub use scale::Scale;
pub use store::Store;
pub use suite::{Member, Suite};

use crate::scene::{EnvironmentDescription, SceneDescription, ShapeSource};

/// A hash of everything a scene declares and of the sizes of the files it names, the same wherever
/// the scene's folder lies.
pub fn scene_key(description: &SceneDescription) -> String {
    let mut text = format!("{description:?}");
    if let Some(folder) = description.file.as_ref().and_then(|f| f.parent()) {
        text = text.replace(&format!("{}/", folder.display()), "");
    }
    if let Some(EnvironmentDescription::Map { path, .. }) = &description.environment {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let bytes = std::fs::metadata(path).map_or(0, |m| m.len());
        text = text.replace(&format!("{path:?}"), &format!("{name} {bytes}"));
    }
    for shape in &description.shapes {
        if let ShapeSource::Obj { path, .. }
        | ShapeSource::Ply { path }
        | ShapeSource::Serialized { path, .. } = &shape.source
        {
            let bytes = std::fs::metadata(path).map_or(0, |m| m.len());
            text.push_str(&format!(" {bytes}"));
        }
    }
    hash(&text)
}
