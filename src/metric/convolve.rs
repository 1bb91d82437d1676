//! The inner loop of all separable filters.

use std::ops::Range;

/// Columns that are summed in registers at a time.
const LANES: usize = 32;

/// The weighted sum of rows: `out[i] = sum over k of kernel[k] * rows(k)[i]`.
///
/// Every row must be at least as long as `out`. A vertical filter passes neighbouring image rows, a
/// horizontal one the same padded row at growing offsets.
pub(super) fn weighted_sum<'a>(rows: impl Fn(usize) -> &'a [f32], kernel: &[f32], out: &mut [f32]) {
    let mut start = 0;
    for block in out.chunks_mut(LANES) {
        let mut sums = [0.0_f32; LANES];
        if block.len() == LANES {
            for (k, &weight) in kernel.iter().enumerate() {
                let source = &rows(k)[start..start + LANES];
                for (sum, &value) in sums.iter_mut().zip(source) {
                    *sum += weight * value;
                }
            }
        } else {
            for (k, &weight) in kernel.iter().enumerate() {
                let source = &rows(k)[start..start + block.len()];
                for (sum, &value) in sums.iter_mut().zip(source) {
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
        for width in [1, 2, 31, 32, 33, 70] {
            let row: Vec<f32> = (0..width).map(|i| (i * i % 17) as f32).collect();
            let (mut padded, mut out) = (Vec::new(), vec![0.0; width]);
            replicate_ends(&row, 2, &mut padded);
            weighted_sum(|k| &padded[k..], &kernel, &mut out);
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
