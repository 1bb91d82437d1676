//! The vertices that camera samples were followed to, bounce by bounce, and how an image is made of them from the
//! last bounce to the first (layered filtering: Roth et al. 2020, section 3.4).
//!
//! A vertex sends back `emission + C ⊙ E + G`: `E` is the light on its diffuse base without the base's colour `C`,
//! `G` what its gloss reflects, which is what the next vertex sends back times the throughput `T`. `E` and `G` are
//! smoothed in their own layer before `C` and `T` are applied, so that textures stay sharp and a reflection is
//! smoothed by what it shows and not by the mirror.

use glam::Vec3;
use rayon::prelude::*;

use super::filter::{Filter, Smoothed};
use super::planes::{PLANES, Plane};
use crate::entry::words;
use crate::image::{Image, luminance};
use crate::metric::lab;

words! {
    /// Which layers are smoothed.
    pub enum Smoothing {
        /// None.
        Off = "off",
        /// The first, by what the camera sees first alone.
        Plain = "plain",
        /// Each, from the last to the first.
        Layered = "layered",
    }
}

/// A vertex of a camera sample, as it is put into its layer.
#[derive(Clone, Copy, Debug, Default)]
pub struct LayerVertex {
    /// Unit geometric normal on the viewer's side; zero where the path left the scene.
    pub normal: Vec3,
    /// Length of the path from the camera to here, scene units.
    pub path_length: f32,
    /// Length of the leg to the next vertex; 0 where there is none.
    pub segment: f32,
    /// Emission towards the viewer, or the environment where the path left the scene.
    pub emission: Vec3,
    /// Albedo `C` of the diffuse base; `None` without one.
    pub albedo: Option<Vec3>,
    /// Light `E` on the base.
    pub base: Vec3,
    /// Whether `base` is a guess because nothing is known here.
    pub hole: bool,
    /// The gloss that is followed; `None` without one.
    pub gloss: Option<GlossVertex>,
}

impl LayerVertex {
    /// What it sends back where nothing is smoothed and nothing lies behind it.
    pub fn sent(&self) -> Vec3 {
        let base = self.albedo.map_or(Vec3::ZERO, |albedo| albedo * self.base);
        let gloss = self.gloss.map_or(Vec3::ZERO, |gloss| gloss.light);
        self.emission + base + gloss
    }
}

/// What a vertex reflects beside its base.
#[derive(Clone, Copy, Debug, Default)]
pub struct GlossVertex {
    /// Light known already: that of sampled lights.
    pub light: Vec3,
    /// Throughput `T` to the next vertex.
    pub throughput: Vec3,
    /// Whether it is a perfect mirror, whose reflection has no noise of its own.
    pub mirror: bool,
}

/// How layers are smoothed, and the exposure that differences of luminance are seen at.
#[derive(Clone, Debug)]
pub struct Setting {
    /// Which layers are smoothed.
    pub smoothing: Smoothing,
    /// How each of them is.
    pub filter: Filter,
    /// Factor on radiance.
    pub exposure: f32,
}

/// The layers of one camera sample in each pixel.
pub struct Layers {
    width: usize,
    height: usize,
    depth: usize,
    /// Row by row, of each row layer by layer, of each layer plane by plane.
    numbers: Vec<f32>,
    /// Layers in use.
    used: usize,
}

/// One row of pixels in all layers.
pub struct LayerRow<'a> {
    width: usize,
    numbers: &'a mut [f32],
}

/// What making an image of layers met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Filled {
    /// Vertices with a base about which nothing was known.
    pub holes: u64,
    /// Holes that no neighbour could fill.
    pub unfilled: u64,
}

impl Layers {
    /// Empty layers for paths of up to `depth` vertices.
    pub fn new(width: usize, height: usize, depth: usize) -> Self {
        Self {
            width,
            height,
            depth,
            numbers: vec![0.0; width * height * depth * PLANES],
            used: 0,
        }
    }

    /// Memory of the layers of a pixel, for paths of up to `depth` vertices.
    pub fn bytes_per_pixel(depth: usize) -> usize {
        depth * PLANES * size_of::<f32>()
    }

