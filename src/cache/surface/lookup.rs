//! The surface points of texels.

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::charts::Charts;
use super::grid::{BLOCK_TEXELS, BlockKey, Grid, Texel};
use super::islands::bounds;

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfacePoint {
    /// Index into the scene's triangles; [`SurfacePoint::NOWHERE`] of texels far from any.
    pub triangle: u32,
    /// Barycentric weights of the second and third corner.
    pub u: f32,
    /// See `u`.
    pub v: f32,
}

impl SurfacePoint {
    /// The triangle of texels without one.
    pub const NOWHERE: u32 = u32::MAX;

    pub(super) const NONE: Self = Self {
        triangle: Self::NOWHERE,
        u: 0.0,
        v: 0.0,
    };

    /// Whether it lies on a triangle.
    pub fn is_somewhere(&self) -> bool {
        self.triangle != Self::NOWHERE
    }
}

/// Texels around a block in which triangles are looked for: those within one of a triangle have a point.
const REACH: f32 = 2.0;
/// Least barycentric weight of points that were moved into their triangle: rays from an edge may miss what begins there.
const INSIDE: f32 = 1e-3;

/// The surface point of each texel of a block: at its centre, or where that is outside of all triangles the nearest point of
/// one of them.
pub fn surface_points(
    charts: &Charts,
    grid: &Grid,
    block: BlockKey,
) -> [SurfacePoint; BLOCK_TEXELS] {
    let side = grid.side(block.level());
    let at = |index| grid.centre(Texel { block, index });
    let low = at(0) - (0.5 + REACH) * side;
    let high = at(BLOCK_TEXELS as u32 - 1) + (0.5 + REACH) * side;
    let near = |(_, corners): &(u32, &[Vec2; 3])| {
        let (from, to) = bounds(corners);
        from.cmple(high).all() && to.cmpge(low).all()
    };
    let triangles: Vec<(u32, &[Vec2; 3])> = charts
        .members(block.surface().island)
        .filter(near)
        .collect();
    std::array::from_fn(|index| nearest(&triangles, at(index as u32)))
}

/// The nearest point of some triangles; of equal ones the first.
fn nearest(triangles: &[(u32, &[Vec2; 3])], place: Vec2) -> SurfacePoint {
    let mut best = (f32::INFINITY, SurfacePoint::NONE);
    for &(triangle, corners) in triangles {
        let (distance, [u, v]) = closest(corners, place);
        if distance < best.0 {
            best = (distance, SurfacePoint { triangle, u, v });
        }
        if distance == 0.0 {
            break;
        }
    }
    best.1
}

/// Squared distance of the nearest point of a counter-clockwise triangle, and its weights; 0 inside.
fn closest(corners: &[Vec2; 3], place: Vec2) -> (f32, [f32; 2]) {
    let [a, b, c] = *corners;
    let area = (b - a).perp_dot(c - a);
    let weight = |from: Vec2, to: Vec2| (to - from).perp_dot(place - from) / area;
    let weights = [weight(b, c), weight(c, a), weight(a, b)];
    if weights.iter().all(|w| *w >= 0.0) {
        return (0.0, [weights[1], weights[2]]);
    }
    let edges = [(a, b, 0), (b, c, 1), (c, a, 2)].map(|(from, to, edge)| {
        let along = to - from;
        let part = (place - from).dot(along) / along.length_squared();
        // Of an edge without length, its beginning.
        let part = if part.is_nan() {
            0.0
        } else {
            part.clamp(0.0, 1.0)
        };
        let distance = (from + along * part).distance_squared(place);
        (distance, edge, part)
    });
    let (distance, edge, part) = edges
        .into_iter()
        .min_by(|x, y| x.0.total_cmp(&y.0))
        .unwrap_or((f32::INFINITY, 0, 0.0));
    let [u, v] = match edge {
        0 => [part, 0.0],
        1 => [1.0 - part, part],
        _ => [0.0, 1.0 - part],
    };
    let inside = |w: f32| w * (1.0 - 3.0 * INSIDE) + INSIDE;
    (distance, [inside(u), inside(v)])
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// A square of side 4 of two triangles.
    fn square() -> Charts {
        let positions = [
            Vec3::ZERO,
            Vec3::X * 4.0,
            Vec3::new(4.0, 4.0, 0.0),
            Vec3::Y * 4.0,
        ];
        Charts::new(
            &positions,
            &[[0, 1, 2], [0, 2, 3]],
            std::slice::from_ref(&(0..2)),
        )
    }

    #[test]
    fn texels_are_where_their_centres_are_and_those_beside_are_moved_in() {
        let charts = square();
        for finest in [0.25, 1.0, 16.0] {
            let grid = Grid { finest };
            let surface = super::super::Surface {
                island: 0,
                back: false,
            };
            for (x, y) in [(0.0, 0.0), (0.1, 3.9), (2.0, 1.0), (4.0, 4.0), (3.3, 0.2)] {
                for (texel, _) in grid.around(surface, Vec2::new(x, y), 0) {
                    let points = surface_points(&charts, &grid, texel.block);
                    let point = points[texel.index as usize];
                    assert!(point.is_somewhere());
                    assert!(point.u >= 0.0 && point.v >= 0.0 && point.u + point.v <= 1.0);
                    let found = charts.place(point.triangle, [point.u, point.v]).place;
                    let wanted = grid.centre(texel).clamp(Vec2::ZERO, Vec2::splat(4.0));
                    assert!((found - wanted).length() < 0.03, "{found} {wanted}");
                }
            }
        }
    }

    #[test]
    fn texels_far_from_the_island_are_nowhere() {
        let grid = Grid { finest: 0.01 };
        let surface = super::super::Surface {
            island: 0,
            back: true,
        };
        let far = grid.nearest(surface, Vec2::splat(8.0), 0);
        let points = surface_points(&square(), &grid, far.block);
        assert!(points.iter().all(|p| !p.is_somewhere()));
    }

    #[test]
    fn the_nearest_point_of_a_sliver_is_on_it() {
        let corners = [Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::new(2.0, 1e-7)];
        for place in [
            Vec2::new(0.5, 1.0),
            Vec2::new(3.0, -1.0),
            Vec2::new(1.0, 0.0),
        ] {
            let (distance, [u, v]) = closest(&corners, place);
            assert!(distance.is_finite() && u >= 0.0 && v >= 0.0 && u + v <= 1.0001);
        }
        let point = [Vec2::ONE; 3];
        let (distance, _) = closest(&point, Vec2::ZERO);
        assert!((distance - 2.0).abs() < 1e-6);
    }
}
