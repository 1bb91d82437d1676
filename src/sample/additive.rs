//! An additive low-discrepancy sequence in three dimensions.

/// Powers of the reciprocal of the real root of x⁴ = x + 1.
const STEPS: [f64; 3] = [
    0.819_172_513_396_164_4,
    0.671_043_606_703_789_3,
    0.549_700_477_901_970_5,
];

/// Point `i` of the sequence that starts at `shift`, in [0, 1)³ (Roberts 2018).
pub fn additive(shift: [f64; 3], i: u32) -> [f32; 3] {
    // The largest f32 below 1: rounding must not reach 1.
    let below_one = 1.0 - f32::EPSILON / 2.0;
    std::array::from_fn(|axis| {
        let point = (shift[axis] + f64::from(i) * STEPS[axis]).fract();
        (point as f32).min(below_one)
    })
}

#[cfg(test)]
mod tests {
    use super::additive;

    #[test]
    fn points_fill_the_cube_evenly_and_stay_below_one() {
        let points: Vec<[f32; 3]> = (0..4096).map(|i| additive([0.5; 3], i)).collect();
        assert!(points.iter().flatten().all(|u| (0.0..1.0).contains(u)));
        for octant in 0..8 {
            let inside = |p: &&[f32; 3]| (0..3).all(|a| (p[a] >= 0.5) == (octant >> a & 1 == 1));
            let count = points.iter().filter(inside).count();
            assert!(
                (480..=544).contains(&count),
                "octant {octant}: {count} of 512"
            );
        }
    }
}
