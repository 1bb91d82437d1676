//! `scene.toml`.
use super::{SceneDescription, SceneError};
use std::path::Path;
pub(super) fn load_toml(file: &Path, _name: &str) -> Result<SceneDescription, SceneError> {
    Err(super::text::file_error(file, "not yet"))
}
pub(super) fn parse_toml(
    _text: &str,
    _file: Option<&Path>,
    _name: &str,
) -> Result<SceneDescription, SceneError> {
    Err(super::text::file_error(Path::new(""), "not yet"))
}
