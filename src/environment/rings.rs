//! Cells of equal solid angle: rings about the vertical axis, cut into nearly square pieces.

use std::f64::consts::{PI, TAU};

/// The partition. Every ring has a multiple of four cells, so that quarter turns map it to itself.
#[derive(Clone, Debug)]
pub(super) struct Rings {
    /// cos θ of the rings' lower edges, descending to −1.
    lower: Vec<f64>,
    /// Index of each ring's first cell, and at the end the number of cells.
    first: Vec<usize>,
}

impl Rings {
    /// About `cells` of them, at least one ring of four.
    pub fn new(cells: usize) -> Self {
        let side = (4.0 * PI / cells.max(4) as f64).sqrt();
        let rings = (PI / side).round().max(1.0) as usize;
        let mut first = vec![0];
        let mut total = 0;
        for ring in 0..rings {
            let sin = (PI * (ring as f64 + 0.5) / rings as f64).sin();
            total += 4 * ((TAU * sin / side / 4.0).round() as usize).max(1);
            first.push(total);
        }
        let lower = first[1..]
            .iter()
            .map(|&end| 1.0 - 2.0 * end as f64 / total as f64)
            .collect();
        Self { lower, first }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.first[self.first.len() - 1]
    }

    /// The cells of the ring at cos θ, in the order of φ.
    pub fn ring(&self, cos: f64) -> std::ops::Range<usize> {
        let ring = self.lower.partition_point(|&edge| edge > cos);
        let ring = ring.min(self.lower.len() - 1);
        self.first[ring]..self.first[ring + 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_have_equal_solid_angles() {
        for wanted in [1, 4, 100, 8192] {
            let rings = Rings::new(wanted);
            let mut top = 1.0;
            let cell = 4.0 * PI / rings.len() as f64;
            for (ring, &bottom) in rings.lower.iter().enumerate() {
                let cells = rings.first[ring + 1] - rings.first[ring];
                assert!((TAU * (top - bottom) / cells as f64 / cell - 1.0).abs() < 1e-9);
                assert_eq!(rings.ring(0.5 * (top + bottom)).start, rings.first[ring]);
                assert_eq!(cells % 4, 0);
                top = bottom;
            }
            assert!((top + 1.0).abs() < 1e-12);
            assert_eq!(rings.ring(-1.0).end, rings.len());
            if wanted > 50 {
                let ratio = rings.len() as f64 / wanted as f64;
                assert!((0.9..1.1).contains(&ratio), "{ratio}");
            }
        }
    }
}
