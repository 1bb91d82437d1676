//! Why an image cannot be read or written.

use std::path::{Path, PathBuf};

/// Why an image could not be read or written; every text names the file.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The operating system refused to open, read or write the file.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The first bytes belong to none of the formats that are read.
    #[error("{path}: neither EXR, Radiance HDR, PNG nor JPEG (told by the first bytes, not by the name){}", kind.map_or(String::new(), |kind| format!("; {kind}")), path = path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// What it is in place of these, if that is known.
        kind: Option<&'static str>,
    },
    /// The file is damaged, cut short, or uses a feature that is not read.
    #[error("{path}: cannot decode this {format} file: {reason}", path = path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// Name of the format that its first bytes told.
        format: &'static str,
        /// What the decoder says.
        reason: String,
    },
    /// The file is sound but holds no picture that can be used as RGB.
    #[error("{path}: no RGB or luminance channels; found: {found}", path = path.display())]
    NoColor {
        /// The file.
        path: PathBuf,
        /// The channels it has, in words.
        found: String,
    },
    /// The file has no layer of the name that was asked for.
    #[error("{path}: no layer is called `{layer}`; found: {found}", path = path.display())]
    NoLayer {
        /// The file.
        path: PathBuf,
        /// The name that was asked for.
        layer: String,
        /// The layers it has, in words.
        found: String,
    },
    /// Several layers could be the picture.
    #[error("{path}: several layers could be meant: {found}; name one, for example {path}#{first}", path = path.display())]
    SeveralLayers {
        /// The file.
        path: PathBuf,
        /// The layers it has, in words.
        found: String,
        /// One of them, for the advice.
        first: String,
    },
    /// More pixels than `MAX_PIXELS`: a damaged header rather than a picture.
    #[error("{path}: {width}x{height} pixels are more than the {limit} that are read", path = path.display(), limit = MAX_PIXELS)]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Pixels, as the header says.
        width: usize,
        /// Pixels, as the header says.
        height: usize,
    },
    /// The picture could not be encoded.
    #[error("{path}: cannot write: {reason}", path = path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What the encoder says.
        reason: String,
    },
}

/// The largest number of pixels that is read from a file (16384 x 16384).
pub(super) const MAX_PIXELS: usize = 1 << 28;

impl ImageError {
    pub(super) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            source,
        }
    }

    pub(super) fn decode(path: &Path, format: &'static str, reason: impl ToString) -> Self {
        Self::Decode {
            path: path.to_owned(),
            format,
            reason: reason.to_string(),
        }
    }

    pub(super) fn encode(path: &Path, reason: impl ToString) -> Self {
        Self::Encode {
            path: path.to_owned(),
            reason: reason.to_string(),
        }
    }

    /// What is wrong, for messages that name the file themselves.
    pub fn without_path(&self) -> String {
        let (Self::Io { path, .. }
        | Self::UnknownFormat { path, .. }
        | Self::Decode { path, .. }
        | Self::NoColor { path, .. }
        | Self::NoLayer { path, .. }
        | Self::SeveralLayers { path, .. }
        | Self::TooLarge { path, .. }
        | Self::Encode { path, .. }) = self;
        let text = self.to_string();
        let head = format!("{}: ", path.display());
        text.strip_prefix(&head).unwrap_or(&text).to_owned()
    }
}
