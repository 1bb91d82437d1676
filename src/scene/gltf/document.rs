//! A parsed glTF file, shared by everything that is read from it.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use ::gltf::json::{Root, buffer, image, validation};

use super::container::{Container, split};
use super::parse::parse_root;
use super::uri::{Uri, parse_uri};
use crate::other_kind::other_kind;
use crate::scene::SceneError;
use crate::scene::text::file_error;

/// A glTF file whose structure has been checked. Clones are the same file.
///
/// Its buffers are in memory as long as somebody holds what `buffers` gave, no longer.
#[derive(Clone)]
pub struct GltfFile(Arc<Document>);

struct Document {
    path: PathBuf,
    root: Root,
    buffers: Mutex<Weak<Buffers>>,
}

/// The bytes of the buffers of a file.
pub(crate) struct Buffers(Vec<Vec<u8>>);

impl std::fmt::Debug for GltfFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("GltfFile").field(&self.0.path).finish()
    }
}

impl PartialEq for GltfFile {
    fn eq(&self, other: &Self) -> bool {
        self.0.path == other.0.path
    }
}

impl GltfFile {
    /// Reads the JSON of a file; no buffer or image is opened.
    pub(super) fn parse(path: &Path) -> Result<Self, SceneError> {
        let bytes = crate::files::read(path).map_err(|e| file_error(path, e.to_string()))?;
        Self::parse_bytes(path, &bytes)
    }

    /// [`GltfFile::parse`] of the bytes of the file.
    pub(super) fn parse_bytes(path: &Path, bytes: &[u8]) -> Result<Self, SceneError> {
        if let Some(kind) = other_kind(bytes) {
            return Err(file_error(path, format!("this is no scene: {kind}")));
        }
        let container = split(bytes).map_err(|message| file_error(path, message))?;
        let document = Document {
            path: path.to_owned(),
            root: parse_root(path, container.json)?,
            buffers: Mutex::default(),
        };
        Ok(Self(Arc::new(document)))
    }

    /// The `.gltf` or `.glb` file.
    pub fn path(&self) -> &Path {
        &self.0.path
    }

    /// The file and the files of its buffers.
    pub fn files(&self) -> Vec<PathBuf> {
        let uris = self.root().buffers.iter().filter_map(|b| b.uri.as_deref());
        let files = uris.filter_map(|uri| match parse_uri(uri, self.folder()) {
            Ok(Uri::File(path)) => Some(path),
            _ => None,
        });
        std::iter::once(self.0.path.clone()).chain(files).collect()
    }

    pub(super) fn root(&self) -> &Root {
        &self.0.root
    }

    /// What URIs are relative to.
    pub(super) fn folder(&self) -> &Path {
        self.0.path.parent().unwrap_or(Path::new(""))
    }

    /// An error at a place in the file.
    pub(super) fn error(&self, place: impl Display, message: impl Display) -> SceneError {
        file_error(&self.0.path, format!("{place}: {message}"))
    }

    /// The buffers, read when nobody holds them.
    pub(crate) fn buffers(&self) -> Result<Arc<Buffers>, SceneError> {
        let mut known = self
            .0
            .buffers
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(buffers) = known.upgrade() {
            return Ok(buffers);
        }
        let buffers = Arc::new(self.read_buffers()?);
        *known = Arc::downgrade(&buffers);
        Ok(buffers)
    }

    fn read_buffers(&self) -> Result<Buffers, SceneError> {
        let declared = self.root().buffers.iter().enumerate();
        let read = declared.map(|(i, buffer)| {
            let place = named("buffer", i, buffer.name.as_deref());
            let fail = |message: String| self.error(&place, message);
            let bytes = match &buffer.uri {
                Some(uri) => self.bytes_of(uri).map_err(fail)?,
                None => self.binary_chunk(i).map_err(fail)?,
            };
            let needed = buffer.byte_length.0;
            match bytes.len() as u64 >= needed {
                true => Ok(bytes),
                false => Err(fail(format!(
                    "has {} bytes, {needed} are declared",
                    bytes.len()
                ))),
            }
        });
        read.collect::<Result<_, _>>().map(Buffers)
    }

    /// The bytes behind a URI, or what is wrong with it.
    pub(super) fn bytes_of(&self, uri: &str) -> Result<Vec<u8>, String> {
        match parse_uri(uri, self.folder())? {
            Uri::Data(bytes) => Ok(bytes),
            Uri::File(path) => {
                crate::files::read(&path).map_err(|e| format!("{}: {e}", path.display()))
            }
        }
    }

    fn binary_chunk(&self, buffer: usize) -> Result<Vec<u8>, String> {
        let bytes = match buffer {
            0 => crate::files::read(self.path()).map_err(|e| e.to_string())?,
            _ => Vec::new(),
        };
        let Ok(Container {
            binary: Some(binary),
            ..
        }) = split(&bytes)
        else {
            return Err("has no `uri`, and the file has no binary chunk for it".into());
        };
        Ok(binary.to_vec())
    }

    /// The bytes of an image that is not a file of its own.
    pub(crate) fn image_bytes(&self, image: usize) -> Result<Vec<u8>, SceneError> {
        let declared = self.root().images.get(image);
        let place = named("image", image, declared.and_then(|i| i.name.as_deref()));
        match declared {
            Some(image::Image {
                buffer_view: Some(view),
                ..
            }) => {
                let buffers = self.buffers()?;
                let bytes = self
                    .view(&buffers, view.value())
                    .map_err(|e| self.error(&place, e))?;
                Ok(bytes.to_vec())
            }
            Some(image::Image { uri: Some(uri), .. }) => {
                self.bytes_of(uri).map_err(|e| self.error(&place, e))
            }
            _ => Err(self.error(place, "has neither a `uri` nor a `bufferView`")),
        }
    }

    /// The bytes of a buffer view.
    pub(super) fn view<'b>(&self, buffers: &'b Buffers, index: usize) -> Result<&'b [u8], String> {
        let view = self.declared_view(index)?;
        let place = named("buffer view", index, view.name.as_deref());
        let buffer = buffers.0.get(view.buffer.value()).ok_or_else(|| {
            format!(
                "{place} names buffer {}, which is not there",
                view.buffer.value()
            )
        })?;
        let start = view.byte_offset.map_or(0, |offset| offset.0);
        let length = view.byte_length.0;
        let range = usize::try_from(start).ok().zip(
            start
                .checked_add(length)
                .and_then(|end| usize::try_from(end).ok()),
        );
        range
            .and_then(|(start, end)| buffer.get(start..end))
            .ok_or_else(|| {
                format!(
                    "{place} reaches from byte {start} over {length} bytes, buffer {} has {}",
                    view.buffer.value(),
                    buffer.len()
                )
            })
    }

    pub(super) fn declared_view(&self, index: usize) -> Result<&buffer::View, String> {
        let views = &self.root().buffer_views;
        views
            .get(index)
            .ok_or_else(|| format!("buffer view {index} is not there"))
    }
}

/// How messages call a part of a file: its kind, its index and its name.
pub(super) fn named(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} `{name}`"),
        _ => format!("{kind} {index}"),
    }
}

/// The value of a word or code of the file, if it is one of those that glTF knows.
pub(super) fn valid<T: Copy>(value: &validation::Checked<T>) -> Option<T> {
    match value {
        validation::Checked::Valid(value) => Some(*value),
        validation::Checked::Invalid => None,
    }
}
