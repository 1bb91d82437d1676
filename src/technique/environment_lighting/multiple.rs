//! Multiple importance sampling of map and surface at a point (Veach & Guibas 1995).

use glam::Vec3;

use super::illumination::Illumination;
use crate::sample::Rng;
use crate::shade::Interaction;
use crate::trace::Caster;

/// How many samples of which kind.
#[derive(Clone, Copy, Debug)]
pub(super) struct Samples {
    pub light: u32,
    pub surface: u32,
    /// Whether the samples of a point form scrambled (0,2)-sequences.
    pub stratified: bool,
}

/// The estimator.
pub(super) struct MultipleImportance<'a> {
    illumination: &'a Illumination<'a>,
    samples: Samples,
    seed: u64,
    /// Whether lights are drawn from the compensated density.
    compensated: bool,
}

/// Key the random numbers of light and surface samples.
const STREAMS: [u64; 2] = [0x6d69_736c, 0x6d69_7373];

impl<'a> MultipleImportance<'a> {
    pub fn new(illumination: &'a Illumination<'a>, samples: Samples, seed: u64) -> Self {
        Self {
            illumination,
            samples,
            seed,
            compensated: false,
        }
    }

    /// Draws lights from the density of MIS compensation (Karlík et al. 2019).
    pub fn compensated(mut self, compensated: bool) -> Self {
        self.compensated = compensated;
        self
    }

    /// Exposed radiance towards the viewer; `key` is the pixel and the sample.
    pub fn radiance(&self, caster: &Caster, at: &Interaction, key: [u32; 2]) -> Vec3 {
        let light = match at.bsdf.is_delta() {
            true => Vec3::ZERO,
            false => self.by_light(caster, at, self.sequence(0, key)),
        };
        light + self.by_surface(caster, at, self.sequence(1, key))
    }

    fn sequence(&self, kind: usize, [pixel, sample]: [u32; 2]) -> Sequence {
        let rng = Rng::new(
            self.seed,
            STREAMS[kind],
            u64::from(pixel),
            u64::from(sample),
        );
        Sequence::new(rng, self.samples.stratified)
    }

    fn by_light(&self, caster: &Caster, at: &Interaction, mut sequence: Sequence) -> Vec3 {
        let (illumination, samples) = (self.illumination, self.samples);
        let mut sum = Vec3::ZERO;
        for index in 0..samples.light {
            let [_, u, v] = sequence.point(index);
            let sampled = match self.compensated {
                true => illumination.environment.compensated_sample([u, v]),
                false => illumination.environment.sample([u, v]),
            };
            let Some(light) = sampled else {
                return Vec3::ZERO;
            };
            let radiance = Vec3::from(light.radiance) * illumination.scale;
            let reflected = at.evaluate(light.direction) * radiance;
            if reflected == Vec3::ZERO || !illumination.sees(caster, at, light.direction) {
                continue;
            }
            let own = light.pdf_sr * samples.light as f32;
            let other = at.pdf(light.direction) * samples.surface as f32;
            sum += reflected * (power_heuristic(own, other) / own);
        }
        sum
    }

    fn by_surface(&self, caster: &Caster, at: &Interaction, mut sequence: Sequence) -> Vec3 {
        let (illumination, samples) = (self.illumination, self.samples);
        let mut sum = Vec3::ZERO;
        for index in 0..samples.surface {
            let u = sequence.point(index).map(below_one);
            let Some(sample) = at.sample(u) else { continue };
            let map = illumination.environment;
            let (radiance, pdf) = map.radiance_and_pdf(sample.direction, self.compensated);
            let reflected = sample.weight * Vec3::from(radiance) * illumination.scale;
            if reflected == Vec3::ZERO || !illumination.sees(caster, at, sample.direction) {
                continue;
            }
            let weight = if sample.delta {
                1.0
            } else {
                let own = sample.pdf_sr * samples.surface as f32;
                let other = pdf * samples.light as f32;
                power_heuristic(own, other)
            };
            sum += reflected * (weight / samples.surface as f32);
        }
        sum
    }
}

/// Veach's power heuristic with exponent 2; the densities count their samples.
fn power_heuristic(own: f32, other: f32) -> f32 {
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}

/// Rounds to single precision, downwards at the end.
fn below_one(u: f64) -> f32 {
    (u as f32).min(1.0 - f32::EPSILON / 2.0)
}

/// Points in [0, 1)³: independent, or an additive sequence beside the first two dimensions of
/// Sobol's sequence, each scrambled anew. Every single point is uniform.
struct Sequence {
    rng: Rng,
    /// Shift of the first coordinate and scrambles of the others; `None` for independent points.
    scrambles: Option<(f64, [u32; 2])>,
}

impl Sequence {
    fn new(mut rng: Rng, stratified: bool) -> Self {
        let scrambles = stratified.then(|| {
            let shift = rng.next_f64();
            let bits = rng.next_u64();
            (shift, [bits as u32, (bits >> 32) as u32])
        });
        Self { rng, scrambles }
    }

    fn point(&mut self, index: u32) -> [f64; 3] {
        const UNIT: f64 = 1.0 / (1u64 << 32) as f64;
        /// The golden ratio's fraction.
        const STEP: f64 = 0.618_033_988_749_894_9;
        match self.scrambles {
            None => std::array::from_fn(|_| self.rng.next_f64()),
            Some((shift, [a, b])) => [
                (shift + f64::from(index) * STEP).fract(),
                f64::from(index.reverse_bits() ^ a) * UNIT,
                f64::from(sobol_second(index) ^ b) * UNIT,
            ],
        }
    }
}

/// The second dimension of Sobol's sequence as bits of a fraction.
fn sobol_second(mut index: u32) -> u32 {
    let (mut direction, mut bits) = (1u32 << 31, 0);
    while index != 0 {
        if index & 1 != 0 {
            bits ^= direction;
        }
        direction ^= direction >> 1;
        index >>= 1;
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stratified_points_fill_every_elementary_interval() {
        let mut sequence = Sequence::new(Rng::new(5, 6, 7, 8), true);
        let points: Vec<[f64; 3]> = (0..64).map(|i| sequence.point(i)).collect();
        for log in 0..=6 {
            let (columns, rows) = (1usize << log, 64usize >> log);
            let mut seen = [false; 64];
            for [_, u, v] in &points {
                let cell = (u * columns as f64) as usize * rows + (v * rows as f64) as usize;
                assert!(!seen[cell], "two points in a {columns}×{rows} cell");
                seen[cell] = true;
            }
        }
    }

    #[test]
    fn surface_coordinates_stay_below_one() {
        assert!(below_one(1.0 - f64::EPSILON) < 1.0);
        assert_eq!(below_one(0.25), 0.25);
    }
}
