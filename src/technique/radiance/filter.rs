//! The edge-aware filter of a layer: a sparse cross-bilateral kernel (Roth et al. 2020, equations 2 to 6).
//!
//! The weight of a neighbour is the product of what the paper's functions say of normals, path lengths, lengths of the
//! leg to the next vertex, albedo and luminance. *Differs:* weights below 0 count as 0, and lengths are compared
//! relative to the path length at the centre and to the size of a pixel: the printed scales belong to an image
//! 1024 pixels high, on which they let 1 % and 0.25 % of the path length pass. Differences of colour are Euclidean in
//! CIE L*a*b*, κ is 1, luminances are exposed.

use macro_rules_attribute::apply;

use super::planes::{PLANES, Plane};
use crate::entry::{Kind, Setting, parameters};
use crate::instructions::compiled_for_avx512;

parameters! {
    /// Kernel and edge-stopping of the filter.
    #[derive(Clone, Copy, Debug, serde::Serialize)]
    pub struct FilterParameters {
        /// Radius of the kernel.
        radius: f32 = 6.0, Within(0.0, 64.0), "pixels";
        /// Neighbours that are looked at, the pixel itself included.
        taps: u32 = 25, Within(1.0, 1024.0);
        /// s_d: fall of the weight with the difference of path lengths.
        path_length: f32 = 100.0, AtLeast(0.0);
        /// s_d': fall of the weight with the difference of leg lengths.
        segment: f32 = 400.0, AtLeast(0.0);
        /// s_l: fall of the weight with the difference of luminances.
        luminance: f32 = 3.0, AtLeast(0.0);
    }
}

impl Setting for FilterParameters {
    const KIND: Kind = Kind::Table(Self::PARAMETERS);
}

/// The kernel with its scales.
#[derive(Clone, Debug)]
pub struct Filter {
    /// Offsets of neighbours, pixels.
    taps: Vec<[i32; 2]>,
    parameters: FilterParameters,
}

/// Image height to which the printed scales of lengths belong.
const PRINTED_HEIGHT: f32 = 1024.0;
/// Pixels that are worked on together.
const LANES: usize = 16;

type Lanes = [f32; LANES];

impl Filter {
    /// A disk of taps spread by the golden angle.
    pub fn new(parameters: FilterParameters) -> Self {
        const GOLDEN_ANGLE: f32 = 2.399_963_2;
        let count = parameters.taps.max(1);
        let mut taps: Vec<[i32; 2]> = Vec::with_capacity(count as usize);
        for i in 0..count {
            let radius = parameters.radius * (i as f32 / (count - 1).max(1) as f32).sqrt();
            let (sin, cos) = (i as f32 * GOLDEN_ANGLE).sin_cos();
            let tap = [radius * cos, radius * sin].map(|t| t.round() as i32);
            if !taps.contains(&tap) {
                taps.push(tap);
            }
        }
        Self { taps, parameters }
    }

    /// Smooths row `y` of a layer whose rows of planes are `rows`.
    pub(super) fn smooth<'a>(
        &self,
        smoothed: &mut Smoothed,
        [width, height]: [usize; 2],
        y: usize,
        rows: impl Fn(usize) -> &'a [f32],
    ) {
        let centre = rows(y);
        let per_pixel = height as f32 / PRINTED_HEIGHT;
        let scales = Scales {
            path_length: self.parameters.path_length * per_pixel,
            segment: self.parameters.segment * per_pixel,
            luminance: self.parameters.luminance,
        };
        smoothed.sums.clear();
        smoothed.sums.resize(SUMS * width, 0.0);
        for [dx, dy] in &self.taps {
            let Some(v) = y.checked_add_signed(*dy as isize).filter(|v| *v < height) else {
                continue;
            };
            let first = (-dx).max(0) as usize;
            let end = width.min(width.saturating_add_signed(-*dx as isize));
            if first >= end {
                continue;
            }
            let neighbour_first = first.saturating_add_signed(*dx as isize);
            let run = Run {
                width,
                starts: [first, neighbour_first],
                count: end - first,
            };
            accumulate(&run, &scales, [centre, rows(v)], &mut smoothed.sums);
        }
        smoothed.divide(centre, width);
    }
}

