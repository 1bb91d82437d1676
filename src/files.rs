//! Files that are whole or not there: written beside their place and renamed when complete.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file through a temporary name beside it, so that `path` never holds half a file; a
/// missing parent folder is created. `fail` wraps the errors of the system.
///
/// # Errors
/// Those of `write` and of the system. The temporary file is removed then, and an earlier file at
/// `path` is left as it was.
pub fn write_with<E>(
    path: &Path,
    fail: impl Fn(io::Error) -> E,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), E> {
    if let Some(parent) = path.parent().filter(|p| !p.as_os_str().is_empty()) {
        fs::create_dir_all(parent).map_err(&fail)?;
    }
    let temporary = temporary_name(path).map_err(&fail)?;
    let outcome = File::create(&temporary).map_err(&fail).and_then(|file| {
        let mut writer = BufWriter::new(file);
        write(&mut writer)?;
        writer.flush().map_err(&fail)?;
        fs::rename(&temporary, path).map_err(&fail)
    });
    if outcome.is_err() {
        // The first error is the one to report; the temporary file may never have existed.
        let _ = fs::remove_file(&temporary);
    }
    outcome
}

/// As [`write_with`], of contents that are there; errors name the path.
pub fn write(path: &Path, contents: impl AsRef<[u8]>) -> io::Result<()> {
    write_with(path, at(path), |writer| {
        writer.write_all(contents.as_ref()).map_err(at(path))
    })
}

/// Puts the path that it is about into an error of the system, which does not name it.
pub fn at(path: &Path) -> impl Fn(io::Error) -> io::Error + Copy + '_ {
    move |error| io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

fn temporary_name(path: &Path) -> io::Result<PathBuf> {
    let name = path
        .file_name()
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the path has no file name"))?;
    let mut temporary = OsString::from(".");
    temporary.push(name);
    temporary.push(format!(".{}.tmp", std::process::id()));
    Ok(path.with_file_name(temporary))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_keeps_the_old_file_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("deep/a.bin");
        write(&path, "old").expect("writable");
        let failed = write_with(
            &path,
            |e| e.to_string(),
            |w| {
                w.write_all(b"half").map_err(|e| e.to_string())?;
                Err("stopped".to_owned())
            },
        );
        assert_eq!(failed, Err("stopped".into()));
        assert_eq!(fs::read(&path).expect("kept"), b"old");
        let parent = path.parent().expect("a folder");
        assert_eq!(fs::read_dir(parent).expect("readable").count(), 1);
        let refused = write(folder.path(), "x").expect_err("a folder is there");
        assert!(
            refused
                .to_string()
                .contains(&folder.path().display().to_string())
        );
    }
}
