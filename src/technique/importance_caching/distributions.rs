//! What records hold: three distributions over the virtual point lights, in half precision.
//!
//! A record keeps for each light its full contribution (F), its unoccluded one (U) and a bound of it
//! over the record's neighbourhood (B), as luminances divided by their largest and rounded to 16-bit
//! floats: 6 bytes a light. Running sums over blocks of 64 lights (24 bytes a block) make them
//! samplable. Densities are those of the rounded numbers, so rounding never biases an estimate; a
//! light that rounds to zero is left to the conservative distribution (C), which is uniform and not
//! stored.

use half::f16;
use half::slice::HalfFloatSliceExt;

/// Distributions that are stored: full, unoccluded, bounded.
pub const STORED: usize = 3;
/// Lights of a block.
const BLOCK: usize = 64;
/// What the largest weight becomes: the smallest that is kept is 2⁻³⁹ of it.
const LARGEST: f32 = 32_768.0;

/// The records of one job, in the batches they were evaluated in.
#[derive(Debug)]
pub struct Distributions {
    lights: usize,
    batches: Vec<Batch>,
}

/// Records evaluated together, in one buffer each.
#[derive(Debug)]
struct Batch {
    /// Index of its first record.
    first: usize,
    /// `STORED × lights` for each record.
    weights: Vec<f16>,
    /// `STORED × blocks` for each record: sums of all weights up to the end of a block.
    sums: Vec<f64>,
    /// Full contribution that a weight of 1 stands for.
    full_scale: Vec<f32>,
}

/// Where one record is written.
pub struct RecordMut<'a> {
    lights: usize,
    weights: &'a mut [f16],
    sums: &'a mut [f64],
    full_scale: &'a mut f32,
}

/// One record.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    lights: usize,
    weights: &'a [f16],
    sums: &'a [f64],
}

impl Distributions {
    /// No records yet, over `lights` lights.
    pub fn new(lights: usize) -> Self {
        Self {
            lights,
            batches: Vec::new(),
        }
    }

    /// Lights that the distributions are over.
    pub fn lights(&self) -> usize {
        self.lights
    }

    /// Number of records.
    pub fn len(&self) -> usize {
        self.batches
            .last()
            .map_or(0, |batch| batch.first + batch.full_scale.len())
    }

    /// Bytes of a record over `lights` lights.
    pub fn bytes_per_record(lights: usize) -> usize {
        STORED * (lights * size_of::<f16>() + lights.div_ceil(BLOCK) * size_of::<f64>())
            + size_of::<f32>()
    }

