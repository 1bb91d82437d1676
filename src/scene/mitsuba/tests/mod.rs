//! Scenes of Mitsuba, by topic; and what the topics share.

mod cameras;
mod lights;
mod materials;
mod messages;
mod shapes;

use glam::{DMat4, DVec3};

use super::parse::parse_document;
use super::*;
use crate::environment::{EnvironmentDescription, EnvironmentRows};
use crate::scene::{
    Bsdf, ColourSource, FovAxis, LightKind, MicrofacetDistribution, ShapeSource, TextureSource,
    View, Wrap,
};

const SENSOR: &str = "<sensor type='perspective'><float name='fov' value='40'/></sensor>";

fn try_load(version: &str, body: &str) -> Result<SceneDescription, String> {
    let text = format!("<scene version='{version}'>{body}\n</scene>");
    let file = Path::new("dir/s.xml");
    parse_document(file, &text)
        .and_then(|document| import(&document, file, "s"))
        .map_err(|e| e.to_string())
}

fn load(version: &str, body: &str) -> SceneDescription {
    try_load(version, &format!("{SENSOR}{body}")).unwrap_or_else(|e| panic!("{e}"))
}

fn error(body: &str) -> String {
    match try_load("3.0.0", body) {
        Ok(_) => panic!("should fail: {body}"),
        Err(message) => message,
    }
}

/// The material of a shape with this bsdf inside.
fn material(version: &str, bsdf: &str) -> (Material, Vec<String>) {
    let scene = load(version, &format!("<shape type='cube'>{bsdf}</shape>"));
    (
        scene.materials[scene.shapes[0].material].clone(),
        scene.notes,
    )
}

fn camera(body: &str) -> View {
    let sensor = format!("<sensor type='perspective'>{body}</sensor>");
    try_load("3.0.0", &sensor)
        .unwrap_or_else(|e| panic!("{e}"))
        .views
        .remove(0)
}
