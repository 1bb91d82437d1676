//! Edges between adjacent cells of the equal-area hemisphere grid, for translational gradients.

use glam::Vec3;

use super::square_to_hemisphere;

/// Numbers that are summed side by side.
const LANES: usize = 8;

/// For each pair of adjacent cells j, k of the `side × side` grid of
/// [`super::equal_area_hemisphere`]: `e · cos θ · m`, with e the chord of their common edge, θ the
/// polar angle of its middle and m the unit tangent across it, from j to k (local frame, z up).
///
/// When the eye moves by Δp, what is seen at distance t in the direction of the edge moves across it
/// by −m·Δp / t, so with values V the hemisphere's cosine-weighted integral changes by
/// `−Σ (V_j − V_k) · (1/t) · e cos θ m · Δp` (Ward & Heckbert 1992, on this grid).
#[derive(Clone, Debug)]
pub struct HemisphereEdges {
    side: usize,
    /// Edges between neighbours in a row, `side` for each row of which the last is empty; then
    /// those between neighbours in a column, of `side − 1` rows.
    across: [Vec<f32>; 3],
}

impl HemisphereEdges {
    /// The edges of a grid of `side` cells a side.
    pub fn new(side: usize) -> Self {
        let corner = |x: usize, y: usize| {
            square_to_hemisphere(x as f32 / side as f32, y as f32 / side as f32)
        };
        let centre = |x: usize, y: usize| {
            let at = |i: usize| (i as f32 + 0.5) / side as f32;
            square_to_hemisphere(at(x), at(y))
        };
        let mut edges = Vec::with_capacity(2 * side * side);
        for y in 0..side {
            for x in 0..side {
                edges.push(if x + 1 < side {
                    let towards = centre(x + 1, y) - centre(x, y);
                    weight(corner(x + 1, y), corner(x + 1, y + 1), towards)
                } else {
                    Vec3::ZERO
                });
            }
        }
        for y in 1..side {
            for x in 0..side {
                let towards = centre(x, y) - centre(x, y - 1);
                edges.push(weight(corner(x, y), corner(x + 1, y), towards));
            }
        }
        Self {
            side,
            across: [0, 1, 2].map(|axis| edges.iter().map(|e| e[axis]).collect()),
        }
    }

    /// `−Σ (V_j − V_k) · max(1/t_j, 1/t_k) · e cos θ m` over all edges, in the local frame.
    /// `values` and `nearness` (1/t, 0 for nothing hit) hold one number a cell, row by row.
    pub fn gradient(&self, values: &[f32], nearness: &[f32]) -> Vec3 {
        let (side, cells) = (self.side, self.side * self.side);
        if side < 2 {
            return Vec3::ZERO;
        }
        let part = |range: std::ops::Range<usize>| Cells {
            values: &values[range.clone()],
            nearness: &nearness[range],
        };
        let in_rows = cells - 1;
        let mut sums = [[0.0f32; LANES]; 3];
        let rows = self.slice(0..in_rows);
        accumulate(&mut sums, rows, part(0..in_rows), part(1..cells));
        let in_columns = cells - side;
        let columns = self.slice(cells..cells + in_columns);
        accumulate(&mut sums, columns, part(0..in_columns), part(side..cells));
        Vec3::from(sums.map(|lanes| -lanes.iter().sum::<f32>()))
    }

    /// The cells whose bit is set and that share an edge with one whose bit is not, block by block of
    /// 8 × 8 cells.
    pub fn outline(&self, bits: &[u64], cells: &mut Vec<u32>) {
        const BLOCK: usize = 8;
        let side = self.side;
        cells.clear();
        for top in (0..side).step_by(BLOCK) {
            for left in (0..side).step_by(BLOCK) {
                let width = BLOCK.min(side - left);
                let all = u64::MAX >> (64 - width);
                let row = |y: usize| run(bits, y * side + left) & all;
                for y in top..(top + BLOCK).min(side) {
                    let (own, first) = (row(y), y * side + left);
                    let before = left == 0 || is_set(bits, first - 1);
                    let after = left + width == side || is_set(bits, first + width);
                    let to_the_left = own << 1 | u64::from(before);
                    let to_the_right = own >> 1 | u64::from(after) << (width - 1);
                    let above = if y == 0 { all } else { row(y - 1) };
                    let below = if y + 1 == side { all } else { row(y + 1) };
                    let mut found = own & !(to_the_left & to_the_right & above & below);
                    while found != 0 {
                        cells.push((first + found.trailing_zeros() as usize) as u32);
                        found &= found - 1;
                    }
                }
            }
        }
    }