/// A run of pixels and the run of their neighbours.
struct Run {
    width: usize,
    /// First pixel and first neighbour.
    starts: [usize; 2],
    count: usize,
}

struct Scales {
    path_length: f32,
    segment: f32,
    luminance: f32,
}

/// Sums of weights and of weighted values: of `E`, then of `G`.
const SUMS: usize = 8;

/// A row's `E` and `G` after the filter.
#[derive(Default)]
pub(super) struct Smoothed {
    /// `E` and `G`, plane by plane.
    values: Vec<f32>,
    sums: Vec<f32>,
    width: usize,
}

impl Smoothed {
    /// What it is without a filter.
    pub fn begin(&mut self, planes: &[f32], width: usize) {
        self.width = width;
        self.values.clear();
        let first = Plane::E as usize * width;
        self.values.extend_from_slice(&planes[first..][..6 * width]);
    }

    /// `E` and `G` of a column.
    pub fn at(&self, x: usize) -> [[f32; 3]; 2] {
        let value = |plane: usize| self.values[plane * self.width + x];
        [0, 3].map(|first| [value(first), value(first + 1), value(first + 2)])
    }

    /// Means of the sums; pixels without weights stay as they are, and those without gloss keep their own.
    fn divide(&mut self, centre: &[f32], width: usize) {
        let gloss = &centre[Plane::Gloss as usize * width..][..width];
        for (x, gloss) in gloss.iter().enumerate() {
            for (part, counts) in [true, *gloss > 0.0].into_iter().enumerate() {
                let weight = self.sums[4 * part * width + x];
                if !counts || weight <= 0.0 {
                    continue;
                }
                for c in 0..3 {
                    let sum = self.sums[(4 * part + 1 + c) * width + x];
                    self.values[(3 * part + c) * width + x] = sum / weight;
                }
            }
        }
    }
}

/// Adds one neighbour of each pixel of a run.
#[apply(compiled_for_avx512)]
fn accumulate(run: &Run, scales: &Scales, features: [&[f32]; 2], sums: &mut [f32]) {
    for first in (0..run.count).step_by(LANES) {
        add_lanes(run, scales, features, first, sums);
    }
}

#[inline(always)]
fn add_lanes(
    run: &Run,
    scales: &Scales,
    [centre, other]: [&[f32]; 2],
    first: usize,
    sums: &mut [f32],
) {
    let count = LANES.min(run.count - first);
    let own = |plane: Plane| {
        load(
            centre,
            plane as usize * run.width + run.starts[0] + first,
            count,
        )
    };
    let its = |plane: usize| load(other, plane * run.width + run.starts[1] + first, count);
    // Deep layers are empty almost everywhere.
    if own(Plane::Surface) == [0.0; LANES] {
        return;
    }
    let weight = weights(scales, &own, &|plane| its(plane as usize));
    for (part, of_it) in [Plane::Base, Plane::Gloss].into_iter().enumerate() {
        let of_it = its(of_it as usize);
        let weight: Lanes = std::array::from_fn(|i| weight[i] * of_it[i]);
        let at = |sum: usize| (4 * part + sum) * run.width + run.starts[0] + first;
        add(sums, at(0), count, &weight);
        for c in 0..3 {
            let value = its(Plane::E as usize + 3 * part + c);
            let weighted: Lanes = std::array::from_fn(|i| weight[i] * value[i]);
            add(sums, at(1 + c), count, &weighted);
        }
    }
}

