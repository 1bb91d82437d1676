//! The reference store: images by content key, extended pass by pass.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::lock::Lock;
use crate::image::{Attributes, Image, ImageError, Layer, Samples, read_layers, write_exr};
use crate::technique::{Shot, Technique, reference_pass};
use crate::trace::RayCounter;

/// A folder of references.
#[derive(Clone, Debug)]
pub struct ReferenceStore {
    pub folder: PathBuf,
}

/// A reference image: mean over passes, and the variance of that mean.
#[derive(Clone, Debug)]
pub struct Reference {
    pub mean: Image,
    /// Sum of squared deviations of the passes from their mean, per pixel and channel.
    deviations: Image,
    /// Passes (samples per pixel) in it.
    pub samples: u32,
    /// Complete references have all the passes that were asked for.
    pub wanted: u32,
    /// Whether passes are random, so that their spread says how noisy the mean is.
    pub random: bool,
    pub non_finite: u64,
    pub seconds: f64,
    pub rays: u64,
}

impl Reference {
    fn empty(shot: &Shot, wanted: u32, random: bool) -> Self {
        Self {
            mean: Image::new(shot.width, shot.height),
            deviations: Image::new(shot.width, shot.height),
            samples: 0,
            wanted,
            random,
            non_finite: 0,
            seconds: 0.0,
            rays: 0,
        }
    }

    /// Welford's update, in f32 from the stored values, so that an interrupted reference continues
    /// to the same bits.
    fn add(&mut self, pass: &Image) {
        self.samples += 1;
        let weight = 1.0 / self.samples as f32;
        for ((mean, deviation), value) in self
            .mean
            .pixels
            .iter_mut()
            .zip(&mut self.deviations.pixels)
            .zip(&pass.pixels)
        {
            for c in 0..3 {
                let before = value[c] - mean[c];
                mean[c] += before * weight;
                deviation[c] += before * (value[c] - mean[c]);
            }
        }
    }

    /// RMSE of the reference itself: 0 for deterministic passes, `None` with fewer than two random
    /// ones.
    pub fn floor(&self) -> Option<f64> {
        if !self.random {
            return Some(0.0);
        }
        let n = f64::from(self.samples);
        let values = self.deviations.pixels.len() as f64 * 3.0;
        let sum: f64 = self
            .deviations
            .pixels
            .iter()
            .flatten()
            .map(|&d| f64::from(d))
            .sum();
        (self.samples > 1 && values > 0.0).then(|| (sum / (values * n * (n - 1.0))).sqrt())
    }

    fn write(&self, path: &Path) -> Result<(), ImageError> {
        let mut attributes = Attributes::new();
        attributes.insert("samples".into(), self.samples.into());
        attributes.insert("wanted".into(), self.wanted.into());
        attributes.insert("random".into(), self.random.into());
        attributes.insert("non_finite".into(), self.non_finite.into());
        attributes.insert("seconds".into(), self.seconds.into());
        attributes.insert("rays".into(), self.rays.into());
        let layers = [
            Layer::color("mean", self.mean.clone()),
            Layer::color("deviations", self.deviations.clone()),
        ];
        write_exr(path, &layers, &attributes)
    }

    /// Reads a stored reference.
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        let file = read_layers(path)?;
        let layer = |name: &str| match file.layer(name).map(|l| &l.samples) {
            Some(Samples::Color(image)) => Ok(image.clone()),
            _ => Err(ImageError::Decode {
                path: path.to_owned(),
                format: "reference",
                reason: format!("no layer `{name}`; delete the file to render it again"),
            }),
        };
        let number = |key: &str| {
            file.attributes
                .get(key)
                .and_then(serde_json::Value::as_f64)
                .unwrap_or(0.0)
        };
        Ok(Self {
            // The first layer of a file is its picture, without a name.
            mean: layer("")?,
            deviations: layer("deviations")?,
            samples: number("samples") as u32,
            wanted: number("wanted") as u32,
            random: file
                .attributes
                .get("random")
                .and_then(serde_json::Value::as_bool)
                .unwrap_or(true),
            non_finite: number("non_finite") as u64,
            seconds: number("seconds"),
            rays: number("rays") as u64,
        })
    }
}

impl ReferenceStore {
    /// `results/references` for `results/<name>`.
    pub fn beside(folder: &Path) -> Self {
        let parent = folder.parent().unwrap_or(Path::new("results"));
        Self {
            folder: parent.join("references"),
        }
    }

    /// The mean of a stored reference; `None` where there is none.
    pub fn mean(&self, key: &str) -> Option<Image> {
        Some(Reference::read(&self.path(key)).ok()?.mean)
    }

    pub fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{key}.exr"))
    }

    /// The complete reference of a shot: read, or rendered and stored. Unfinished ones are taken up
    /// where they were left; they are stored at most every half minute. Of several programs that want the same
    /// reference one renders it and the others wait.
    pub fn obtain(
        &self,
        key: &str,
        (technique, shot): (&dyn Technique, &Shot),
        progress: &dyn Fn(u32, u32),
    ) -> Result<Reference, ImageError> {
        let path = self.path(key);
        let wanted = technique.reference_samples(shot.spp);
        if let Some(known) = self.complete(&path, wanted)? {
            return Ok(known);
        }
        let lock = Lock::of(&path).map_err(|source| ImageError::Io {
            path: path.clone(),
            source,
        })?;
        // Another program may have completed it in the meantime.
        if let Some(known) = self.complete(&path, wanted)? {
            return Ok(known);
        }
        let mut reference = match path.exists() {
            true => Reference::read(&path)?,
            false => Reference::empty(shot, wanted, technique.reference_is_random()),
        };
        self.extend(&mut reference, (&path, wanted), (technique, shot), progress)?;
        lock.remove();
        Ok(reference)
    }

    /// A stored reference that has all its passes.
    fn complete(&self, path: &Path, wanted: u32) -> Result<Option<Reference>, ImageError> {
        if !path.exists() {
            return Ok(None);
        }
        let reference = Reference::read(path)?;
        Ok((reference.samples >= wanted).then_some(reference))
    }

    /// Adds passes until the reference has `wanted` of them.
    pub fn extend(
        &self,
        reference: &mut Reference,
        (path, wanted): (&Path, u32),
        (technique, shot): (&dyn Technique, &Shot),
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

    /// Every stored reference, by key.
    pub fn list(&self) -> io::Result<Vec<(String, PathBuf)>> {
        let mut found = Vec::new();
        if !self.folder.is_dir() {
            return Ok(found);
        }
        let at = crate::files::at(&self.folder);
        for entry in std::fs::read_dir(&self.folder).map_err(at)? {
            let path = entry.map_err(at)?.path();
            if path.extension().is_some_and(|e| e == "exr")
                && let Some(key) = path.file_stem()
            {
                found.push((key.to_string_lossy().into_owned(), path.clone()));
            }
        }
        found.sort();
        Ok(found)
    }
}
