//! A reference image, and the file that it is stored in.

use std::path::Path;

use serde_json::Value;

use crate::image::{Attributes, Image, ImageError, Layer, Samples, read_layers, write_exr};
use crate::technique::Shot;

/// The attribute with the checksum of everything else that is read of a file.
const CHECKSUM: &str = "blake3";

/// A reference image: mean over passes, and the variance of that mean.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Linear RGB, over the passes.
    pub mean: Image,
    /// Sum of squared deviations of the passes from their mean, per pixel and channel.
    deviations: Image,
    /// Passes (samples per pixel) in it.
    pub samples: u32,
    /// Complete references have all the passes that were asked for.
    pub wanted: u32,
    /// Whether passes are random, so that their spread says how noisy the mean is.
    pub random: bool,
    /// Samples that were kept out of the passes.
    pub non_finite: u64,
    /// Wall time that its passes took, over all runs that extended it.
    pub seconds: f64,
    /// Closest-hit and any-hit rays of its passes.
    pub rays: u64,
}

impl Reference {
    /// One without passes.
    pub(super) fn empty(shot: &Shot, wanted: u32, random: bool) -> Self {
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
    pub(super) fn add(&mut self, pass: &Image) {
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

    /// Stores it with the checksum of what it says.
    pub(super) fn write(&self, path: &Path) -> Result<(), ImageError> {
        let mut attributes = Attributes::new();
        attributes.insert("samples".into(), self.samples.into());
        attributes.insert("wanted".into(), self.wanted.into());
        attributes.insert("random".into(), self.random.into());
        attributes.insert("non_finite".into(), self.non_finite.into());
        attributes.insert("seconds".into(), self.seconds.into());
        attributes.insert("rays".into(), self.rays.into());
        attributes.insert(CHECKSUM.into(), self.checksum().into());
        let layers = [
            Layer::color("mean", self.mean.clone()),
            Layer::color("deviations", self.deviations.clone()),
        ];
        write_exr(path, &layers, &attributes)
    }

    /// Hash of the values that a file gives, whatever its bytes are. Seconds count as f32, because decimal digits may give
    /// back the last bit of an f64 differently.
    fn checksum(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for image in [&self.mean, &self.deviations] {
            for side in [image.width, image.height] {
                hasher.update(&(side as u64).to_le_bytes());
            }
            for row in image.pixels.chunks(image.width.max(1)) {
                let values = row.iter().flatten();
                let bytes: Vec<u8> = values.flat_map(|value| value.to_le_bytes()).collect();
                hasher.update(&bytes);
            }
        }
        for count in [self.samples, self.wanted, u32::from(self.random)] {
            hasher.update(&count.to_le_bytes());
        }
        for count in [self.non_finite, self.rays] {
            hasher.update(&count.to_le_bytes());
        }
        hasher.update(&(self.seconds as f32).to_le_bytes());
        hasher.finalize().to_hex().to_string()
    }

    /// Reads a stored reference and compares it with its checksum. Files of versions that wrote none are verified as far
    /// as they tell: the format, both layers, all attributes.
    ///
    /// # Errors
    /// [`ImageError::Io`] where the file cannot be read; anything else says that it is damaged.
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        let file = read_layers(path)?;
        let damaged = |reason: String| ImageError::Decode {
            path: path.to_owned(),
            format: "reference",
            reason,
        };
        let layer = |name: &str| match file.layer(name).map(|l| &l.samples) {
            Some(Samples::Color(image)) => Ok(image.clone()),
            _ => Err(damaged(format!("it has no layer `{name}`"))),
        };
        let attribute = |key: &str| {
            let missing = || damaged(format!("it does not say its `{key}`"));
            file.attributes.get(key).ok_or_else(missing)
        };
        let unfit = |key: &str| damaged(format!("its `{key}` is not what passes give"));
        let whole = |key: &str| attribute(key)?.as_u64().ok_or_else(|| unfit(key));
        let count = |key: &str| u32::try_from(whole(key)?).map_err(|_| unfit(key));
        let reference = Self {
            // The first layer of a file is its picture, without a name.
            mean: layer("")?,
            deviations: layer("deviations")?,
            samples: count("samples")?,
            wanted: count("wanted")?,
            random: attribute("random")?
                .as_bool()
                .ok_or_else(|| unfit("random"))?,
            non_finite: whole("non_finite")?,
            seconds: attribute("seconds")?
                .as_f64()
                .ok_or_else(|| unfit("seconds"))?,
            rays: whole("rays")?,
        };
        if reference.samples == 0 {
            return Err(unfit("samples"));
        }
        match file.attributes.get(CHECKSUM).map(Value::as_str) {
            None => Ok(reference),
            Some(stored) if stored == Some(reference.checksum().as_str()) => Ok(reference),
            Some(_) => Err(damaged("its values are not those of its checksum".into())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference() -> Reference {
        let mut reference = Reference {
            mean: Image::new(7, 5),
            deviations: Image::new(7, 5),
            samples: 0,
            wanted: 4,
            random: true,
            non_finite: 3,
            seconds: 0.1 + 0.2,
            rays: u64::MAX - 1,
        };
        for pass in 0..4u32 {
            let pixels =
                (0..35u32).map(|i| [0, 1, 2].map(|c| ((i * 7 + c + pass * 31) % 97) as f32));
            reference.add(&Image {
                width: 7,
                height: 5,
                pixels: pixels.collect(),
            });
        }
        reference
    }

    #[test]
    fn a_flipped_bit_is_found_or_changes_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        let written = reference();
        written.write(&path).expect("writable");
        let sound = std::fs::read(&path).expect("readable");
        let same = |read: &Reference| read.checksum() == written.checksum();
        assert!(same(&Reference::read(&path).expect("sound")));
        let mut found = 0;
        let bits = 8 * sound.len();
        for bit in (0..bits).step_by(13) {
            let mut bytes = sound.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            std::fs::write(&path, bytes).expect("writable");
            match Reference::read(&path) {
                Ok(read) => assert!(same(&read), "bit {bit} of {bits}"),
                Err(ImageError::Io { .. }) => panic!("bit {bit} is no error of the system"),
                Err(_) => found += 1,
            }
        }
        assert!(found > bits / 13 / 2, "{found} of {}", bits / 13);
    }

    #[test]
    fn files_without_a_checksum_are_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        let written = reference();
        written.write(&path).expect("writable");
        let file = read_layers(&path).expect("sound");
        let layers = [
            Layer::color("mean", written.mean.clone()),
            Layer::color("deviations", written.deviations.clone()),
        ];
        let mut attributes = file.attributes;
        attributes.remove(CHECKSUM).expect("a checksum");
        write_exr(&path, &layers, &attributes).expect("writable");
        assert_eq!(Reference::read(&path).expect("sound").mean, written.mean);
        attributes.remove("samples");
        write_exr(&path, &layers, &attributes).expect("writable");
        let error = Reference::read(&path).expect_err("no samples").to_string();
        assert!(error.contains("does not say its `samples`"), "{error}");
    }
}
