//! Interleaved sampling: which of several sets of lights a camera sample takes.

/// Position of a pixel's light set in the 4×2 pattern of interleaved sampling; the sub-pixel samples
/// of a pixel take different ones.
pub(super) fn set_of([x, y]: [usize; 2], sample: u32, sets: usize) -> usize {
    /// Neighbours are far apart in the order of sets.
    const PATTERN: [[usize; 4]; 2] = [[0, 4, 2, 6], [5, 1, 7, 3]];
    (PATTERN[y % 2][x % 4] + 3 * sample as usize) % sets
}

#[cfg(test)]
mod tests {
    use super::set_of;

    #[test]
    fn every_tile_uses_every_set() {
        for sample in 0..4 {
            let mut seen = [0; 8];
            for y in 6..8 {
                for x in 4..8 {
                    seen[set_of([x, y], sample, 8)] += 1;
                }
            }
            assert_eq!(seen, [1; 8]);
        }
        let of_pixel: Vec<usize> = (0..4).map(|s| set_of([3, 1], s, 8)).collect();
        assert!((1..4).all(|s| !of_pixel[..s].contains(&of_pixel[s])));
        assert_eq!(set_of([3, 1], 2, 1), 0);
    }
}
