//! How thresholds grow with depth (Wu & Shen 2023, eq. 1).

/// Growth of the thresholds of view-guided clustering.
#[derive(Clone, Copy, Debug)]
pub(super) struct Growth {
    nearest: f32,
    range: f32,
    pub alpha: f32,
    /// Eq. 1 as printed.
    pub literal_sign: bool,
}

impl Growth {
    /// From the nearest to the farthest depth; `metres` converts their range to metres.
    pub fn new(nearest: f32, farthest: f32, gamma: f32, metres: f32) -> Self {
        let range = (farthest - nearest).max(0.0);
        Self {
            nearest,
            range,
            alpha: 1.0 + gamma * range * metres,
            literal_sign: false,
        }
    }

    /// σ′/σ at a depth: from 1 at the nearest to α at the farthest point. With the printed sign it
    /// falls to 2 − α, cut off at 1e-6.
    pub fn factor(&self, depth: f32) -> f32 {
        let relative = if self.range > 0.0 {
            ((depth - self.nearest) / self.range).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let change = (self.alpha - 1.0) * relative * relative;
        let factor = if self.literal_sign {
            1.0 - change
        } else {
            1.0 + change
        };
        factor.max(1e-6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_grow_to_alpha_at_the_farthest_depth() {
        let growth = Growth::new(200.0, 1700.0, 0.2, 0.01);
        assert!((growth.alpha - 4.0).abs() < 1e-6);
        assert_eq!(growth.factor(200.0), 1.0);
        assert!((growth.factor(1700.0) - growth.alpha).abs() < 1e-6);
        assert!((growth.factor(950.0) - 1.75).abs() < 1e-6);
        let literal = Growth {
            literal_sign: true,
            ..Growth::new(0.0, 2.0, 0.2, 1.0)
        };
        assert!((literal.factor(2.0) - 0.6).abs() < 1e-6, "2 − α");
        let flat = Growth::new(3.0, 3.0, 0.2, 1.0);
        assert_eq!((flat.alpha, flat.factor(3.0)), (1.0, 1.0));
    }
}
