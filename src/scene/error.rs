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
        /// As it was asked for.
        name: String,
        /// Places that were searched, in words.
        looked: String,
        /// Names of the shipped scenes, with the most similar one as advice.
        known: String,
    },
    /// Neither an embedded map, nor on the search path, nor a file.
    #[error(
        "environment map `{name}` not found; looked in: {looked}. Known maps: {known}. Set LIGHTBENCH_SCENES to add folders"
    )]
    EnvironmentNotFound {
        /// As it was asked for.
        name: String,
        /// Places that were searched, in words.
        looked: String,
        /// Names of the maps, with the most similar one as advice.
        known: String,
    },
    /// A syntax or value error at a place in a text file.
    #[error("{}:{line}:{column}: {message}", file.display())]
    At {
        /// The text file.
        file: PathBuf,
        /// Counted from 1.
        line: usize,
        /// Counted from 1, in characters.
        column: usize,
        /// What is wrong, and what to do.
        message: String,
    },
    /// An error of a whole file.
    #[error("{}: {message}", file.display())]
    File {
        /// The scene, mesh, texture or map.
        file: PathBuf,
        /// What is wrong, and what to do.
        message: String,
    },
    /// The scene as a whole cannot be used.
    #[error("scene `{scene}`: {message}")]
    Scene {
        /// Its name.
        scene: String,
        /// What is wrong, and what to do.
        message: String,
    },
}
