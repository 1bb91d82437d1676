use super::*;
use crate::sample::Rng;

/// Every triangle is in one island, none covers another, and none is stretched by more than twice.
fn assert_sound(positions: &[Vec3], triangles: &[[u32; 3]], islands: &[Island]) {
    let mut seen = vec![0; triangles.len()];
    for island in islands {
        assert!(island.triangles.len() <= MOST_TRIANGLES);
        for (i, (triangle, corners)) in island.triangles.iter().zip(&island.corners).enumerate() {
            seen[*triangle as usize] += 1;
            let [a, b, c] = *corners;
            let [p, q, r] = triangles[*triangle as usize].map(|i| positions[i as usize]);
            let flat = 0.5 * (b - a).perp_dot(c - a);
            let area = 0.5 * (q - p).cross(r - p).length();
            let ratio = area / flat;
            assert!((0.999..2.001).contains(&ratio), "{ratio}");
            assert!(
                corners
                    .iter()
                    .all(|p| p.cmpge(Vec2::ZERO).all() && p.cmple(island.size).all())
            );
            assert!(
                !island.corners[..i]
                    .iter()
                    .any(|other| covers(other, corners))
            );
        }
    }
    assert!(seen.iter().all(|n| *n == 1));
}

/// A sheet of `side`² squares with heights.
fn sheet(side: u32, height: impl Fn(u32, u32) -> f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for y in 0..=side {
        for x in 0..=side {
            positions.push(Vec3::new(x as f32, y as f32, height(x, y)));
            if x < side && y < side {
                let i = y * (side + 1) + x;
                triangles.push([i, i + 1, i + side + 2]);
                triangles.push([i, i + side + 2, i + side + 1]);
            }
        }
    }
    (positions, triangles)
}

#[test]
fn flat_sheets_are_islands_of_256_triangles() {
    let (positions, triangles) = sheet(32, |_, _| 0.0);
    let found = islands(&positions, &triangles);
    assert_sound(&positions, &triangles, &found);
    assert!((8..24).contains(&found.len()), "{}", found.len());
}

#[test]
fn rough_sheets_and_soups_are_split_soundly() {
    let mut rng = Rng::new(5, 0, 0, 0);
    let heights: Vec<f32> = (0..4096).map(|_| 3.0 * rng.next_f32()).collect();
    let (positions, triangles) = sheet(30, |x, y| heights[(y * 40 + x) as usize]);
    assert_sound(&positions, &triangles, &islands(&positions, &triangles));
    let soup: Vec<Vec3> = (0..300)
        .map(|_| Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()))
        .collect();
    let triangles: Vec<[u32; 3]> = (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let found = islands(&soup, &triangles);
    assert_eq!(found.len(), 100, "nothing is connected");
    assert_sound(&soup, &triangles, &found);
}

/// A ramp that winds around an axis covers itself after a turn.
#[test]
fn a_spiral_does_not_cover_itself() {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..100u32 {
        let (sine, cosine) = (i as f32 * 0.2).sin_cos();
        for radius in [1.0, 2.0] {
            positions.push(Vec3::new(radius * cosine, radius * sine, i as f32 * 0.05));
        }
        if i > 0 {
            let [a, b, c, d] = [2 * i - 2, 2 * i - 1, 2 * i, 2 * i + 1];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    let found = islands(&positions, &triangles);
    assert_sound(&positions, &triangles, &found);
    assert!(found.len() >= 3, "{} islands of three turns", found.len());
}

#[test]
fn corners_of_one_place_are_one_and_edges_of_three_triangles_are_cut() {
    // Two triangles of a square with corners of their own, and a fin on their common edge.
    let positions = [
        Vec3::ZERO,
        Vec3::X,
        Vec3::ONE.with_z(0.0),
        Vec3::new(-0.0, 0.0, 0.0),
        Vec3::ONE.with_z(0.0),
        Vec3::Y,
        Vec3::ZERO,
        Vec3::ONE.with_z(0.0),
        Vec3::new(0.5, 0.5, 1.0),
    ];
    let square = [[0, 1, 2], [3, 4, 5]];
    assert_eq!(islands(&positions, &square).len(), 1);
    let with_fin = [[0, 1, 2], [3, 4, 5], [6, 7, 8]];
    let found = islands(&positions, &with_fin);
    assert_eq!(found.len(), 3);
    assert_sound(&positions, &with_fin, &found);
    // The same triangle twice, and its back.
    let twice = [[0, 1, 2], [0, 1, 2], [0, 2, 1]];
    assert_sound(&positions, &twice, &islands(&positions, &twice));
}

#[test]
fn scale_and_place_change_nothing_but_the_size() {
    let heights = |x: u32, y: u32| ((x * 7 + y * 3) % 5) as f32 * 0.4;
    let (positions, triangles) = sheet(12, heights);
    let plain = islands(&positions, &triangles);
    for (scale, offset) in [(1e-3, 0.0), (1e5, 0.0), (1.0, 64.0)] {
        let moved: Vec<Vec3> = positions.iter().map(|p| *p * scale + offset).collect();
        let found = islands(&moved, &triangles);
        assert_eq!(found.len(), plain.len());
        for (a, b) in found.iter().zip(&plain) {
            assert_eq!(a.triangles, b.triangles);
            assert!((a.size / scale - b.size).length() < 1e-3 * b.size.length());
        }
    }
}