    /// Appends `count` empty records and returns where they are written.
    pub fn append(&mut self, count: usize) -> Vec<RecordMut<'_>> {
        let (lights, blocks) = (self.lights, self.lights.div_ceil(BLOCK));
        self.batches.push(Batch {
            first: self.len(),
            weights: vec![f16::ZERO; count * STORED * lights],
            sums: vec![0.0; count * STORED * blocks],
            full_scale: vec![0.0; count],
        });
        let Some(batch) = self.batches.last_mut().filter(|_| lights > 0) else {
            return Vec::new();
        };
        batch
            .weights
            .chunks_mut(STORED * lights)
            .zip(batch.sums.chunks_mut(STORED * blocks))
            .zip(&mut batch.full_scale)
            .map(|((weights, sums), full_scale)| RecordMut {
                lights,
                weights,
                sums,
                full_scale,
            })
            .collect()
    }

    /// A record by its index.
    pub fn record(&self, index: u32) -> Record<'_> {
        let (batch, at) = self.locate(index);
        let blocks = self.lights.div_ceil(BLOCK);
        Record {
            lights: self.lights,
            weights: &batch.weights[at * STORED * self.lights..][..STORED * self.lights],
            sums: &batch.sums[at * STORED * blocks..][..STORED * blocks],
        }
    }

    fn locate(&self, index: u32) -> (&Batch, usize) {
        let index = index as usize;
        let after = self.batches.partition_point(|batch| batch.first <= index);
        let batch = &self.batches[after - 1];
        (batch, index - batch.first)
    }

    /// Σ F over the lights, luminance.
    pub fn total(&self, index: u32) -> f32 {
        let (batch, at) = self.locate(index);
        let blocks = self.lights.div_ceil(BLOCK);
        let sums = &batch.sums[at * STORED * blocks..][..blocks];
        sums.last().map_or(0.0, |total| *total as f32) * batch.full_scale[at]
    }

    /// Σ |F_a − F_b| over the lights, luminance.
    pub fn difference(&self, a: u32, b: u32) -> f32 {
        let side = |index: u32| {
            let (batch, at) = self.locate(index);
            let weights = &batch.weights[at * STORED * self.lights..][..self.lights];
            (weights, batch.full_scale[at])
        };
        let ((of_a, scale_a), (of_b, scale_b)) = (side(a), side(b));
        let (mut block_a, mut block_b) = ([0.0f32; BLOCK], [0.0f32; BLOCK]);
        let mut total = 0.0f64;
        for (a, b) in of_a.chunks(BLOCK).zip(of_b.chunks(BLOCK)) {
            a.convert_to_f32_slice(&mut block_a[..a.len()]);
            b.convert_to_f32_slice(&mut block_b[..b.len()]);
            let pairs = block_a[..a.len()].iter().zip(&block_b[..b.len()]);
            let sum: f32 = pairs.map(|(a, b)| (a * scale_a - b * scale_b).abs()).sum();
            total += f64::from(sum);
        }
        total as f32
    }
}

impl RecordMut<'_> {
    /// Writes the luminances of one stored distribution, one for each light. Values that are not
    /// finite or negative count as zero.
    pub fn set(&mut self, kind: usize, luminances: &[f32]) {
        let usable = |v: f32| if v.is_finite() && v > 0.0 { v } else { 0.0 };
        let largest = luminances.iter().fold(0.0, |m: f32, &v| m.max(usable(v)));
        if largest == 0.0 {
            return;
        }
        // In f64: the reciprocal of a tiny f32 is infinite.
        let scale = f64::from(LARGEST) / f64::from(largest);
        let weights = &mut self.weights[kind * self.lights..][..self.lights];
        for (weight, &value) in weights.iter_mut().zip(luminances) {
            *weight = f16::from_f32((f64::from(usable(value)) * scale) as f32);
        }
        if kind == 0 {
            *self.full_scale = (1.0 / scale) as f32;
        }
        let blocks = self.lights.div_ceil(BLOCK);
        let sums = &mut self.sums[kind * blocks..][..blocks];
        let mut total = 0.0;
        for (sum, block) in sums.iter_mut().zip(weights.chunks(BLOCK)) {
            total += block.iter().map(|w| f64::from(w.to_f32())).sum::<f64>();
            *sum = total;
        }
    }
}

