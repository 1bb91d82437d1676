use super::ImageError;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file beside its place and renames it when complete, so that `path` never holds half a
/// file; a missing parent directory is created.
///
/// On failure the temporary file is removed and an earlier file at `path` is left as it was.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), ImageError>,
) -> Result<(), ImageError> {
    let io = |source| ImageError::io(path, source);
    if let Some(parent) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        fs::create_dir_all(parent).map_err(io)?;
    }
    let temporary = temporary_name(path)?;
    let outcome = File::create(&temporary).map_err(io).and_then(|file| {
        let mut writer = BufWriter::new(file);
        write(&mut writer)?;
        writer.flush().map_err(io)?;
        fs::rename(&temporary, path).map_err(io)
    });
    if outcome.is_err() {
        // The first error is the one to report; the temporary file may never have existed.
        let _ = fs::remove_file(&temporary);
    }
    outcome
}

fn temporary_name(path: &Path) -> Result<PathBuf, ImageError> {
    let name = path
        .file_name()
        .ok_or_else(|| ImageError::encode(path, "the path has no file name"))?;
    let mut temporary = std::ffi::OsString::from(".");
    temporary.push(name);
    temporary.push(format!(".{}.tmp", std::process::id()));
    Ok(path.with_file_name(temporary))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/a.bin");
        write_atomically(&path, |w| {
            w.write_all(b"old").map_err(|e| ImageError::io(&path, e))
        })
        .unwrap();
        let failed = write_atomically(&path, |w| {
            w.write_all(b"half").map_err(|e| ImageError::io(&path, e))?;
            Err(ImageError::encode(&path, "stopped"))
        });
        assert!(failed.unwrap_err().to_string().contains("stopped"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }
}