    /// As [`HemisphereEdges::gradient`] where cells are blocked (their bit is set, V = 0) or open (V = 1):
    /// `cells` is the outline of the bits and holds the nearness of each of its cells.
    pub fn gradient_of_outline(&self, bits: &[u64], cells: &[(u32, f32)]) -> Vec3 {
        let (side, count) = (self.side, self.side * self.side);
        let weight = |edge: usize| Vec3::from([0, 1, 2].map(|axis| self.across[axis][edge]));
        let mut sum = Vec3::ZERO;
        for &(cell, nearness) in cells {
            let i = cell as usize;
            let x = i % side;
            let mut across = Vec3::ZERO;
            if x + 1 < side && !is_set(bits, i + 1) {
                across += weight(i);
            }
            if x > 0 && !is_set(bits, i - 1) {
                across -= weight(i - 1);
            }
            if i + side < count && !is_set(bits, i + side) {
                across += weight(count + i);
            }
            if i >= side && !is_set(bits, i - side) {
                across -= weight(count + i - side);
            }
            sum += across * nearness;
        }
        sum
    }

    fn slice(&self, range: std::ops::Range<usize>) -> [&[f32]; 3] {
        [0, 1, 2].map(|axis| &self.across[axis][range.clone()])
    }
}

/// Bit `i` of a mask with one bit a direction, as bundles of rays answer.
pub fn is_set(bits: &[u64], i: usize) -> bool {
    bits[i / 64] >> (i % 64) & 1 == 1
}

/// At least eight bits from one on, fewer at the end of all.
fn run(bits: &[u64], first: usize) -> u64 {
    let (word, shift) = (first / 64, first % 64);
    let low = bits[word] >> shift;
    match bits.get(word + 1) {
        Some(next) if shift > 0 => low | next << (64 - shift),
        _ => low,
    }
}

/// The weight of the edge from `a` to `b`; `towards` tells the side of cell k.
fn weight(a: Vec3, b: Vec3, towards: Vec3) -> Vec3 {
    let along = b - a;
    let middle = (a + b).normalize_or_zero();
    let across = along.cross(middle).normalize_or_zero();
    let across = across * across.dot(towards).signum();
    across * (along.length() * middle.z.max(0.0))
}

/// Values and nearness of cells that follow one another.
#[derive(Clone, Copy)]
struct Cells<'a> {
    values: &'a [f32],
    nearness: &'a [f32],
}

