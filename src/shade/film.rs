//! The film: independent jittered samples per pixel, box filter, moments in f64.

use glam::DVec3;
use rayon::prelude::*;

use super::path::{Depths, PathTracer};
use crate::image::Image;
use crate::sample::Rng;
use crate::scene::View;
use crate::trace::{Caster, Ray, RayCounter, RayCounts};

/// What to render.
#[derive(Clone, Debug)]
pub struct RenderOptions {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Samples per pixel, by index: `0..64` and `64..128` together are `0..128`.
    pub samples: std::ops::Range<u64>,
    /// Of all samples; other seeds give independent pictures.
    pub seed: u64,
    /// See [`PathTracer::radiance`].
    pub depths: Depths,
}

/// A sample that was kept out of the mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct NonFinite {
    /// Column, from the left.
    pub x: usize,
    /// Row, from the top.
    pub y: usize,
    /// Index of the sample within the pixel.
    pub sample: u64,
}

/// A rendered image with its own noise.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// Linear RGB radiance, over the finite samples of each pixel.
    pub mean: Image,
    /// Variance of `mean` per pixel and channel, estimated from the samples; 0 with fewer than two.
    pub variance: Image,
    /// Samples per pixel.
    pub samples: u64,
    /// Samples that were not finite, in the order of pixels and samples.
    pub non_finite: Vec<NonFinite>,
    /// Camera rays included.
    pub rays: RayCounts,
}

/// Keys the random numbers of camera paths.
const STREAM: u64 = 0x7061_7468;

/// Renders `view` with uniformly jittered samples in each pixel. Depends on (seed, pixel, sample)
/// alone, not on the number of threads; ranges of samples can be merged with
/// [`Rendering::merge`].
pub fn render(path_tracer: &PathTracer, view: &View, options: &RenderOptions) -> Rendering {
    let counter = RayCounter::default();
    let rows: Vec<Row> = (0..options.height)
        .into_par_iter()
        .map(|y| {
            let caster = path_tracer.tracer().caster(&counter);
            let camera = Camera { view, options };
            camera.row(path_tracer, &caster, y)
        })
        .collect();
    let mut rendering = Rendering {
        mean: Image::new(options.width, options.height),
        variance: Image::new(options.width, options.height),
        samples: options.samples.end.saturating_sub(options.samples.start),
        non_finite: Vec::new(),
        rays: counter.read(),
    };
    for (y, row) in rows.into_iter().enumerate() {
        for (x, moments) in row.moments.iter().enumerate() {
            rendering.mean.pixels[y * options.width + x] = moments.mean().as_vec3().into();
            rendering.variance.pixels[y * options.width + x] =
                moments.variance_of_mean().as_vec3().into();
        }
        rendering.non_finite.extend(row.non_finite);
    }
    rendering
}

struct Row {
    moments: Vec<Moments>,
    non_finite: Vec<NonFinite>,
}

struct Camera<'a> {
    view: &'a View,
    options: &'a RenderOptions,
}

impl Camera<'_> {
    fn row(&self, path_tracer: &PathTracer, caster: &Caster, y: usize) -> Row {
        let mut row = Row {
            moments: vec![Moments::default(); self.options.width],
            non_finite: Vec::new(),
        };
        let size = [self.options.width, self.options.height];
        let origin = self.view.origin.as_vec3();
        for x in 0..size[0] {
            let pixel = (y * size[0] + x) as u64;
            for sample in self.options.samples.clone() {
                let mut rng = Rng::new(self.options.seed, STREAM, pixel, sample);
                let film_x = x as f64 + rng.next_f64();
                let film_y = y as f64 + rng.next_f64();
                let ray = Ray::new(origin, self.view.direction(film_x, film_y, size));
                let depths = self.options.depths;
                let rgb = path_tracer.radiance(caster, ray, &mut rng, depths);
                if rgb.iter().all(|c| c.is_finite()) {
                    row.moments[x].add(rgb);
                } else {
                    row.non_finite.push(NonFinite { x, y, sample });
                }
            }
        }
        row
    }
}

/// Running mean and squared deviation (Welford), per channel.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    count: f64,
    mean: DVec3,
    squared: DVec3,
}

impl Moments {
    fn add(&mut self, rgb: [f32; 3]) {
        let value = DVec3::from(rgb.map(f64::from));
        self.count += 1.0;
        let before = value - self.mean;
        self.mean += before / self.count;
        self.squared += before * (value - self.mean);
    }

    fn mean(&self) -> DVec3 {
        self.mean
    }

    fn variance_of_mean(&self) -> DVec3 {
        if self.count < 2.0 {
            return DVec3::ZERO;
        }
        self.squared / (self.count * (self.count - 1.0))
    }
}

impl Rendering {
    /// Joins renderings of the same view with disjoint samples; `None` if the sizes differ.
    ///
    /// *differs:* a pixel that lost samples to [`NonFinite`] still counts all of them as weight.
    pub fn merge(&self, other: &Rendering) -> Option<Rendering> {
        let size = |r: &Rendering| (r.mean.width, r.mean.height);
        if size(self) != size(other) {
            return None;
        }
        let [a, b] = [self.samples as f64, other.samples as f64];
        let total = a + b;
        let mut merged = self.clone();
        merged.samples += other.samples;
        merged.non_finite.extend_from_slice(&other.non_finite);
        merged.rays.closest += other.rays.closest;
        merged.rays.shadow += other.rays.shadow;
        if total == 0.0 {
            return Some(merged);
        }
        for i in 0..merged.mean.pixels.len() {
            let wide = |image: &Image| DVec3::from(image.pixels[i].map(f64::from));
            let [ma, mb] = [wide(&self.mean), wide(&other.mean)];
            let squared = wide(&self.variance) * a * (a - 1.0)
                + wide(&other.variance) * b * (b - 1.0)
                + (mb - ma) * (mb - ma) * (a * b / total);
            let mean = (ma * a + mb * b) / total;
            merged.mean.pixels[i] = mean.as_vec3().into();
            let variance = squared / (total * (total - 1.0)).max(1.0);
            merged.variance.pixels[i] = variance.as_vec3().into();
        }
        Some(merged)
    }
}