    /// Fills the layers anew, each row by one thread: `fill` gets the row and its number and gives back how many
    /// layers it used and whatever else it found.
    pub fn fill<T: Send>(&mut self, fill: impl Fn(LayerRow, usize) -> (usize, T) + Sync) -> Vec<T> {
        let width = self.width;
        let row = (width * self.depth * PLANES).max(1);
        let before = self.used * PLANES * width;
        let found: Vec<(usize, T)> = self
            .numbers
            .par_chunks_mut(row)
            .enumerate()
            .map(|(y, numbers)| {
                numbers[..before].fill(0.0);
                fill(LayerRow { width, numbers }, y)
            })
            .collect();
        self.used = found.iter().map(|(used, _)| *used).max().unwrap_or(0);
        found.into_iter().map(|(_, found)| found).collect()
    }

    /// The image of the layers, from the last to the first.
    pub fn image(&mut self, setting: &Setting) -> (Image, Filled) {
        let mut filled = Filled::default();
        let mut out = vec![[0.0; 3]; self.width * self.height];
        for layer in (0..self.used).rev() {
            let is_last = layer + 1 == self.used;
            self.receive(layer, (!is_last).then_some(out.as_slice()), setting);
            let holes = self.fill_holes(layer);
            filled.holes += holes.holes;
            filled.unfilled += holes.unfilled;
            let smooth = match setting.smoothing {
                Smoothing::Off => false,
                Smoothing::Plain => layer == 0,
                Smoothing::Layered => true,
            };
            out = self.sent(layer, smooth.then_some(&setting.filter));
        }
        let image = Image {
            width: self.width,
            height: self.height,
            pixels: out,
        };
        (image, filled)
    }

    /// Adds what the layer behind sent back to `G`, and sets luminances and the weights of gloss.
    fn receive(&mut self, layer: usize, behind: Option<&[[f32; 3]]>, setting: &Setting) {
        let width = self.width;
        let row = (width * self.depth * PLANES).max(1);
        let mirrors_too = setting.smoothing == Smoothing::Plain;
        self.numbers
            .par_chunks_mut(row)
            .enumerate()
            .for_each(|(y, numbers)| {
                let mut row = LayerRow { width, numbers };
                let planes = row.planes(layer);
                for x in 0..width {
                    let at = |plane: Plane| plane as usize * width + x;
                    let rgb = |p: &[f32], plane| {
                        let i = at(plane);
                        Vec3::new(p[i], p[i + width], p[i + 2 * width])
                    };
                    if planes[at(Plane::Surface)] == 0.0 {
                        continue;
                    }
                    let mut gloss = rgb(planes, Plane::G);
                    if let Some(behind) = behind {
                        let sent = Vec3::from(behind[y * width + x]);
                        gloss += rgb(planes, Plane::Throughput) * sent;
                        let i = at(Plane::G);
                        [planes[i], planes[i + width], planes[i + 2 * width]] = gloss.into();
                    }
                    let weight = &mut planes[at(Plane::Gloss)];
                    if mirrors_too && *weight == MIRROR {
                        *weight = 1.0;
                    }
                    *weight = weight.max(0.0);
                    let seen = rgb(planes, Plane::E) + gloss;
                    planes[at(Plane::Luminance)] = luminance(seen.into()) * setting.exposure;
                }
            });
    }

    /// Gives holes the mean of the neighbours whose light is known, in the nearest ring of pixels that has any.
    fn fill_holes(&mut self, layer: usize) -> Filled {
        let (width, height) = (self.width, self.height);
        let layers = &*self;
        let filled: Vec<(usize, usize, Option<Vec3>)> = (0..height)
            .into_par_iter()
            .flat_map_iter(|y| {
                let flags = layers.at(layer, y, Plane::Hole);
                let holes = (0..width).filter(move |x| flags[*x] > 0.0);
                holes.map(move |x| (y, x, layers.mean_around(layer, [x, y])))
            })
            .collect();
        let mut count = Filled {
            holes: filled.len() as u64,
            unfilled: 0,
        };
        for (y, x, value) in filled {
            let Some(value) = value else {
                count.unfilled += 1;
                continue;
            };
            let start = ((y * self.depth + layer) * PLANES + Plane::E as usize) * width + x;
            for (channel, value) in value.to_array().into_iter().enumerate() {
                self.numbers[start + channel * width] = value;
            }
        }
        count
    }

