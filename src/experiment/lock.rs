//! Locks among programs that share a folder.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Held by one program at a time; the system frees it when its holder ends, however that happens.
pub(super) struct Lock {
    /// Holds the lock while it is open.
    _file: File,
    path: PathBuf,
}

/// A folder that one program at a time writes into. The folder itself is what is locked, so nothing is left behind;
/// where folders cannot be locked (on some systems and shares) everybody gets it.
#[derive(Debug)]
pub(super) struct OwnFolder {
    _folder: Option<File>,
}

impl OwnFolder {
    /// Takes a folder that is there.
    ///
    /// # Errors
    /// [`io::ErrorKind::ResourceBusy`], at once, where another program holds it.
    pub fn take(folder: &Path) -> io::Result<Self> {
        let Ok(opened) = File::open(folder) else {
            return Ok(Self { _folder: None });
        };
        if let Err(TryLockError::WouldBlock) = opened.try_lock() {
            let message = format!(
                "{}: another run writes into this folder; wait for its end, or choose another folder with --out",
                folder.display()
            );
            return Err(io::Error::new(io::ErrorKind::ResourceBusy, message));
        }
        Ok(Self {
            _folder: Some(opened),
        })
    }
}

impl Lock {
    /// Waits until nobody else holds the lock of a file, which is a file of its own beside it.
    pub fn of(file: &Path) -> io::Result<Self> {
        let path = file.with_extension("lock");
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let opened = File::options().create(true).append(true).open(&path)?;
        opened.lock()?;
        Ok(Self {
            _file: opened,
            path,
        })
    }

    /// Ends it for good, once what it guards is complete: who waited for it then looks for that first.
    pub fn remove(self) {
        // Where another program was faster there is nothing to remove.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_holds_it_at_a_time_and_the_end_of_a_holder_frees_it() {
        let place = tempfile::tempdir().expect("a folder");
        let file = place.path().join("deep/key.exr");
        let held = Lock::of(&file).expect("locks");
        let other = File::open(file.with_extension("lock")).expect("there");
        assert!(other.try_lock().is_err(), "held");
        drop(held);
        other.try_lock().expect("free");
        drop(other);
        let again = Lock::of(&file).expect("locks again");
        again.remove();
        assert!(!file.with_extension("lock").exists());
    }

    #[test]
    fn a_folder_that_is_taken_is_refused_at_once() {
        let place = tempfile::tempdir().expect("a folder");
        let own = OwnFolder::take(place.path()).expect("free");
        let error = OwnFolder::take(place.path()).expect_err("taken");
        assert!(
            error.to_string().contains("another run writes into"),
            "{error}"
        );
        drop(own);
        OwnFolder::take(place.path()).expect("free again");
        let left = fs::read_dir(place.path()).expect("there").count();
        assert_eq!(left, 0);
    }
}