impl Record<'_> {
    fn sums(&self, kind: usize) -> &[f64] {
        let blocks = self.lights.div_ceil(BLOCK);
        &self.sums[kind * blocks..][..blocks]
    }

    /// Whether a stored distribution has no light at all.
    pub fn is_empty(&self, kind: usize) -> bool {
        self.sums(kind).last().is_none_or(|total| *total <= 0.0)
    }

    /// Probability of a light under a stored distribution; 0 for all lights if it is empty.
    pub fn probability(&self, kind: usize, light: usize) -> f32 {
        match self.sums(kind).last() {
            Some(total) if *total > 0.0 => {
                let weight = self.weights[kind * self.lights + light].to_f32();
                (f64::from(weight) / total) as f32
            }
            _ => 0.0,
        }
    }

    /// A light with the probability of a stored distribution, which is not empty; `u` in [0, 1).
    pub fn sample(&self, kind: usize, u: f64) -> usize {
        let sums = self.sums(kind);
        let target = u * sums[sums.len() - 1];
        let block = sums.partition_point(|&s| s <= target).min(sums.len() - 1);
        let before = if block == 0 { 0.0 } else { sums[block - 1] };
        let start = block * BLOCK;
        let weights = &self.weights[kind * self.lights..][start..self.lights.min(start + BLOCK)];
        let mut unpacked = [0.0f32; BLOCK];
        let unpacked = &mut unpacked[..weights.len()];
        weights.convert_to_f32_slice(unpacked);
        let (mut sum, mut last) = (before, 0);
        for (i, &weight) in unpacked.iter().enumerate() {
            if weight > 0.0 {
                last = i;
                sum += f64::from(weight);
                if sum > target {
                    break;
                }
            }
        }
        start + last
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    fn table(rows: &[[&[f32]; STORED]]) -> Distributions {
        let mut table = Distributions::new(rows[0][0].len());
        for (mut record, row) in table.append(rows.len()).into_iter().zip(rows) {
            (0..STORED).for_each(|kind| record.set(kind, row[kind]));
        }
        table
    }

    #[test]
    fn samples_follow_the_probabilities_and_skip_zeros() {
        let mut weights = vec![0.0f32; 200];
        for (i, w) in [(3, 1.0), (64, 2.0), (65, 4.0), (199, 1.0)] {
            weights[i] = w;
        }
        let table = table(&[[&weights; STORED]]);
        let record = table.record(0);
        let mut counts = vec![0; 200];
        let mut rng = Rng::new(1, 2, 3, 4);
        for _ in 0..80_000 {
            counts[record.sample(1, rng.next_f64())] += 1;
        }
        for (i, &count) in counts.iter().enumerate() {
            let expected = f64::from(record.probability(1, i)) * 80_000.0;
            assert!(
                (f64::from(count) - expected).abs() <= 5.0 * expected.sqrt(),
                "{i}"
            );
        }
        let total: f32 = (0..200).map(|i| record.probability(1, i)).sum();
        assert!((total - 1.0).abs() < 1e-6);
        assert_eq!(record.sample(1, 0.0), 3);
        assert_eq!(record.sample(1, 1.0 - f64::EPSILON), 199);
    }

    #[test]
    fn empty_and_broken_values_have_no_probability() {
        let zero = [0.0f32; 5];
        let broken = [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-42];
        let huge = [1e38f32, 1e-30, 0.0, 3e38, 1.0];
        let table = table(&[[&zero, &broken, &huge]]);
        let record = table.record(0);
        assert!(record.is_empty(0) && !record.is_empty(1) && !record.is_empty(2));
        assert_eq!(record.probability(0, 2), 0.0);
        assert_eq!(
            (record.probability(1, 0), record.probability(1, 4)),
            (0.0, 1.0)
        );
        assert!((record.probability(2, 3) - 0.75).abs() < 1e-3);
    }

    #[test]
    fn differences_are_in_luminance_whatever_the_scales() {
        let (a, b) = ([4.0f32, 0.0, 1.0], [1.0f32, 2.0, 1.0]);
        let zero = [0.0f32; 3];
        let mut table = table(&[[&a; STORED], [&b; STORED]]);
        for mut record in table.append(1) {
            record.set(0, &zero);
        }
        assert_eq!(table.len(), 3);
        assert!((table.difference(0, 1) - 5.0).abs() < 0.01);
        assert!((table.difference(2, 0) - 5.0).abs() < 0.01);
        assert_eq!(table.difference(1, 1), 0.0);
        table.batches.shrink_to_fit();
        let batches = size_of_val(&table.batches[..]);
        let held = crate::memory::released(table);
        assert_eq!(held, batches + 3 * Distributions::bytes_per_record(3));
    }

    #[test]
    fn twenty_five_thousand_records_of_eight_thousand_lights_fit_in_three_gib() {
        assert!(25_000 * Distributions::bytes_per_record(8192) < 3 << 29);
    }
}
