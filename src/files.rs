//! Files that are whole or not there: written beside their place and renamed when complete, and read only where they end.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file through a temporary name beside it, so that `path` never holds half a file; a
/// missing parent folder is created. `fail` wraps the errors of the system.
///
/// A link stays: the file that it names is written. What is neither file nor folder, such as a pipe or `/dev/stdout`, is
/// written to and not replaced.
///
/// # Errors
/// Those of `write` and of the system. The temporary file is removed then, and an earlier file at
/// `path` is left as it was.
pub fn write_with<E>(
    path: &Path,
    fail: impl Fn(io::Error) -> E,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), E> {
    if fs::metadata(path).is_ok_and(|known| !known.is_file() && !known.is_dir()) {
        let mut writer = BufWriter::new(File::create(path).map_err(&fail)?);
        write(&mut writer)?;
        return writer.flush().map_err(&fail);
    }
    let is_link = fs::symlink_metadata(path).is_ok_and(|known| known.is_symlink());
    let named = is_link.then(|| fs::canonicalize(path).ok()).flatten();
    let path = named.as_deref().unwrap_or(path);
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

/// Reads all of a file.
///
/// # Errors
/// Those of the system, and of [`check_ends`].
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    check_ends(path)?;
    fs::read(path)
}

/// Refuses pipes, sockets and devices, which may give bytes without end, or none for ever.
///
/// # Errors
/// What it is, and what to do. (That there is nothing, or a folder, is told when it is read.)
pub fn check_ends(path: &Path) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(known) if !known.is_file() && !known.is_dir() => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "this is a pipe or a device, not a file: save what it gives to a file, and name that",
        )),
        _ => Ok(()),
    }
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

    #[cfg(unix)]
    #[test]
    fn links_and_devices_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let [file, link] = ["a.txt", "link"].map(|name| folder.path().join(name));
        write(&file, "old").expect("writable");
        std::os::unix::fs::symlink(&file, &link).expect("a link");
        write(&link, "new").expect("writable");
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
        assert_eq!(fs::read(&file).expect("there"), b"new");
        // A link to a device, since who may replace files in /dev would do so where this fails.
        let device = folder.path().join("device");
        std::os::unix::fs::symlink("/dev/null", &device).expect("a link");
        write(&device, "new").expect("writable");
        assert!(fs::symlink_metadata(&device).expect("there").is_symlink());
        assert_eq!(fs::read(&device).expect("there"), b"");
        assert_eq!(fs::read_dir(folder.path()).expect("there").count(), 3);
    }

    #[cfg(unix)]
    #[test]
    fn what_may_not_end_is_not_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("a.txt");
        write(&file, "text").expect("writable");
        assert_eq!(read(&file).expect("there"), b"text");
        let device = folder.path().join("zeros");
        std::os::unix::fs::symlink("/dev/zero", &device).expect("a link");
        for path in [Path::new("/dev/zero"), &device] {
            let error = read(path).expect_err("endless");
            assert!(error.to_string().contains("not a file"), "{error}");
        }
        let absent = read(&folder.path().join("b")).expect_err("absent");
        assert_eq!(absent.kind(), io::ErrorKind::NotFound);
    }

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