/// Adds `(v_j − v_k) · max(n_j, n_k) · weight` of each edge to running sums, eight lanes wide.
fn accumulate(sums: &mut [[f32; LANES]; 3], weights: [&[f32]; 3], j: Cells, k: Cells) {
    let (of_j, of_k) = (j.values, k.values);
    let (near_j, near_k) = (j.nearness, k.nearness);
    let count = of_j.len();
    let step = |i: usize| {
        let near = if near_j[i] > near_k[i] {
            near_j[i]
        } else {
            near_k[i]
        };
        (of_j[i] - of_k[i]) * near
    };
    let whole = count / LANES * LANES;
    for start in (0..whole).step_by(LANES) {
        let mut steps = [0.0; LANES];
        for (lane, out) in steps.iter_mut().enumerate() {
            *out = step(start + lane);
        }
        for (sum, weight) in sums.iter_mut().zip(weights) {
            for (lane, sum) in sum.iter_mut().enumerate() {
                *sum += steps[lane] * weight[start + lane];
            }
        }
    }
    for i in whole..count {
        for (sum, weight) in sums.iter_mut().zip(weights) {
            sum[0] += step(i) * weight[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::equal_area_hemisphere;

    /// The view of a wall at distance `h` along +x, infinite in y and z, from a floor at z = 0.
    fn wall(side: usize, h: f32) -> (Vec<f32>, Vec<f32>, f32) {
        let directions = equal_area_hemisphere(side);
        let limit = 2.0;
        let seen = |d: &Vec3| (d.x > 0.0 && h / d.x < limit).then(|| h / d.x);
        let values: Vec<f32> = directions
            .iter()
            .map(|d| f32::from(u8::from(seen(d).is_none())))
            .collect();
        let nearness = directions
            .iter()
            .map(|d| seen(d).map_or(0.0, |t| 1.0 / t))
            .collect();
        let open = directions.iter().zip(&values).map(|(d, v)| d.z * v);
        let scale = 2.0 / directions.len() as f32;
        let value = open.sum::<f32>() * scale;
        (values, nearness, value)
    }

    #[test]
    fn nothing_changes_in_the_open_and_between_equal_values() {
        let edges = HemisphereEdges::new(16);
        let zero = vec![0.0; 256];
        assert_eq!(edges.gradient(&vec![1.0; 256], &zero), Vec3::ZERO);
        assert_eq!(edges.gradient(&vec![1.0; 256], &vec![5.0; 256]), Vec3::ZERO);
        assert_eq!(HemisphereEdges::new(1).gradient(&[1.0], &[1.0]), Vec3::ZERO);
    }

    #[test]
    fn occlusion_grows_towards_a_box_as_finite_differences_say() {
        // A tall slab whose near face is at x = 1 and whose top ends at z = 0.7, no distance limit:
        // all edges are silhouettes at known distances.
        let side = 128;
        let directions = equal_area_hemisphere(side);
        let view = |x: f32| {
            let hit = |d: &Vec3| {
                let t = (1.0 - x) / d.x;
                (d.x > 1e-6 && t * d.z < 0.7).then_some(t)
            };
            let t: Vec<Option<f32>> = directions.iter().map(hit).collect();
            let value: f32 = directions
                .iter()
                .zip(&t)
                .map(|(d, t)| if t.is_none() { d.z } else { 0.0 })
                .sum();
            (t, value * 2.0 / directions.len() as f32)
        };
        let (t, _) = view(0.0);
        let values: Vec<f32> = t.iter().map(|t| f32::from(u8::from(t.is_none()))).collect();
        let nearness: Vec<f32> = t.iter().map(|t| t.map_or(0.0, |t| 1.0 / t)).collect();
        let gradient =
            HemisphereEdges::new(side).gradient(&values, &nearness) / std::f32::consts::PI;
        let step = 0.1;
        let expected = (view(step).1 - view(-step).1) / (2.0 * step);
        assert!(
            (gradient.x - expected).abs() < 0.15 * expected.abs(),
            "{gradient} instead of {expected}"
        );
        assert!(gradient.y.abs() < 0.02 * expected.abs(), "{gradient}");
    }

    #[test]
    fn outlines_are_the_blocked_cells_beside_open_ones_and_tell_the_same_gradient() {
        for (side, threshold) in [
            (1_usize, 2),
            (3, 5),
            (8, 6),
            (13, 5),
            (32, 4),
            (32, 8),
            (32, 0),
        ] {
            let cells = side * side;
            let mut state = 9u32;
            let mut random = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                state >> 16
            };
            let blocked: Vec<bool> = (0..cells).map(|_| random() % 8 < threshold).collect();
            let mut bits = vec![0u64; cells.div_ceil(64)];
            for i in (0..cells).filter(|&i| blocked[i]) {
                bits[i / 64] |= 1 << (i % 64);
            }
            let edges = HemisphereEdges::new(side);
            let mut outline = Vec::new();
            edges.outline(&bits, &mut outline);
            let is_outline = |&i: &usize| {
                let (x, y) = (i % side, i / side);
                let open = |inside: bool, j: usize| inside && !blocked[j];
                blocked[i]
                    && (open(x > 0, i.wrapping_sub(1))
                        || open(x + 1 < side, i + 1)
                        || open(y > 0, i.wrapping_sub(side))
                        || open(y + 1 < side, i + side))
            };
            let expected: Vec<u32> = (0..cells).filter(is_outline).map(|i| i as u32).collect();
            let mut sorted = outline.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, expected, "side {side}");

            let measured: Vec<(u32, f32)> = outline
                .iter()
                .map(|&i| (i, 0.5 + random() as f32 / 65536.0))
                .collect();
            let mut nearness = vec![0.0; cells];
            measured.iter().for_each(|&(i, n)| nearness[i as usize] = n);
            let values: Vec<f32> = blocked.iter().map(|&b| f32::from(u8::from(!b))).collect();
            let whole = edges.gradient(&values, &nearness);
            let own = edges.gradient_of_outline(&bits, &measured);
            assert!(
                (whole - own).length() < 1e-4,
                "side {side}: {whole} and {own}"
            );
        }
    }

    #[test]
    fn the_gradient_points_away_from_a_wall() {
        let (values, nearness, _) = wall(32, 0.5);
        let gradient = HemisphereEdges::new(32).gradient(&values, &nearness);
        assert!(gradient.x < -0.05 && gradient.y.abs() < 1e-4, "{gradient}");
    }
}
