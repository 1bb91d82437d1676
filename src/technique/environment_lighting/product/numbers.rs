//! The numbers that choose: a lattice over the pixels, so that any few neighbours have numbers far
//! apart.

use crate::sample::Rng;

/// Keys the random shifts.
const STREAM: u64 = 0x7072_6f64_7563;

/// Numbers of the sub-pixel samples of one index.
pub(super) struct Numbers {
    shift: [f64; 3],
}

/// Powers of the reciprocal of the plastic number, and of that of three dimensions.
const LATTICE: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

impl Numbers {
    /// Shifted at random by seed and sample.
    pub fn new(seed: u64, sample: u32) -> Self {
        let mut rng = Rng::new(seed, STREAM, u64::from(sample), 0);
        Self {
            shift: std::array::from_fn(|_| rng.next_f64()),
        }
    }

    /// The number of a pixel that chooses its lights, in [0, 1).
    pub fn choice(&self, [x, y]: [usize; 2]) -> f32 {
        let lattice = x as f64 * LATTICE[0] + y as f64 * LATTICE[1];
        below_one((self.shift[0] + lattice).fract())
    }

    /// Two numbers of a ray of a pixel in [0, 1)², independent of the choice.
    pub fn point(&self, [x, y]: [usize; 2], ray: usize) -> [f32; 2] {
        let mut rng = Rng::new(
            (self.shift[1] * (1u64 << 53) as f64) as u64,
            STREAM,
            (y as u64) << 32 | x as u64,
            ray as u64,
        );
        let bits = rng.next_u64();
        [bits >> 40, bits >> 16 & 0xff_ffff].map(|b| b as f32 * (1.0 / (1u64 << 24) as f32))
    }
}

fn below_one(u: f64) -> f32 {
    (u as f32).min(1.0 - f32::EPSILON / 2.0)
}
