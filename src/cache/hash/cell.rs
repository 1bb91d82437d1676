//! What a cell holds, and how it is packed.

use glam::{DVec3, Vec3};
use half::f16;

use crate::entry::words;

words! {
    /// How the values of cells are kept.
    pub enum Precision {
        /// Half floats, 24 bytes a cell as in the paper. Means stop moving after some thousand samples, when what a sample adds
        /// rounds to nothing.
        Half = "half",
        /// Single floats, 40 bytes a cell.
        Single = "single",
    }
}

/// The light on one side of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Side {
    pub mean: Vec3,
    /// Samples that the mean is of, as far as they can be counted.
    pub samples: u32,
}

/// A cell. Without samples it has no normal yet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cell {
    /// Front and back.
    pub sides: [Side; 2],
    /// Packed unit normal of the front: that of the cell's first sample.
    pub normal: u32,
    /// How often everything had been wiped when it was last written.
    pub stamp: u32,
}

/// Samples to be merged into one side.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    pub total: DVec3,
    pub samples: u32,
}

impl Sum {
    pub fn add(&mut self, other: Sum) {
        self.total += other.total;
        self.samples += other.samples;
    }
}

impl Cell {
    pub fn has_samples(&self) -> bool {
        self.sides.iter().any(|side| side.samples > 0)
    }
}

impl Precision {
    /// 32-bit words of a cell.
    pub(super) fn words(self) -> usize {
        match self {
            Self::Half => 6,
            Self::Single => 10,
        }
    }

    /// Samples of a side that can be counted. The paper's count has 32 bits for both sides; but the mean of one side must
    /// not be weighed with the samples of the other, so each has half of them. With more the mean is a moving one.
    pub(super) fn most_samples(self) -> u32 {
        match self {
            Self::Half => u32::from(u16::MAX),
            Self::Single => u32::MAX,
        }
    }

    /// The cell of so many words: values, normal, counts and stamp.
    pub(super) fn unpack(self, words: &[u32]) -> Cell {
        let mut cell = Cell::default();
        match self {
            Self::Half => {
                let half = |i: usize| f16::from_bits((words[i / 2] >> (16 * (i % 2))) as u16);
                for (i, side) in cell.sides.iter_mut().enumerate() {
                    side.mean = Vec3::from_array([0, 1, 2].map(|c| half(3 * i + c).to_f32()));
                    side.samples = words[4] >> (16 * i) & 0xffff;
                }
                [cell.normal, cell.stamp] = [words[3], words[5]];
            }
            Self::Single => {
                for (i, side) in cell.sides.iter_mut().enumerate() {
                    let mean = [0, 1, 2].map(|c| f32::from_bits(words[3 * i + c]));
                    side.mean = Vec3::from_array(mean);
                    side.samples = words[7 + i];
                }
                [cell.normal, cell.stamp] = [words[6], words[9]];
            }
        }
        cell
    }

    /// Writes a cell into so many words.
    pub(super) fn pack(self, cell: &Cell, words: &mut [u32]) {
        let [front, back] = cell.sides;
        match self {
            Self::Half => {
                let halves = [front.mean.to_array(), back.mean.to_array()].map(|m| m.map(to_half));
                for (pair, word) in halves.as_flattened().chunks_exact(2).zip(words.iter_mut()) {
                    *word = u32::from(pair[0]) | u32::from(pair[1]) << 16;
                }
                words[3] = cell.normal;
                words[4] = front.samples | back.samples << 16;
                words[5] = cell.stamp;
            }
            Self::Single => {
                let means = [front.mean.to_array(), back.mean.to_array()];
                for (value, word) in means.as_flattened().iter().zip(words.iter_mut()) {
                    *word = value.to_bits();
                }
                let rest = [cell.normal, front.samples, back.samples, cell.stamp];
                words[6..].copy_from_slice(&rest);
            }
        }
    }

    /// Merges samples into the mean of a side: (n·mean + sum) / (n + new).
    pub(super) fn merge(self, side: &mut Side, sum: &Sum) {
        if sum.samples == 0 {
            return;
        }
        let before = f64::from(side.samples);
        let total = side.mean.as_dvec3() * before + sum.total;
        let mean = total / (before + f64::from(sum.samples));
        // Rounding may not make a sum of the largest values infinite.
        let most = f64::from(f32::MAX);
        side.mean = mean
            .clamp(DVec3::splat(-most), DVec3::splat(most))
            .as_vec3();
        side.samples = side
            .samples
            .saturating_add(sum.samples)
            .min(self.most_samples());
    }
}

