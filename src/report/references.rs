//! References as reports read them, and why some are not there.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::experiment::ReferenceStore;
use crate::image::{Image, ImageError};

/// The store beside a results folder.
pub struct References {
    store: ReferenceStore,
    folder: PathBuf,
    /// Why references could not be shown, a sentence each.
    lost: Mutex<BTreeSet<String>>,
}

impl References {
    /// Those of a results folder.
    pub fn of(folder: &Path) -> Self {
        Self {
            store: ReferenceStore::beside(folder),
            folder: folder.to_owned(),
            lost: Mutex::default(),
        }
    }

    /// The mean of a reference; `None`, with a note, where it is absent or damaged.
    pub fn mean(&self, key: &str) -> Option<Image> {
        match self.store.read(key) {
            Ok(reference) => Some(reference.mean),
            Err(error) => {
                let why = match &error {
                    ImageError::Io { .. } => format!("a reference cannot be read: {error}"),
                    _ => format!("a reference is damaged: {error}"),
                };
                let advice = format!(
                    "what shows it is left out; `lightbench ref extend {}` renders it again",
                    self.folder.display()
                );
                let mut lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
                lost.insert(format!("{why}; {advice}"));
                None
            }
        }
    }

    /// A sentence about each reference that was asked for in vain.
    pub fn notes(&self) -> Vec<String> {
        let lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
        lost.iter().cloned().collect()
    }
}
