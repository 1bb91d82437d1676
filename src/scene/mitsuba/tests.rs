use std::path::Path;

use super::element::parse_document;
use super::*;

fn load(body: &str) -> SceneDescription {
    try_load(body).unwrap_or_else(|e| panic!("{e}"))
}

fn try_load(body: &str) -> Result<SceneDescription, String> {
    let text = format!(
        "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='40'/></sensor>{body}</scene>"
    );
    let file = Path::new("scenes/s.xml");
    parse_document(file, &text)
        .and_then(|document| import(&document, file, "s"))
        .map_err(|e| e.to_string())
}

#[test]
fn empty() {
    assert!(load("").shapes.is_empty());
}
