//! The inner loop of all separable filters.

use std::ops::Range;

use macro_rules_attribute::apply;

use crate::instructions::compiled_for_avx512;

/// Columns that are summed in registers at a time.
const LANES: usize = 64;

/// The weighted sum of rows: `out[i] = sum over k of kernel[k] * values[starts[k] + i]`, the same on every processor.
///
/// A vertical filter passes where neighbouring image rows start, a horizontal one growing places of one padded row.
#[apply(compiled_for_avx512)]
pub(super) fn weighted_sum(values: &[f32], starts: &[usize], kernel: &[f32], out: &mut [f32]) {
    let mut start = 0;
    for block in out.chunks_mut(LANES) {
        let mut sums = [0.0_f32; LANES];
        let rows = starts.iter().zip(kernel);
        if block.len() == LANES {
            for (row, weight) in rows {
                let source = &values[row + start..][..LANES];
                for (sum, value) in sums.iter_mut().zip(source) {
                    *sum += weight * value;
                }
            }
        } else {
            for (row, weight) in rows {
                let source = &values[row + start..][..block.len()];
                for (sum, value) in sums.iter_mut().zip(source) {
                    *sum += weight * value;
                }
            }
        }
        block.copy_from_slice(&sums[..block.len()]);
        start += block.len();
    }
}

/// Copies `row` with `radius` replicas of its end values on either side.
pub(super) fn replicate_ends(row: &[f32], radius: usize, padded: &mut Vec<f32>) {
    padded.clear();
    let (Some(&first), Some(&last)) = (row.first(), row.last()) else {
        return;
    };
    padded.resize(radius, first);
    padded.extend_from_slice(row);
    padded.resize(radius + row.len() + radius, last);
}

/// Cuts `0..length` into consecutive ranges of `step`; independent of the number of threads.
pub(super) fn strips(length: usize, step: usize) -> Vec<Range<usize>> {
    (0..length)
        .step_by(step)
        .map(|start| start..(start + step).min(length))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn horizontal_sum_equals_the_definition_for_any_width() {
        let kernel = [0.25, -0.5, 1.0, 2.0, 0.125];
        for width in [1, 2, 63, 64, 65, 140] {
            let row: Vec<f32> = (0..width).map(|i| (i * i % 17) as f32).collect();
            let (mut padded, mut out) = (Vec::new(), vec![0.0; width]);
            replicate_ends(&row, 2, &mut padded);
            weighted_sum(&padded, &[0, 1, 2, 3, 4], &kernel, &mut out);
            for x in 0..width {
                let at = |k: usize| row[(x + k).saturating_sub(2).min(width - 1)];
                let expected: f32 = (0..5).map(|k| kernel[k] * at(k)).sum();
                assert!((out[x] - expected).abs() < 1e-4, "width {width} at {x}");
            }
        }
    }

    #[test]
    fn strips_cover_everything_once() {
        assert_eq!(strips(5, 2), [0..2, 2..4, 4..5]);
        assert!(strips(0, 2).is_empty());
    }
}