/// The nearest half float, finite.
fn to_half(value: f32) -> u16 {
    let most = f16::MAX.to_f32();
    f16::from_f32(value.clamp(-most, most)).to_bits()
}

/// Which side of a front a normal is on: 0 is the front, and what is neither, 1 the back.
pub(super) fn side_of(front: Vec3, normal: Vec3) -> usize {
    usize::from(front.dot(normal) < 0.0)
}

/// Steps from the middle of the octahedral square to its edge; the axes are exact.
const STEPS: f32 = 32767.0;

/// A direction as a point of the octahedral square in 16 bits each way (Cigolle et al. 2014), to a ten-thousandth of its length.
pub(super) fn pack_normal(normal: Vec3) -> u32 {
    let sum = normal.abs().element_sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return 0;
    }
    let p = normal / sum;
    let folded = |along: f32, across: f32| (1.0 - across.abs()).copysign(along);
    let square = if p.z < 0.0 {
        [folded(p.x, p.y), folded(p.y, p.x)]
    } else {
        [p.x, p.y]
    };
    let [x, y] = square.map(|v| u32::from((v * STEPS).round() as i16 as u16));
    x | y << 16
}

/// The unit vector of which [`pack_normal`] gives the bits.
pub(super) fn unpack_normal(packed: u32) -> Vec3 {
    let [x, y] = [packed, packed >> 16].map(|v| f32::from(v as u16 as i16) / STEPS);
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    let unfolded = |v: f32| if v < 0.0 { v + fold } else { v - fold };
    Vec3::new(unfolded(x), unfolded(y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    #[test]
    fn cells_survive_packing() {
        let side = |mean, samples| Side { mean, samples };
        let cell = Cell {
            sides: [
                side(Vec3::new(0.5, 1.25, -3.0), 65535),
                side(Vec3::new(1024.0, 0.0, 0.125), 7),
            ],
            normal: 0xdead_beef,
            stamp: 9,
        };
        for precision in [Precision::Half, Precision::Single] {
            let mut words = vec![0; precision.words()];
            precision.pack(&cell, &mut words);
            assert_eq!(precision.unpack(&words), cell, "{precision:?}");
        }
        assert_eq!(4 * Precision::Half.words(), 24);
        assert_eq!(4 * Precision::Single.words(), 40);
    }

    #[test]
    fn normals_come_back_and_axes_exactly() {
        let mut rng = Rng::new(3, 0, 0, 0);
        for _ in 0..10_000 {
            let v = Vec3::from([0; 3].map(|_: u32| rng.next_f32() - 0.5));
            let Some(normal) = v.try_normalize() else {
                continue;
            };
            let back = unpack_normal(pack_normal(normal));
            assert!((back.length() - 1.0).abs() < 1e-6);
            assert!(back.distance(normal) < 1e-4, "{normal} {back}");
        }
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            assert_eq!(unpack_normal(pack_normal(axis)), axis);
            assert_eq!(unpack_normal(pack_normal(-axis)), -axis);
        }
        assert!(unpack_normal(pack_normal(Vec3::ZERO)).is_normalized());
    }

    #[test]
    fn values_stay_finite() {
        for precision in [Precision::Half, Precision::Single] {
            let mut side = Side::default();
            let huge = Sum {
                total: DVec3::splat(f64::from(f32::MAX)) * 3.0,
                samples: 3,
            };
            precision.merge(&mut side, &huge);
            precision.merge(&mut side, &huge);
            let mut words = vec![0; precision.words()];
            let cell = Cell {
                sides: [side; 2],
                ..Cell::default()
            };
            precision.pack(&cell, &mut words);
            let [front, back] = precision.unpack(&words).sides;
            assert!(front.mean.is_finite() && front.mean == back.mean);
            assert_eq!(front.samples, 6);
        }
        assert_eq!(f16::from_bits(to_half(1e30)), f16::MAX);
        assert_eq!(f16::from_bits(to_half(-1e30)), f16::MIN);
    }

    #[test]
    fn counts_saturate_and_the_mean_then_moves() {
        let mut side = Side::default();
        let sum = |total, samples| Sum {
            total: DVec3::splat(total),
            samples,
        };
        Precision::Half.merge(&mut side, &sum(0.0, 65535));
        Precision::Half.merge(&mut side, &sum(65535.0, 65535));
        assert_eq!(side.samples, 65535);
        assert_eq!(side.mean, Vec3::splat(0.5));
        Precision::Half.merge(&mut side, &sum(65535.0, 65535));
        assert_eq!(side.mean, Vec3::splat(0.75), "older samples fade");
    }
}
