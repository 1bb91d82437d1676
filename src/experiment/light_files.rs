//! What a job keeps of its lights, for figures: `map.png`, a picture of the map, and `lights.json`.

use std::collections::BTreeSet;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::environment::{Environment, LightKind, LightSet};
use crate::image::{Image, overview, write_png_coded};

/// Names within a job's folder.
pub const MAP_FILE: &str = "map.png";
/// The lights of the job's sampler and where they lie on the map.
pub const LIGHTS_FILE: &str = "lights.json";
/// Pixels of the picture, at most.
const WIDTH: usize = 512;

/// `lights.json`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct LightFile {
    /// Map coordinates in [0, 1] from the top left, and kinds.
    pub lights: Vec<([f32; 2], LightKind)>,
    /// Pixels of the picture that hold an emissive texel: runs of (first, length), row-major.
    pub emissive: Vec<[u32; 2]>,
}

impl LightFile {
    /// Emissive pixels of the picture.
    pub fn emissive_pixels(&self) -> BTreeSet<u32> {
        let pixels = |[first, length]: &[u32; 2]| *first..first + length;
        self.emissive.iter().flat_map(pixels).collect()
    }
}

/// Writes both files.
pub fn write_lights(folder: &Path, set: &LightSet, map: &Environment) -> io::Result<()> {
    let (width, height) = (map.width(), map.height());
    let pixels = (0..width * height).map(|i| map.texel(i % width, i / width));
    let picture = overview(
        &Image {
            width,
            height,
            pixels: pixels.collect(),
        },
        WIDTH,
    );
    write_png_coded(&folder.join(MAP_FILE), &picture).map_err(io::Error::other)?;
    let block = width.div_ceil(WIDTH);
    let pixel = |texel: &u32| {
        let texel = *texel as usize;
        (texel / width / block * picture.width + texel % width / block) as u32
    };
    let file = LightFile {
        lights: set
            .lights
            .iter()
            .map(|l| (map.coordinates(l.direction).map(|c| c as f32), l.kind))
            .collect(),
        emissive: runs(&set.emissive.iter().map(pixel).collect()),
    };
    crate::files::write(&folder.join(LIGHTS_FILE), serde_json::to_string(&file)?)
}

fn runs(pixels: &BTreeSet<u32>) -> Vec<[u32; 2]> {
    let mut runs: Vec<[u32; 2]> = Vec::new();
    for &pixel in pixels {
        match runs.last_mut() {
            Some([first, length]) if *first + *length == pixel => *length += 1,
            _ => runs.push([pixel, 1]),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_give_their_pixels_back() {
        let pixels: BTreeSet<u32> = [3, 4, 5, 9, 11, 12].into();
        let file = LightFile {
            lights: Vec::new(),
            emissive: runs(&pixels),
        };
        assert_eq!(file.emissive, [[3, 3], [9, 1], [11, 2]]);
        assert_eq!(file.emissive_pixels(), pixels);
    }
}
