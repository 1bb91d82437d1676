//! Images of a glTF file: where they are, what their headers say, and their means.

use std::collections::HashMap;
use std::io::Cursor;
use std::sync::{Mutex, PoisonError};

use ::image::{ImageDecoder, ImageFormat, ImageReader};

use super::document::{GltfFile, named};
use super::uri::{Uri, parse_uri};
use crate::image::srgb_decode;
use crate::scene::{SceneError, TextureSource};

/// Means of an image over its texels, per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Means {
    /// Of the values as stored.
    pub raw: [f32; 3],
    /// Of the values decoded from sRGB.
    pub decoded: [f32; 3],
}

impl GltfFile {
    /// Where the texels of an image come from.
    pub(super) fn image_source(&self, image: usize) -> Result<TextureSource, SceneError> {
        let declared = self.root().images.get(image);
        let place = named("image", image, declared.and_then(|i| i.name.as_deref()));
        let Some(declared) = declared else {
            return Err(self.error(place, "is not there"));
        };
        let uri = declared
            .uri
            .as_deref()
            .map(|uri| parse_uri(uri, self.folder()));
        match uri
            .transpose()
            .map_err(|message| self.error(&place, message))?
        {
            Some(Uri::File(path)) => Ok(TextureSource::File(path)),
            Some(Uri::Data(_)) => Ok(TextureSource::Gltf {
                file: self.clone(),
                image,
            }),
            None if declared.buffer_view.is_some() => Ok(TextureSource::Gltf {
                file: self.clone(),
                image,
            }),
            None => Err(self.error(place, "has neither a `uri` nor a `bufferView`")),
        }
    }

    /// Whether an image has an alpha channel, from its header; `None` where its file is absent. Fails on
    /// anything but PNG and JPEG.
    pub(super) fn image_has_alpha(&self, image: usize) -> Result<Option<bool>, SceneError> {
        let Some(bytes) = self.encoded(image)? else {
            return Ok(None);
        };
        let fail = |e: ::image::ImageError| self.error(format!("image {image}"), e);
        let decoder = self.reader(image, &bytes)?.into_decoder().map_err(fail)?;
        Ok(Some(decoder.color_type().has_alpha()))
    }

    /// The means of an image; `None` where its file is absent. They are remembered as long as the program runs.
    pub(super) fn image_means(&self, image: usize) -> Result<Option<Means>, SceneError> {
        static KNOWN: Mutex<Option<HashMap<blake3::Hash, Means>>> = Mutex::new(None);
        let Some(bytes) = self.encoded(image)? else {
            return Ok(None);
        };
        let hash = blake3::hash(&bytes);
        let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(means) = known().get_or_insert_default().get(&hash) {
            return Ok(Some(*means));
        }
        let decoded = self.reader(image, &bytes)?.decode();
        let decoded = decoded.map_err(|e| self.error(format!("image {image}"), e))?;
        let means = means(&decoded.to_rgb8());
        known().get_or_insert_default().insert(hash, means);
        Ok(Some(means))
    }

    fn reader<'b>(
        &self,
        image: usize,
        bytes: &'b [u8],
    ) -> Result<ImageReader<Cursor<&'b [u8]>>, SceneError> {
        let format = ::image::guess_format(bytes).ok();
        match format {
            Some(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => {
                Ok(ImageReader::with_format(Cursor::new(bytes), format))
            }
            _ => Err(self.error(format!("image {image}"), "is neither PNG nor JPEG")),
        }
    }

    /// The bytes of an image as they are stored, `None` where its file is absent.
    fn encoded(&self, image: usize) -> Result<Option<Vec<u8>>, SceneError> {
        match self.image_source(image)? {
            TextureSource::File(path) if !path.exists() => Ok(None),
            TextureSource::File(path) => match crate::files::read(&path) {
                Ok(bytes) => Ok(Some(bytes)),
                Err(e) => {
                    Err(self.error(format!("image {image}"), format!("{}: {e}", path.display())))
                }
            },
            _ => self.image_bytes(image).map(Some),
        }
    }
}

fn means(image: &::image::RgbImage) -> Means {
    let mut counts = [[0_u64; 256]; 3];
    for pixel in image.pixels() {
        for (counts, value) in counts.iter_mut().zip(pixel.0) {
            counts[usize::from(value)] += 1;
        }
    }
    let texels = image.pixels().len().max(1) as f64;
    let mean = |of: fn(f32) -> f32| {
        counts.map(|counts| {
            let weighted = counts.iter().enumerate();
            let sum: f64 = weighted
                .map(|(value, &n)| n as f64 * f64::from(of(value as f32 / 255.0)))
                .sum();
            (sum / texels) as f32
        })
    };
    Means {
        raw: mean(|value| value),
        decoded: mean(srgb_decode),
    }
}