/// The product of the edge-stopping functions.
#[inline(always)]
fn weights(scales: &Scales, own: &impl Fn(Plane) -> Lanes, its: &impl Fn(Plane) -> Lanes) -> Lanes {
    let mut weight = its(Plane::Surface);
    let normals = [Plane::NormalX, Plane::NormalY, Plane::NormalZ].map(|p| (own(p), its(p)));
    let lengths = [Plane::PathLength, Plane::Segment].map(|p| (own(p), its(p)));
    let colours = [Plane::Lightness, Plane::GreenRed, Plane::BlueYellow].map(|p| (own(p), its(p)));
    let luminances = (own(Plane::Luminance), its(Plane::Luminance));
    let colour_scale = own(Plane::ColourScale);
    for i in 0..LANES {
        let dot = |(a, b): &(Lanes, Lanes)| a[i] * b[i];
        let facing = (dot(&normals[0]) + dot(&normals[1]) + dot(&normals[2])).max(0.0);
        let reciprocal = 1.0 / lengths[0].0[i].max(f32::MIN_POSITIVE);
        let apart = |(a, b): &(Lanes, Lanes)| (a[i] - b[i]).abs();
        let path = 1.0 - scales.path_length * (apart(&lengths[0]) * reciprocal);
        let segment = 1.0 - scales.segment * (apart(&lengths[1]) * reciprocal);
        let square = |(a, b): &(Lanes, Lanes)| (a[i] - b[i]) * (a[i] - b[i]);
        let lab = (square(&colours[0]) + square(&colours[1]) + square(&colours[2])).sqrt();
        let colour = ln(1.0 + lab);
        let colour = 1.0 - colour_scale[i] * (colour / (colour + 1.0));
        let light = apart(&luminances);
        let light = 1.0 - ln(1.0 + scales.luminance * (light / (light + 1.0)));
        weight[i] *= facing * path.max(0.0) * segment.max(0.0) * (colour.max(0.0) * light.max(0.0));
    }
    weight
}

/// Natural logarithm of numbers from 1 on, within 10⁻⁵; exactly 0 at 1 (Abramowitz & Stegun 4.1.43).
#[inline(always)]
fn ln(x: f32) -> f32 {
    let bits = x.to_bits();
    let exponent = (bits >> 23) as i32 - 127;
    let t = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000) - 1.0;
    let series = 0.289_474_8 + t * (-0.136_062_75 + t * 0.032_158_45);
    let series = t * (0.999_495_56 + t * (-0.491_908_96 + t * series));
    exponent as f32 * std::f32::consts::LN_2 + series
}

#[inline(always)]
fn load(numbers: &[f32], at: usize, count: usize) -> Lanes {
    let mut lanes = [0.0; LANES];
    if count == LANES {
        lanes.copy_from_slice(&numbers[at..at + LANES]);
    } else {
        lanes[..count].copy_from_slice(&numbers[at..at + count]);
    }
    lanes
}

#[inline(always)]
fn add(sums: &mut [f32], at: usize, count: usize, values: &Lanes) {
    if count == LANES {
        for (sum, value) in sums[at..at + LANES].iter_mut().zip(values) {
            *sum += value;
        }
    } else {
        for (sum, value) in sums[at..at + count].iter_mut().zip(values) {
            *sum += value;
        }
    }
}

const _: () = assert!(Plane::G as usize == Plane::E as usize + 3 && PLANES > Plane::G as usize);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_is_close_and_zero_at_one() {
        assert_eq!(ln(1.0), 0.0);
        for i in 0..2000 {
            let x = 1.0 + i as f32 * 0.1;
            assert!((ln(x) - x.ln()).abs() < 2e-5, "{x}");
        }
    }

    #[test]
    fn taps_fill_a_disk_and_begin_at_the_centre() {
        let filter = Filter::new(FilterParameters::default());
        assert_eq!(filter.taps[0], [0, 0]);
        assert!(filter.taps.len() >= 24, "{}", filter.taps.len());
        assert!(filter.taps.iter().all(|t| t[0] * t[0] + t[1] * t[1] <= 49));
        let mean = filter
            .taps
            .iter()
            .fold([0, 0], |s, t| [s[0] + t[0], s[1] + t[1]]);
        assert!(mean.iter().all(|m| m.abs() <= 12), "{mean:?}");
    }
}
