//! Random numbers as a pure function of (seed, stream, item, sample, dimension).

/// One step of a 64-bit finaliser (SplitMix64's mixing function).
pub fn hash(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A stream of random numbers that depends on its keys alone, never on the thread that draws it.
#[derive(Clone, Debug)]
pub struct Rng {
    key: u64,
    dimension: u64,
}

impl Rng {
    /// `stream` separates uses (camera, lights, placement…), `item` the pixel, record or path,
    /// `sample` the repetition.
    pub fn new(seed: u64, stream: u64, item: u64, sample: u64) -> Self {
        let key = hash(hash(hash(hash(seed) ^ stream) ^ item) ^ sample);
        Self { key, dimension: 0 }
    }

    /// The next 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.dimension += 1;
        hash(self.key ^ self.dimension.wrapping_mul(0xd605_1d6e_35a5_b6c3))
    }

    /// Uniform in [0, 1), never 1.
    pub fn next_f32(&mut self) -> f32 {
        (self.next_u64() >> 40) as f32 * (1.0 / (1u64 << 24) as f32)
    }

    /// Uniform in [0, 1), never 1.
    pub fn next_f64(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in 0..n; 0 for n = 0. The bias of the multiply-shift is below n / 2⁶⁴.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.next_u64()) * n as u128) >> 64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_stay_below_one_and_fill_the_interval() {
        let mut rng = Rng::new(1, 2, 3, 4);
        let values: Vec<f32> = (0..100_000).map(|_| rng.next_f32()).collect();
        assert!(values.iter().all(|v| (0.0..1.0).contains(v)));
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        assert!((mean - 0.5).abs() < 0.005, "mean {mean}");
    }

    #[test]
    fn streams_with_different_keys_differ() {
        let draw = |s, i, k| Rng::new(7, s, i, k).next_u64();
        assert_eq!(draw(1, 2, 3), draw(1, 2, 3));
        assert_ne!(draw(1, 2, 3), draw(2, 2, 3));
        assert_ne!(draw(1, 2, 3), draw(1, 3, 3));
        assert_ne!(draw(1, 2, 3), draw(1, 2, 4));
    }
}
