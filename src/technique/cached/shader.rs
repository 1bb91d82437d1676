//! Shades an image from finished records.

use glam::Vec3;

use super::Records;
use super::lookup::MOST_USED;
use crate::cache::inverse_distance_weights;
use crate::image::Image;
use crate::technique::shot::look_band;
use crate::technique::{Seen, Shot};
use crate::trace::RayCounter;

/// Shades all samples of a shot from finished records.
pub(super) struct Shader<'a> {
    pub shot: &'a Shot<'a>,
    pub records: &'a Records<'a>,
    pub counter: &'a RayCounter,
}

impl Shader<'_> {
    /// The image, the number of lookups and the number of non-finite values left out.
    pub fn image(&self) -> (Image, u64, u64) {
        /// Rows that are gathered before their lookups: bounds memory at any resolution.
        const BAND: usize = 64;
        let mut image = Image::new(self.shot.width, self.shot.height);
        let (mut lookups, mut non_finite) = (0, 0);
        for top in (0..self.shot.height).step_by(BAND) {
            let bottom = (top + BAND).min(self.shot.height);
            let samples = look_band(self.shot, self.counter, top..bottom, self.shot.spp);
            let values = self.values(&samples);
            lookups += samples.len() as u64;
            non_finite += self.film(top, &samples, &values, &mut image);
        }
        (image, lookups, non_finite)
    }

    fn values(&self, samples: &[Seen]) -> Vec<[f32; 3]> {
        let positions: Vec<Vec3> = samples.iter().map(|s| s.site.position).collect();
        let normals: Vec<Vec3> = samples.iter().map(|s| s.site.normal).collect();
        let function = self.records.function.as_ref();
        let how = (self.shot.scene.diagonal, self.records.interpolation.power());
        let caster = || self.shot.tracer.caster(self.counter);
        self.records.search.map_with(
            &positions,
            &normals,
            (caster, |caster, query, neighbours| {
                let mut weights = [0.0; MOST_USED];
                let weights = &mut weights[..neighbours.len()];
                inverse_distance_weights(neighbours, how, weights);
                function.shade(caster, &samples[query], (neighbours, weights))
            }),
        )
    }

    /// Averages the samples of each pixel; background samples take the background's value.
    fn film(&self, top: usize, samples: &[Seen], values: &[[f32; 3]], image: &mut Image) -> u64 {
        let width = self.shot.width;
        let rows = (self.shot.height - top).min(64);
        let mut sums = vec![([0.0f64; 3], 0u32); rows * width];
        let mut non_finite = 0;
        for (sample, value) in samples.iter().zip(values) {
            let (sum, hits) = &mut sums[sample.pixel as usize - top * width];
            *hits += 1;
            if value.iter().all(|v| v.is_finite()) {
                (0..3).for_each(|c| sum[c] += f64::from(value[c]));
            } else {
                non_finite += 1;
            }
        }
        let background = self.records.function.background();
        for (pixel, (sum, hits)) in image.pixels[top * width..].iter_mut().zip(&sums) {
            let open = f64::from(self.shot.spp - hits);
            *pixel = std::array::from_fn(|c| {
                ((sum[c] + open * f64::from(background[c])) / f64::from(self.shot.spp)) as f32
            });
        }
        non_finite
    }
}
