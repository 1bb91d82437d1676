//! A smooth curve through points.

use glam::DVec3;

use super::track::hermite;

/// A centripetal Catmull–Rom spline: knots are apart by the square root of the distance of their points, so that it
/// neither loops nor has cusps between close ones. Inner tangents are those of the parabola through a point and
/// its neighbours, at the ends those of the straight line; neighbouring points that are equal count once.
pub(super) struct Spline {
    /// Parallel to the points that were given: ascending, equal where neighbours are.
    knots: Vec<f64>,
    /// The points, neighbours different, with the knots and tangents (per knot) there.
    distinct: Vec<Knot>,
}

struct Knot {
    at: f64,
    point: DVec3,
    tangent: DVec3,
}

/// Steps by which lengths are measured between two points.
const STEPS: usize = 256;

impl Spline {
    /// The curve through at least one point.
    pub fn through(points: Vec<DVec3>) -> Self {
        let mut knots = Vec::with_capacity(points.len());
        let mut distinct: Vec<Knot> = Vec::new();
        for point in points {
            let at = distinct
                .last()
                .map_or(0.0, |last| last.at + last.point.distance(point).sqrt());
            knots.push(at);
            if distinct.last().is_none_or(|last| last.point != point) {
                distinct.push(Knot {
                    at,
                    point,
                    tangent: DVec3::ZERO,
                });
            }
        }
        let tangents: Vec<DVec3> = (0..distinct.len()).map(|i| tangent(&distinct, i)).collect();
        for (knot, tangent) in distinct.iter_mut().zip(tangents) {
            knot.tangent = tangent;
        }
        Self { knots, distinct }
    }

    /// Where along the curve each of the points given lies.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The place at a knot.
    pub fn position(&self, at: f64) -> DVec3 {
        let next = self.distinct.partition_point(|knot| knot.at <= at);
        if next == 0 || next == self.distinct.len() {
            return self.distinct[next.saturating_sub(1)].point;
        }
        let [from, to] = [&self.distinct[next - 1], &self.distinct[next]];
        let length = to.at - from.at;
        let tangents = [from.tangent * length, to.tangent * length];
        hermite([from.point, to.point], tangents, (at - from.at) / length)
    }

    /// The point given before a knot, and the share of the way to the next.
    pub fn between(&self, at: f64) -> (usize, f64) {
        let next = self.knots.partition_point(|&knot| knot <= at);
        if next == 0 || next == self.knots.len() {
            return (next.saturating_sub(1), 0.0);
        }
        let [from, to] = [self.knots[next - 1], self.knots[next]];
        (next - 1, (at - from) / (to - from))
    }

    /// The knot at a share of the curve's length.
    pub fn at_length(&self, share: f64) -> f64 {
        let mut lengths = vec![(0.0, 0.0)];
        let mut here = self.distinct[0].point;
        for pair in self.distinct.windows(2) {
            for step in 1..=STEPS {
                let at = pair[0].at + (pair[1].at - pair[0].at) * step as f64 / STEPS as f64;
                let there = self.position(at);
                lengths.push((lengths[lengths.len() - 1].0 + here.distance(there), at));
                here = there;
            }
        }
        let wanted = share * lengths[lengths.len() - 1].0;
        let next = lengths.partition_point(|(length, _)| *length <= wanted);
        if next == lengths.len() {
            return lengths[next - 1].1;
        }
        let [(from, low), (to, high)] = [lengths[next - 1], lengths[next]];
        low + (high - low) * (wanted - from) / (to - from)
    }
}

/// Of the parabola through a point and its neighbours; at the ends of the line to the only neighbour.
fn tangent(knots: &[Knot], i: usize) -> DVec3 {
    let slope = |a: usize| {
        let [from, to] = [&knots[a], &knots[a + 1]];
        (to.point - from.point) / (to.at - from.at)
    };
    match (i, knots.len() - 1) {
        (_, 0) => DVec3::ZERO,
        (0, _) => slope(0),
        (i, last) if i == last => slope(last - 1),
        (i, _) => {
            let [before, after] = [knots[i].at - knots[i - 1].at, knots[i + 1].at - knots[i].at];
            (slope(i - 1) * after + slope(i) * before) / (before + after)
        }
    }
}
