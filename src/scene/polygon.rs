//! Polygons of files, cut into triangles.

use glam::{DVec2, DVec3};

/// Corners of the largest polygon whose ears are cut; the time grows with the square of them, at worst with the cube.
const MOST_CORNERS: usize = 1024;

/// Triangles, as places in `corners`, that cover a polygon once, whether it is convex or not; they wind as it does.
///
/// It is the fan of the first corner where that does; otherwise ears are cut. Polygons that cross themselves, have no
/// area, or have more than a thousand corners become fans.
pub(super) fn triangles_of(corners: &[DVec3]) -> Vec<[usize; 3]> {
    match is_large(corners.len()) || fan_covers(corners) {
        true => fan_of(corners.len()),
        false => ears(&flattened(corners)).unwrap_or_else(|| fan_of(corners.len())),
    }
}

/// Whether the ears of a polygon of so many corners are not cut.
pub(super) fn is_large(corners: usize) -> bool {
    corners > MOST_CORNERS
}

/// Whether the fan of the first corner covers a polygon once.
pub(super) fn fan_covers(corners: &[DVec3]) -> bool {
    if corners.len() <= 3 {
        return true;
    }
    let flat = flattened(corners);
    let edges = flat[1..].windows(2);
    edges
        .map(|edge| doubled_area([flat[0], edge[0], edge[1]]))
        .all(|area| area >= 0.0)
}

fn fan_of(count: usize) -> Vec<[usize; 3]> {
    (1..count.saturating_sub(1))
        .map(|i| [0, i, i + 1])
        .collect()
}

/// The corners in the plane of the polygon, counter-clockwise (its normal is Newell's).
fn flattened(corners: &[DVec3]) -> Vec<DVec2> {
    let first = corners[0];
    let after = |i: usize| corners[(i + 1) % corners.len()] - first;
    let normal: DVec3 = (0..corners.len())
        .map(|i| (corners[i] - first).cross(after(i)))
        .sum();
    let Some(normal) = normal.try_normalize() else {
        return vec![DVec2::ZERO; corners.len()];
    };
    let (right, up) = normal.any_orthonormal_pair();
    let flat = corners.iter().map(|p| *p - first);
    flat.map(|p| DVec2::new(p.dot(right), p.dot(up))).collect()
}

fn doubled_area([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Cuts corners off a polygon as long as a triangle can be cut that holds no other corner; `None` where none can.
fn ears(flat: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let mut triangles = Vec::with_capacity(flat.len() - 2);
    let mut place = 0;
    while left.len() > 3 {
        let count = left.len();
        let ear = |at: usize| [count - 1, 0, 1].map(|step| left[(at + step) % count]);
        let mut places = (0..count).map(|step| (place + step) % count);
        let at = places.find(|&at| is_ear(ear(at), &left, flat))?;
        triangles.push(ear(at));
        left.remove(at);
        // The next corner but one, so that ears do not all meet in one corner.
        place = (at + 1) % left.len();
    }
    triangles.push([left[0], left[1], left[2]]);
    Some(triangles)
}

/// Whether three neighbours among the corners that are left turn to the left, or not at all, without another inside.
fn is_ear(ear: [usize; 3], left: &[usize], flat: &[DVec2]) -> bool {
    let [a, b, c] = ear.map(|i| flat[i]);
    if doubled_area([a, b, c]) < 0.0 {
        return false;
    }
    let holds = |p: DVec2| {
        let sides = [[a, b, p], [b, c, p], [c, a, p]];
        // Corners at the same place are those of a slit.
        p != a && p != b && p != c && sides.iter().all(|side| doubled_area(*side) >= 0.0)
    };
    !left.iter().any(|&i| holds(flat[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f64; 2]]) -> Vec<DVec3> {
        // In a plane that is none of the axes'.
        let (right, up) = DVec3::new(1.0, 2.0, -2.0)
            .normalize()
            .any_orthonormal_pair();
        let place = |&[x, y]: &[f64; 2]| right * x + up * y + DVec3::splat(5.0);
        corners.iter().map(place).collect()
    }

    fn areas(corners: &[DVec3]) -> (f64, f64) {
        let flat = flattened(corners);
        let area = |t: &[usize; 3]| 0.5 * doubled_area(t.map(|i| flat[i]));
        let of_triangles: Vec<f64> = triangles_of(corners).iter().map(area).collect();
        let sum = of_triangles.iter().sum();
        (sum, of_triangles.iter().map(|a| a.abs()).sum())
    }

    #[test]
    fn what_a_fan_covers_stays_a_fan() {
        for corners in [
            vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            // The first corner is the hollow one.
            vec![[0.5, 0.5], [0.0, 0.0], [2.0, 0.0], [0.0, 2.0]],
        ] {
            let corners = polygon(&corners);
            assert_eq!(triangles_of(&corners), fan_of(4));
            assert!(fan_covers(&corners));
        }
    }

    #[test]
    fn hollow_polygons_are_covered_once() {
        let arrow = [[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]];
        let comb = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 3.0],
            [4.0, 1.0],
            [3.0, 3.0],
            [2.0, 1.0],
            [1.0, 3.0],
        ];
        let letter = [
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
            [0.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
        ];
        for corners in [&arrow[..], &comb, &letter] {
            for turn in 0..corners.len() {
                let mut corners = polygon(corners);
                corners.rotate_left(turn);
                let (sum, all) = areas(&corners);
                assert!((sum - all).abs() < 1e-12, "{turn}: {sum} {all}");
                let count = triangles_of(&corners).len();
                assert_eq!(count, corners.len() - 2);
                let clockwise: Vec<DVec3> = corners.iter().rev().copied().collect();
                let (sum, all) = areas(&clockwise);
                assert!((sum - all).abs() < 1e-12, "clockwise, {turn}: {sum} {all}");
            }
        }
    }

    #[test]
    fn a_slit_to_a_hole_is_followed() {
        let corners = polygon(&[
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ]);
        let (sum, all) = areas(&corners);
        assert!(
            (sum - 8.0).abs() < 1e-12 && (all - 8.0).abs() < 1e-12,
            "{sum} {all}"
        );
    }

    #[test]
    fn whatever_has_no_sense_ends() {
        let star: Vec<[f64; 2]> = (0..5)
            .map(|i| (f64::from(i) * 0.8 * std::f64::consts::PI).sin_cos().into())
            .collect();
        for corners in [
            polygon(&star),
            vec![DVec3::ZERO; 6],
            vec![DVec3::NAN; 5],
            polygon(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]),
        ] {
            assert_eq!(triangles_of(&corners).len(), corners.len() - 2);
        }
        assert!(triangles_of(&[]).is_empty() && triangles_of(&[DVec3::ZERO]).is_empty());
    }
}
