//! Where a sequence goes on after it was interrupted.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{FrameRecord, Thumbnail};
use crate::experiment::program;
use crate::image::Image;

/// All that the rest of a sequence depends on, after some of its frames.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Checkpoint {
    /// How many frames are done.
    pub done: usize,
    /// Of the frames that are done, viewer by viewer.
    pub frames: Vec<FrameRecord>,
    /// Error images of the last frame, by viewer; empty if that was not measured.
    pub errors: Vec<Image>,
    pub thumbnails: Vec<Thumbnail>,
    /// Records, lights or samples, where a budget that is spent had to be turned into a count.
    pub count: Option<u64>,
    /// What the contender remembers.
    pub memory: Vec<u8>,
}

impl Checkpoint {
    fn path(folder: &Path) -> PathBuf {
        folder.join("checkpoint.bin")
    }

    /// The checkpoint of a folder; the beginning where there is none that this program wrote and can read.
    pub fn read(folder: &Path) -> Self {
        let bytes = fs::read(Self::path(folder)).unwrap_or_default();
        let rest = bytes.strip_prefix(Self::mark().as_bytes());
        let read = rest.and_then(|rest| postcard::from_bytes(rest).ok());
        read.unwrap_or_default()
    }

    /// Writes it, whole or not at all.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        let mark = Self::mark().into_bytes();
        let bytes = postcard::to_extend(self, mark).map_err(io::Error::other)?;
        crate::files::write(&Self::path(folder), bytes)
    }

    /// What files begin with: another program may have other fields and other methods.
    fn mark() -> String {
        format!("{}\n", program())
    }

    /// Removes it from a folder that is complete.
    pub fn remove(folder: &Path) -> io::Result<()> {
        match fs::remove_file(Self::path(folder)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checkpoints_come_back_to_the_bit_and_torn_ones_are_beginnings() {
        let place = tempfile::tempdir().expect("a folder");
        let mut checkpoint = Checkpoint {
            done: 3,
            errors: vec![Image::new(2, 1)],
            memory: vec![1, 2, 3],
            ..Checkpoint::default()
        };
        checkpoint.errors[0].pixels[1] = [1e-40, -0.0, f32::MAX];
        checkpoint.frames.push(FrameRecord {
            time_s: 0.1 + 0.2,
            ..FrameRecord::default()
        });
        checkpoint.write(place.path()).expect("writable");
        let read = Checkpoint::read(place.path());
        assert_eq!(format!("{read:?}"), format!("{checkpoint:?}"));
        let file = Checkpoint::path(place.path());
        let bytes = fs::read(&file).expect("there");
        fs::write(&file, &bytes[..bytes.len() - 1]).expect("writable");
        assert_eq!(Checkpoint::read(place.path()).done, 0);
        let other = [b"another ".as_slice(), &bytes].concat();
        fs::write(&file, other).expect("writable");
        assert_eq!(Checkpoint::read(place.path()).done, 0);
        Checkpoint::remove(place.path()).expect("removed");
        Checkpoint::remove(place.path()).expect("nothing to remove");
    }
}
