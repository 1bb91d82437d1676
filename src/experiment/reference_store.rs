//! The reference store: images by content key, extended pass by pass.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::lock::Lock;
use super::reference::Reference;
use crate::image::ImageError;
use crate::standard_error::tell;
use crate::technique::{Shot, Technique, reference_pass};
use crate::trace::RayCounter;

/// Name of the folder of references, among those of experiments.
pub(super) const REFERENCES: &str = "references";

/// What the names of damaged references end in, once they are set aside.
const DAMAGED: &str = "damaged";

/// A folder of references.
#[derive(Clone, Debug)]
pub struct ReferenceStore {
    /// Holds `<key>.exr` of each reference.
    pub folder: PathBuf,
}

/// The references of a store, and the damaged ones that were set aside there.
#[derive(Clone, Debug, Default)]
pub struct Stored {
    /// Key and file, by key.
    pub references: Vec<(String, PathBuf)>,
    /// Damaged files, renamed and out of use.
    pub set_aside: Vec<PathBuf>,
}

impl ReferenceStore {
    /// `results/references` for `results/<name>`.
    pub fn beside(folder: &Path) -> Self {
        // `.` and `..` tell no parent by their names.
        let folder = match folder.file_name() {
            Some(_) => folder.to_owned(),
            None => folder.canonicalize().unwrap_or(folder.to_owned()),
        };
        let parent = folder.parent().unwrap_or(Path::new("results"));
        Self {
            folder: parent.join(REFERENCES),
        }
    }

    /// A stored reference.
    ///
    /// # Errors
    /// One that is absent or damaged; the file is named.
    pub fn read(&self, key: &str) -> Result<Reference, ImageError> {
        Reference::read(&self.path(key))
    }

    /// The file of a reference.
    pub fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{key}.exr"))
    }

    /// The complete reference of a shot: read, or rendered and stored. Unfinished ones are taken up
    /// where they were left; they are stored at most every half minute. A damaged one is set aside, with a line on standard
    /// error, and rendered again. Of several programs that want the same reference one renders it and the others wait.
    ///
    /// # Errors
    /// Files that cannot be read or written.
    pub fn obtain(
        &self,
        key: &str,
        technique: &dyn Technique,
        shot: &Shot,
        progress: &dyn Fn(u32, u32),
    ) -> Result<Reference, ImageError> {
        let path = self.path(key);
        let wanted = technique.reference_samples(shot.spp);
        let fits =
            |known: &Reference| (known.mean.width, known.mean.height) == (shot.width, shot.height);
        let is_complete = |known: &Reference| known.samples >= wanted && fits(known);
        if path.exists()
            && let Ok(known) = Reference::read(&path)
            && is_complete(&known)
        {
            return Ok(known);
        }
        let io = |source| ImageError::Io {
            path: path.clone(),
            source,
        };
        let lock = Lock::of(&path).map_err(io)?;
        // Another program may have completed it in the meantime.
        let known = match path.exists().then(|| Reference::read(&path)) {
            None => None,
            Some(Ok(known)) if fits(&known) => Some(known),
            Some(Err(error @ ImageError::Io { .. })) => return Err(error),
            Some(damaged) => {
                let why = match damaged {
                    Err(error) => error.to_string(),
                    Ok(known) => format!(
                        "{}: it has {}x{} pixels, not {}x{}",
                        path.display(),
                        known.mean.width,
                        known.mean.height,
                        shot.width,
                        shot.height
                    ),
                };
                let aside = set_aside(&path).map_err(io)?;
                tell!(
                    "warning: a reference is damaged and is rendered again: {why}; the damaged file is {} now",
                    aside.display()
                );
                None
            }
        };
        if let Some(known) = known.as_ref().filter(|known| is_complete(known)) {
            return Ok(known.clone());
        }
        let random = technique.reference_is_random();
        let mut reference = known.unwrap_or_else(|| Reference::empty(shot, wanted, random));
        self.extend(&mut reference, &path, wanted, technique, shot, progress)?;
        lock.remove();
        Ok(reference)
    }

    /// Adds passes until the reference has `wanted` of them.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn extend(
        &self,
        reference: &mut Reference,
        path: &Path,
        wanted: u32,
        technique: &dyn Technique,
        shot: &Shot,
        progress: &dyn Fn(u32, u32),
    ) -> Result<(), ImageError> {
        reference.wanted = wanted;
        let mut stored = Instant::now();
        let function = technique.shading_function(shot);
        while reference.samples < wanted {
            progress(reference.samples, wanted);
            let start = Instant::now();
            let counter = RayCounter::default();
            let (pass, non_finite) =
                reference_pass(function.as_ref(), shot, reference.samples, &counter);
            reference.add(&pass);
            reference.non_finite += non_finite;
            reference.seconds += start.elapsed().as_secs_f64();
            reference.rays += counter.read().closest + counter.read().shadow;
            if reference.samples == wanted || stored.elapsed() > Duration::from_secs(30) {
                reference.write(path)?;
                stored = Instant::now();
            }
        }
        progress(reference.samples, wanted);
        Ok(())
    }

    /// Everything in the folder, sorted; nothing where there is none.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn list(&self) -> io::Result<Stored> {
        let mut found = Stored::default();
        if !self.folder.is_dir() {
            return Ok(found);
        }
        let at = crate::files::at(&self.folder);
        for entry in std::fs::read_dir(&self.folder).map_err(at)? {
            let path = entry.map_err(at)?.path();
            let ending = path.extension().unwrap_or_default().to_string_lossy();
            if ending == "exr"
                && let Some(key) = path.file_stem()
            {
                let key = key.to_string_lossy().into_owned();
                found.references.push((key, path));
            } else if ending.starts_with(DAMAGED) {
                found.set_aside.push(path);
            }
        }
        found.references.sort();
        found.set_aside.sort();
        Ok(found)
    }
}

/// Renames a damaged file, so that nothing reads it and nothing is lost; its new name.
fn set_aside(path: &Path) -> io::Result<PathBuf> {
    let names = std::iter::once(DAMAGED.to_owned())
        .chain((2..).map(|number: u64| format!("{DAMAGED}-{number}")));
    for ending in names {
        let mut name: OsString = path.as_os_str().to_owned();
        name.push(format!(".{ending}"));
        let aside = PathBuf::from(name);
        if !aside.exists() {
            std::fs::rename(path, &aside)?;
            return Ok(aside);
        }
    }
    Err(io::Error::other("no name is free for the damaged file"))
}
