//! Irradiance of both groups of lights by normal, without shadows.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::lights::{LANES, LightArrays};

/// Values at the corners of a grid over the octahedral square (Cigolle et al. 2014).
pub(super) struct Irradiance {
    values: Vec<[Vec3; 2]>,
}

/// Cells along a side.
const SIDE: usize = 40;

impl Irradiance {
    pub fn new(lights: &LightArrays) -> Self {
        let values = (0..(SIDE + 1) * (SIDE + 1))
            .into_par_iter()
            .map(|i| {
                let corner = Vec2::new((i % (SIDE + 1)) as f32, (i / (SIDE + 1)) as f32);
                exact(lights, unfold(corner * (2.0 / SIDE as f32) - 1.0))
            })
            .collect();
        Self { values }
    }

    /// Bilinear between the normals of the grid.
    pub fn at(&self, normal: Vec3) -> [Vec3; 2] {
        let place = (fold(normal) * 0.5 + 0.5) * SIDE as f32;
        let cell = place
            .floor()
            .clamp(Vec2::ZERO, Vec2::splat(SIDE as f32 - 1.0));
        let share = place - cell;
        let first = cell.y as usize * (SIDE + 1) + cell.x as usize;
        std::array::from_fn(|group| {
            let value = |offset: usize| self.values[first + offset][group];
            let upper = value(0).lerp(value(1), share.x);
            let lower = value(SIDE + 1).lerp(value(SIDE + 2), share.x);
            upper.lerp(lower, share.y)
        })
    }
}

fn exact(lights: &LightArrays, normal: Vec3) -> [Vec3; 2] {
    let mut sums = [[[0.0f32; LANES]; 3]; 2];
    for (index, chunk) in lights.levels[0].iter().enumerate() {
        let group = lights.group(0, index);
        let [x, y, z] = &chunk.direction;
        let mut cos = [0.0; LANES];
        for i in 0..LANES {
            cos[i] = normal.x * x[i] + normal.y * y[i] + normal.z * z[i];
        }
        let mean = chunk.spread.positive(&cos);
        for (sum, power) in sums[group].iter_mut().zip(&chunk.power) {
            for i in 0..LANES {
                sum[i] += mean[i] * chunk.moment[i] * power[i];
            }
        }
    }
    sums.map(|group| Vec3::from(group.map(|lane| lane.iter().sum::<f32>())))
}

/// A unit vector on the square [-1, 1]².
fn fold(v: Vec3) -> Vec2 {
    let p = Vec2::new(v.x, v.y) / (v.x.abs() + v.y.abs() + v.z.abs());
    if v.z >= 0.0 {
        p
    } else {
        (Vec2::ONE - Vec2::new(p.y.abs(), p.x.abs())) * signs(p)
    }
}

/// The unit vector of a point of the square.
fn unfold(p: Vec2) -> Vec3 {
    let z = 1.0 - p.x.abs() - p.y.abs();
    let flat = if z >= 0.0 {
        p
    } else {
        (Vec2::ONE - Vec2::new(p.y.abs(), p.x.abs())) * signs(p)
    };
    flat.extend(z).normalize()
}

fn signs(p: Vec2) -> Vec2 {
    Vec2::new(1.0f32.copysign(p.x), 1.0f32.copysign(p.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_square_unfolds_to_where_it_was_folded_from() {
        for i in 0..500 {
            let t = i as f32;
            let v = Vec3::new((1.3 * t).sin(), (0.7 * t).cos(), (2.1 * t).sin() - 0.2);
            let v = v.normalize();
            assert!((unfold(fold(v)) - v).length() < 1e-5, "{v}");
        }
    }
}
