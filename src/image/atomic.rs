//! Image files that are whole or not there.

use super::ImageError;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Writes an image file whole or not at all, as `crate::files::write_with` does.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), ImageError>,
) -> Result<(), ImageError> {
    crate::files::write_with(path, |source| ImageError::io(path, source), write)
}
