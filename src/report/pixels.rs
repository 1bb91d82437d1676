//! Pixels for the page: half floats, packed as OpenEXR's ZIP does it, and where the page finds them.

use std::io::{self, Write};
use std::path::PathBuf;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use half::f16;
use serde::Serialize;

use super::escape;
use crate::experiment::Store;
use crate::image::{Image, Plane, png_bytes};

/// Where the page's pixels are: in scripts beside it, because a page that is opened as a file may load nothing else,
/// or in the page itself.
pub struct Shelf<'a> {
    store: &'a Store,
    /// Pixels in the page itself, by name; `None` while they lie beside it.
    inside: Option<Vec<Packed>>,
}

/// Pixels in the page itself.
#[derive(Clone, Debug, Serialize)]
pub struct Packed {
    pub name: String,
    /// Base64.
    pub data: String,
}

impl<'a> Shelf<'a> {
    /// An empty shelf, in the page itself if it is to be a single file.
    pub fn new(store: &'a Store, single_file: bool) -> Self {
        Self {
            store,
            inside: single_file.then(Vec::new),
        }
    }

    /// Keeps a picture and returns the name by which the page finds it.
    pub fn picture(&mut self, name: &str, image: &Image) -> io::Result<String> {
        let channel = |c: usize| image.pixels.iter().map(move |p| p[c]);
        let values: Vec<f32> = (0..3).flat_map(channel).collect();
        self.keep(name, &values)
    }

    /// Keeps a map and returns the name by which the page finds it.
    pub fn map(&mut self, name: &str, plane: &Plane) -> io::Result<String> {
        self.keep(name, &plane.values)
    }

    /// Where the page finds other files.
    pub fn sources(&self) -> Sources {
        Sources {
            folder: self.inside.is_some().then(|| self.store.folder.clone()),
        }
    }

    /// What lies in the page itself.
    pub fn into_inside(self) -> Vec<Packed> {
        self.inside.unwrap_or_default()
    }

    fn keep(&mut self, name: &str, values: &[f32]) -> io::Result<String> {
        let name = escape::file_name(name);
        let data = pack(values)?;
        match &mut self.inside {
            Some(inside) => inside.push(Packed {
                name: name.clone(),
                data,
            }),
            None => {
                let script = format!("lightbench.put(\"{name}\", \"{data}\");\n");
                let file = format!("figures/viewer/{name}.js");
                self.store.write(&file, &script)?;
            }
        }
        Ok(name)
    }
}

/// Where the page finds pictures that are files of the results folder.
#[derive(Clone, Debug)]
pub struct Sources {
    /// The folder, if its files are put into the page.
    folder: Option<PathBuf>,
}

impl Sources {
    /// A link, or the file itself as a link; a link where it cannot be read.
    pub fn of(&self, file: &str) -> String {
        let inside = self.folder.as_ref().and_then(|folder| {
            let kind = match file.rsplit('.').next() {
                Some("svg") => "image/svg+xml",
                _ => "image/png",
            };
            let bytes = std::fs::read(folder.join(file)).ok()?;
            Some(inline(kind, &bytes))
        });
        inside.unwrap_or_else(|| escape::link(file))
    }
}

/// A small picture of eight bits, whose values are coded already, as a link that holds it: a script may read what it
/// drew of that, but not of a file beside a page that is a file itself.
pub fn link_of(image: &Image) -> io::Result<String> {
    let bytes = png_bytes(image).map_err(io::Error::other)?;
    Ok(inline("image/png", &bytes))
}

/// A file as a link that holds it.
fn inline(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// Values as half floats: first all high bytes, then all low ones, each less its predecessor; zlib; base64. Finite
/// values beyond the range of halves become its ends.
fn pack(values: &[f32]) -> io::Result<String> {
    let largest = f32::from(f16::MAX);
    let halves = values.iter().map(|v| match v.is_finite() {
        true => f16::from_f32(v.clamp(-largest, largest)).to_be_bytes(),
        false => f16::from_f32(*v).to_be_bytes(),
    });
    let halves: Vec<[u8; 2]> = halves.collect();
    let bytes = (0..2).flat_map(|part| halves.iter().map(move |h| h[part]));
    let mut last = 0_u8;
    let deltas = bytes.map(|byte| {
        let delta = byte.wrapping_sub(last);
        last = byte;
        delta
    });
    let deltas: Vec<u8> = deltas.collect();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(&deltas)?;
    Ok(STANDARD.encode(encoder.finish()?))
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::ZlibDecoder;

    use super::*;

    /// What the page's script does.
    fn unpack(text: &str) -> Vec<f32> {
        let bytes = STANDARD.decode(text).expect("base64");
        let mut plain = Vec::new();
        ZlibDecoder::new(&bytes[..])
            .read_to_end(&mut plain)
            .expect("zlib");
        let mut sum = 0_u8;
        for byte in &mut plain {
            sum = sum.wrapping_add(*byte);
            *byte = sum;
        }
        let (high, low) = plain.split_at(plain.len() / 2);
        let pairs = high.iter().zip(low);
        pairs
            .map(|(h, l)| f32::from(f16::from_be_bytes([*h, *l])))
            .collect()
    }

    #[test]
    fn pixels_come_back_as_halves() {
        let values = [0.0, 1.0, -0.5, 0.1, 3e7, f32::INFINITY, 6e-6];
        let back = unpack(&pack(&values).expect("packed"));
        let halves = values.map(|v| f32::from(f16::from_f32(v)));
        assert_eq!(back[..4], halves[..4]);
        assert_eq!(back[4..], [65_504.0, f32::INFINITY, halves[6]]);
        assert!(unpack(&pack(&[f32::NAN]).expect("packed"))[0].is_nan());
        assert!(unpack(&pack(&[]).expect("packed")).is_empty());
    }
}
