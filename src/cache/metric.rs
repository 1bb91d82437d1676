//! Distances between positions with normals, and the weights made of them.

use super::search::Neighbour;

/// The combined distance of Wu & Shen, eq. 2 and 5: `|Δp| + lambda · sqrt(1 − n·n′)`, scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceMetric {
    /// Weight of the angular term in scene units.
    pub lambda: f32,
}

impl DistanceMetric {
    /// The printed λ = 0.5 / L, read in metres.
    ///
    /// With `L = diagonal · m` metres (m metres per unit), the paper's distance in metres is
    /// `m·|Δp| + 0.5/(diagonal·m) · a`. Divided by m, to be in scene units, the weight of the
    /// angular term a is `0.5 / (diagonal · m²)`. So a scene that is rescaled together with its
    /// declaration keeps its neighbours. 0 for a diagonal or m that is not positive and finite.
    pub fn literal(diagonal: f32, metres_per_unit: f32) -> Self {
        let metres = f64::from(metres_per_unit);
        Self::checked(0.5 / (f64::from(diagonal) * metres * metres))
    }

    /// The scale-free relative λ = 0.5 · L · κ; useful values of κ are 0.01 to 0.1.
    ///
    /// *differs:* from the printed 0.5 / L, which is not scale invariant.
    pub fn scaled(kappa: f32, diagonal: f32) -> Self {
        Self::checked(0.5 * f64::from(kappa) * f64::from(diagonal))
    }

    fn checked(lambda: f64) -> Self {
        let lambda = lambda as f32;
        let usable = lambda.is_finite() && lambda > 0.0;
        Self {
            lambda: if usable { lambda } else { 0.0 },
        }
    }

    /// The distance for a squared Euclidean distance (scene units²) and the cosine of the angle
    /// between the normals. Bends within the rounding of a dot product (0.06°) count as none, so that
    /// a record lies at distance 0 from itself.
    #[inline(always)]
    pub fn distance(self, squared: f32, cosine: f32) -> f32 {
        const ROUNDING: f32 = 5e-7;
        let bend = 1.0 - cosine;
        let bend = if bend > ROUNDING { bend } else { 0.0 };
        squared.sqrt() + self.lambda * bend.sqrt()
    }
}

/// A distance that grows fast off the tangent plane: `D² = |Δp|² + (across · pl)² + bend² (1 − n·n′)`
/// with `pl` the larger of the distances of either point from the other's tangent plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentMetric {
    /// Weight of the distance from the tangent plane.
    pub across: f32,
    /// Length that a bend of 90° counts as, scene units.
    pub bend: f32,
}

impl TangentMetric {
    /// D for a squared Euclidean distance, the distance from the tangent plane and the cosine of
    /// the angle between the normals. NaN only if an argument is.
    #[inline(always)]
    pub fn distance(self, squared: f32, plane: f32, cosine: f32) -> f32 {
        let off = self.across * plane;
        let turn = self.bend * self.bend * (1.0 - cosine);
        // Rounding of a dot product may leave it a little negative.
        let turn = if turn > 0.0 { turn } else { 0.0 };
        (squared + off * off + turn).sqrt()
    }
}

/// What the records of a lookup are ranked by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ranking {
    /// Distance in space, and the bend between normals.
    Combined(DistanceMetric),
    /// The same, with weight on the distance off the tangent plane.
    Tangent(TangentMetric),
}

impl Ranking {
    /// The distance, at least √`squared`; of [`Ranking::Combined`] `plane` is not looked at.
    #[inline(always)]
    pub fn distance(self, squared: f32, plane: f32, cosine: f32) -> f32 {
        match self {
            Self::Combined(metric) => metric.distance(squared, cosine),
            Self::Tangent(metric) => metric.distance(squared, plane, cosine),
        }
    }
}

/// Records near a shading point with their weights, which sum to 1.
#[derive(Clone, Copy, Debug)]
pub struct Weighted<'a> {
    /// The records and how far away they are.
    pub neighbours: &'a [Neighbour],
    /// One of each.
    pub weights: &'a [f32],
}

impl<'a> Weighted<'a> {
    /// Records and weights.
    pub fn iter(self) -> impl Iterator<Item = (u32, f32)> + use<'a> {
        let records = self.neighbours.iter().map(|neighbour| neighbour.record);
        records.zip(self.weights.iter().copied())
    }
}

/// Writes the normalised weights `1 / Dᵖ` of `neighbours`, p = `power`; `weights` must be as long.
///
/// Distances are raised to 1e-6 · `diagonal`; neighbours closer than 1e-9 · `diagonal` share all
/// the weight equally, so that a query at a record returns that record's value and coincident
/// records return their mean. Weights sum to 1 within rounding.
pub fn inverse_distance_weights(
    neighbours: &[Neighbour],
    diagonal: f32,
    power: i32,
    weights: &mut [f32],
) {
    let exact = |n: &Neighbour| n.distance <= 1e-9 * diagonal;
    let coincident = neighbours.iter().filter(|n| exact(n)).count();
    let pairs = weights.iter_mut().zip(neighbours);
    if coincident > 0 {
        let share = 1.0 / coincident as f32;
        pairs.for_each(|(weight, n)| *weight = if exact(n) { share } else { 0.0 });
        return;
    }
    let least = f64::from(diagonal) * 1e-6;
    let inverse = |n: &Neighbour| f64::from(n.distance).max(least).powi(-power);
    let total: f64 = neighbours.iter().map(inverse).sum();
    pairs.for_each(|(weight, n)| *weight = (inverse(n) / total) as f32);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weights(distances: &[f32], diagonal: f32) -> Vec<f32> {
        let neighbours: Vec<_> = distances
            .iter()
            .map(|&distance| Neighbour {
                record: 0,
                distance,
            })
            .collect();
        let mut out = vec![9.0; distances.len()];
        inverse_distance_weights(&neighbours, diagonal, 1, &mut out);
        out
    }

    #[test]
    fn weights_are_inverse_distances_and_exact_at_records() {
        assert!(weights(&[], 10.0).is_empty());
        let w = weights(&[1.0, 2.0, 4.0], 10.0);
        assert!((w[0] - 4.0 / 7.0).abs() < 1e-6 && (w[2] - 1.0 / 7.0).abs() < 1e-6);
        assert_eq!(weights(&[0.0, 1e-10, 3.0], 10.0), [0.5, 0.5, 0.0]);
        assert_eq!(weights(&[0.0, 0.0], 0.0), [0.5, 0.5]);
        assert_eq!(weights(&[f32::MAX, f32::MAX], 1.0), [0.5, 0.5]);
        let near = weights(&[2e-9 * 10.0, 3e-7 * 10.0], 10.0);
        assert_eq!(near, [0.5, 0.5], "both are raised to the least distance");
    }

    #[test]
    fn the_literal_weight_follows_the_declared_scale() {
        let metres = DistanceMetric::literal(10.0, 1.0);
        assert_eq!(metres.lambda, 0.05);
        let centimetres = DistanceMetric::literal(1000.0, 0.01);
        assert!((centimetres.lambda - 100.0 * metres.lambda).abs() < 1e-5);
        assert_eq!(DistanceMetric::literal(0.0, 1.0).lambda, 0.0);
        assert_eq!(DistanceMetric::literal(f32::NAN, 1.0).lambda, 0.0);
        assert_eq!(DistanceMetric::scaled(0.05, 10.0).lambda, 0.25);
    }
}
