//! Small animated previews of what a viewer sees.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::Sequence;
use super::spec::spread;
use crate::image::{Image, display_bytes};

/// Frames of a preview at most.
const FRAMES: usize = 60;
/// Pixels of its longer side at most.
const SIDE: usize = 240;
/// Milliseconds that a frame is shown at least.
const LEAST_MS: f64 = 40.0;
/// Milliseconds that a frame is shown at most.
const MOST_MS: f64 = 500.0;

/// A small picture of a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thumbnail {
    pub frame: u32,
    pub viewer: u16,
    pub width: usize,
    pub height: usize,
    /// Row-major sRGB, three bytes a pixel.
    pub bytes: Vec<u8>,
}

/// Which frames previews show.
pub struct Animation {
    frames: Vec<u32>,
    delay_ms: u16,
}

impl Animation {
    /// Of the measured frames of a sequence, in about its own time.
    pub fn of(sequence: &Sequence) -> Self {
        let measured: Vec<u32> = sequence.measured().collect();
        let frames = spread(&measured, FRAMES);
        let last = frames.len() - 1;
        let span_s = sequence.time_s(frames[last]) - sequence.time_s(frames[0]);
        let delay_ms = 1000.0 * span_s / last.max(1) as f64;
        Self {
            frames,
            delay_ms: delay_ms.clamp(LEAST_MS, MOST_MS) as u16,
        }
    }

    /// Whether it shows a frame.
    pub fn shows(&self, frame: u32) -> bool {
        self.frames.len() > 1 && self.frames.contains(&frame)
    }

    /// Writes `animation-<viewer>.png`, an animated PNG, for each viewer with several pictures.
    pub fn write(&self, folder: &Path, thumbnails: &[Thumbnail]) -> io::Result<()> {
        let viewers = thumbnails.iter().map(|t| t.viewer).max().unwrap_or(0);
        for viewer in 0..=viewers {
            let own = thumbnails.iter().filter(|t| t.viewer == viewer);
            let own: Vec<&Thumbnail> = own.collect();
            if own.len() > 1 {
                let path = folder.join(format!("animation-{viewer}.png"));
                let failed = |error| crate::files::at(&path)(io::Error::other(error));
                self.encode(&path, &own).map_err(failed)?;
            }
        }
        Ok(())
    }

    fn encode(&self, path: &Path, frames: &[&Thumbnail]) -> Result<(), png::EncodingError> {
        let file = BufWriter::new(File::create(path)?);
        let size = [frames[0].width as u32, frames[0].height as u32];
        let mut encoder = png::Encoder::new(file, size[0], size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_animated(frames.len() as u32, 0)?;
        encoder.set_frame_delay(self.delay_ms, 1000)?;
        let mut writer = encoder.write_header()?;
        for frame in frames {
            writer.write_image_data(&frame.bytes)?;
        }
        writer.finish()
    }
}

impl Thumbnail {
    /// A picture at an exposure in stops, made smaller by a whole factor.
    pub fn of(image: &Image, exposure: f32, frame: u32, viewer: u16) -> Self {
        let factor = image.width.max(image.height).div_ceil(SIDE).max(1);
        let small = smaller(image, factor);
        Self {
            frame,
            viewer,
            width: small.width,
            height: small.height,
            bytes: display_bytes(&small, exposure),
        }
    }
}

/// Means of blocks of `factor` × `factor` pixels.
fn smaller(image: &Image, factor: usize) -> Image {
    let [width, height] = [image.width, image.height].map(|side| side.div_ceil(factor));
    let mut small = Image::new(width, height);
    for (i, pixel) in small.pixels.iter_mut().enumerate() {
        let [left, top] = [(i % width) * factor, (i / width) * factor];
        let rows = top..(top + factor).min(image.height);
        let columns = left..(left + factor).min(image.width);
        let count = (rows.len() * columns.len()) as f32;
        for row in rows {
            for value in &image.pixels[row * image.width..][columns.clone()] {
                (0..3).for_each(|c| pixel[c] += value[c] / count);
            }
        }
    }
    small
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn previews_are_animated_pngs_of_blocks() {
        let place = tempfile::tempdir().expect("a folder");
        let sequence = Sequence {
            frames: (0..3).collect(),
            fps: 10.0,
            ..Sequence::still("main")
        };
        let animation = Animation::of(&sequence);
        let image = |value: f32| Image {
            pixels: vec![[value; 3]; 300 * 10],
            ..Image::new(300, 10)
        };
        let frames: Vec<Thumbnail> = (0..3)
            .filter(|&frame| animation.shows(frame))
            .map(|frame| Thumbnail::of(&image(0.5 * frame as f32), 0.0, frame, 0))
            .collect();
        assert_eq!((frames[2].width, frames[2].height), (150, 5));
        assert_eq!([frames[0].bytes[0], frames[2].bytes[0]], [0, 255]);
        animation.write(place.path(), &frames).expect("written");
        let file = File::open(place.path().join("animation-0.png")).expect("there");
        let reader = png::Decoder::new(io::BufReader::new(file))
            .read_info()
            .expect("PNG");
        let control = reader.info().animation_control().expect("animated");
        assert_eq!(control.num_frames, 3);
    }
}
