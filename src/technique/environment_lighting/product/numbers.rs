//! The numbers that choose: a lattice over the pixels, so that any few neighbours have numbers far
//! apart.

use crate::sample::Rng;

/// Keys the random shifts.
const STREAM: u64 = 0x7072_6f64_7563;

/// Numbers of the sub-pixel samples of one index.
pub(super) struct PixelNumbers {
    shift: f64,
    seed: u64,
    jitter: f64,
}

/// Powers of the reciprocal of the plastic number.
const LATTICE: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

impl PixelNumbers {
    /// Shifted at random by seed and sample; `jitter` is the random part of a pixel's number.
    pub fn new(seed: u64, jitter: f32, sample: u32) -> Self {
        let mut rng = Rng::new(seed, STREAM, u64::from(sample), 0);
        Self {
            shift: rng.next_f64(),
            seed: rng.next_u64(),
            jitter: f64::from(jitter),
        }
    }

    /// The number of a pixel that chooses its lights, in [0, 1).
    pub fn choice(&self, [x, y]: [usize; 2]) -> f32 {
        let lattice = x as f64 * LATTICE[0] + y as f64 * LATTICE[1];
        let jitter = match self.jitter > 0.0 {
            true => self.jitter * self.random([x, y], u64::MAX).next_f64(),
            false => 0.0,
        };
        below_one((self.shift + lattice + jitter).fract())
    }

    /// Two numbers of a ray of a pixel in [0, 1)², independent of the choice.
    pub fn point(&self, pixel: [usize; 2], ray: usize) -> [f32; 2] {
        let mut rng = self.random(pixel, ray as u64);
        [rng.next_f32(), rng.next_f32()]
    }

    fn random(&self, [x, y]: [usize; 2], item: u64) -> Rng {
        Rng::new(self.seed, STREAM, (y as u64) << 32 | x as u64, item)
    }
}

fn below_one(u: f64) -> f32 {
    (u as f32).min(1.0 - f32::EPSILON / 2.0)
}
