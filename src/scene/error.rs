//! What can be wrong with a scene, with the advice in the text.

use std::path::PathBuf;

/// A scene that cannot be used. `Display` is `file:line:column: what; what to do` where known.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Neither a shipped scene, nor on the search path, nor a file.
    #[error(
        "scene `{name}` not found; looked in: {looked}. Shipped scenes: {known}. Set LIGHTBENCH_SCENES to add folders"
    )]
    NotFound {
        name: String,
        looked: String,
        known: String,
    },
    /// Neither an embedded map, nor on the search path, nor a file.
    #[error(
        "environment map `{name}` not found; looked in: {looked}. Known maps: {known}. Set LIGHTBENCH_SCENES to add folders"
    )]
    EnvironmentNotFound {
        name: String,
        looked: String,
        known: String,
    },
    /// A syntax or value error at a place in a text file.
    #[error("{}:{line}:{column}: {message}", file.display())]
    At {
        file: PathBuf,
        line: usize,
        column: usize,
        message: String,
    },
    /// An error of a whole file.
    #[error("{}: {message}", file.display())]
    File { file: PathBuf, message: String },
    /// The scene as a whole cannot be used.
    #[error("scene `{scene}`: {message}")]
    Scene { scene: String, message: String },
}