    fn mean_around(&self, layer: usize, [x, y]: [usize; 2]) -> Option<Vec3> {
        for radius in 1..=FILL_RADIUS {
            let (mut sum, mut count) = (Vec3::ZERO, 0);
            let columns = x.saturating_sub(radius)..(x + radius + 1).min(self.width);
            for v in y.saturating_sub(radius)..(y + radius + 1).min(self.height) {
                let base = self.at(layer, v, Plane::Base);
                let e = &self.planes(layer, v)[Plane::E as usize * self.width..];
                for u in columns.clone().filter(|u| base[*u] > 0.0) {
                    sum += Vec3::from_array([0, 1, 2].map(|c| e[c * self.width + u]));
                    count += 1;
                }
            }
            if count > 0 {
                return Some(sum / count as f32);
            }
        }
        None
    }

    /// One plane of a row of a layer.
    fn at(&self, layer: usize, y: usize, plane: Plane) -> &[f32] {
        let start = ((y * self.depth + layer) * PLANES + plane as usize) * self.width;
        &self.numbers[start..][..self.width]
    }

    /// All planes of a row of a layer.
    fn planes(&self, layer: usize, y: usize) -> &[f32] {
        let start = (y * self.depth + layer) * PLANES * self.width;
        &self.numbers[start..][..PLANES * self.width]
    }

    /// What the vertices of a layer send back, after the filter if there is one.
    fn sent(&self, layer: usize, filter: Option<&Filter>) -> Vec<[f32; 3]> {
        let width = self.width;
        let mut out = vec![[0.0; 3]; width * self.height];
        let rows = |y: usize| self.planes(layer, y);
        out.par_chunks_mut(width.max(1)).enumerate().for_each_init(
            Smoothed::default,
            |smoothed, (y, out)| {
                smoothed.begin(rows(y), width);
                if let Some(filter) = filter {
                    filter.smooth(smoothed, [width, self.height], y, rows);
                }
                let [emission, albedo] = [Plane::Emission, Plane::Albedo].map(|plane| {
                    let from = plane as usize * width;
                    &rows(y)[from..from + 3 * width]
                });
                for (x, out) in out.iter_mut().enumerate() {
                    let [base, gloss] = smoothed.at(x);
                    *out = std::array::from_fn(|c| {
                        let i = c * width + x;
                        emission[i] + albedo[i] * base[c] + gloss[c]
                    });
                }
            },
        );
        out
    }
}

/// Marks the gloss of perfect mirrors until it is known whether they are smoothed.
const MIRROR: f32 = -1.0;
/// Pixels within which a hole looks for neighbours.
const FILL_RADIUS: usize = 3;
/// Factors on differences of colour beside glossy surfaces and others (paper, section 4).
const COLOUR_SCALES: [f32; 2] = [3.0, 1.5];

impl LayerRow<'_> {
    /// All planes of a layer.
    fn planes(&mut self, layer: usize) -> &mut [f32] {
        let size = PLANES * self.width;
        &mut self.numbers[layer * size..][..size]
    }

    /// Puts a vertex into its layer, in column `x`.
    pub fn put(&mut self, layer: usize, x: usize, vertex: &LayerVertex) {
        let width = self.width;
        let planes = self.planes(layer);
        let mut set = |first: Plane, values: &[f32]| {
            for (i, value) in values.iter().enumerate() {
                planes[(first as usize + i) * width + x] = *value;
            }
        };
        set(Plane::Emission, &vertex.emission.to_array());
        if vertex.normal == Vec3::ZERO {
            return;
        }
        let flag = |yes: bool| f32::from(u8::from(yes));
        let known = vertex.albedo.is_some() && !vertex.hole;
        let gloss = vertex
            .gloss
            .map_or(0.0, |g| if g.mirror { MIRROR } else { 1.0 });
        set(Plane::Surface, &[1.0, flag(known), gloss]);
        set(Plane::Hole, &[flag(vertex.albedo.is_some() && vertex.hole)]);
        set(Plane::NormalX, &vertex.normal.to_array());
        set(Plane::Segment, &[vertex.segment, vertex.path_length]);
        set(
            Plane::Lightness,
            &lab(vertex.albedo.unwrap_or(Vec3::ONE).into()),
        );
        let scale = COLOUR_SCALES[usize::from(vertex.gloss.is_none())];
        set(Plane::ColourScale, &[scale]);
        if let Some(albedo) = vertex.albedo {
            set(Plane::E, &vertex.base.to_array());
            set(Plane::Albedo, &albedo.to_array());
        }
        if let Some(gloss) = vertex.gloss {
            set(Plane::G, &gloss.light.to_array());
            set(Plane::Throughput, &gloss.throughput.to_array());
        }
    }
}

#[cfg(test)]
mod tests;
