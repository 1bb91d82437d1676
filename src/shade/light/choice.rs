//! How often each light is chosen.

use std::ops::Range;

use super::guide::Guide;
use super::{Lights, point, usable};

/// What the choice among lights depends on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Total {
    power: f64,
    /// Lights that have some.
    count: usize,
}

impl Total {
    pub fn of(powers: impl IntoIterator<Item = f64>) -> Self {
        let mut all = Self::default();
        for power in powers {
            all.power += power;
            all.count += usize::from(power > 0.0);
        }
        all
    }

    /// Probability of a light with a part of the power.
    pub fn chance(&self, power: f64) -> f64 {
        match power > 0.0 && self.power.is_finite() {
            true => 0.5 * (power / self.power + 1.0 / self.count as f64),
            false => 0.0,
        }
    }
}

/// A shape with power, among the emitting triangles.
pub(super) struct EmittingShape {
    pub triangles: Range<usize>,
    /// Power of all emitting triangles before it, and with it.
    pub sums: [f64; 2],
}

impl EmittingShape {
    pub fn power(&self) -> f64 {
        self.sums[1] - self.sums[0]
    }
}

impl Lights<'_> {
    /// Sets the probabilities of all lights, and densities of triangles.
    pub(super) fn set_chances(&mut self) {
        self.all = self.total();
        self.triangle_sums = self.choose_triangles();
        self.triangle_guide = Guide::new(&self.triangle_sums);
        let shapes = self.emitting_shapes();
        let shapes = shapes.map(|shape| self.all.chance(shape.power()));
        let points = 0..self.scene.point_lights.len();
        let points: Vec<_> = points.map(|index| self.point_chance(index)).collect();
        let parallel = 0..self.scene.directional_lights.len();
        let parallel: Vec<_> = parallel.map(|index| self.parallel_chance(index)).collect();
        let sky = self.all.chance(self.sky_power());
        self.groups = [
            shapes.sum(),
            points.iter().sum(),
            parallel.iter().sum(),
            sky,
        ];
        [self.point_sums, self.parallel_sums] = [running(&points), running(&parallel)];
    }

    fn total(&self) -> Total {
        let shapes = self.emitting_shapes().map(|shape| shape.power());
        let points = self.scene.point_lights.iter().map(point::power);
        let parallel = 0..self.scene.directional_lights.len();
        let parallel = parallel.map(|index| self.parallel_power(index));
        let sky = [self.sky_power()];
        Total::of(shapes.chain(points).chain(parallel).chain(sky))
    }

    /// Sets the densities of triangles; running sums of their probabilities.
    fn choose_triangles(&mut self) -> Vec<f64> {
        let mut chances = vec![0.0; self.triangles.len()];
        let shapes: Vec<_> = self.emitting_shapes().collect();
        for shape in shapes {
            let of_unit_power = self.all.chance(shape.power()) / shape.power();
            for index in shape.triangles {
                let power = self.power_before(index + 1) - self.power_before(index);
                chances[index] = power * of_unit_power;
                let light = &mut self.triangles[index];
                light.pdf_area = (radiant_exitance(light.emission.into()) * of_unit_power) as f32;
            }
        }
        running(&chances)
    }

    /// The shapes whose triangles have some power.
    pub(super) fn emitting_shapes(&self) -> impl Iterator<Item = EmittingShape> {
        let shapes = self.scene.shapes.iter().zip(&self.first_of_shape);
        shapes.filter_map(|(shape, first)| {
            let first = (*first)? as usize;
            let triangles = first..first + shape.triangle_count as usize;
            let found = EmittingShape {
                sums: [triangles.start, triangles.end].map(|index| self.power_before(index)),
                triangles,
            };
            (found.power() > 0.0).then_some(found)
        })
    }

    /// Power of all emitting triangles before one.
    fn power_before(&self, index: usize) -> f64 {
        index.checked_sub(1).map_or(0.0, |i| self.triangle_power[i])
    }

    /// Probability with which [`Lights::sample`] selects a directional light.
    pub(super) fn parallel_chance(&self, index: usize) -> f64 {
        self.all.chance(self.parallel_power(index))
    }

    fn parallel_power(&self, index: usize) -> f64 {
        let (_, irradiance) = self.scene.directional_lights[index];
        usable(irradiance) * self.disk()
    }

    fn sky_power(&self) -> f64 {
        let sky = self.scene.environment.as_ref();
        sky.map_or(0.0, |sky| sky.total_luminance() * self.disk())
    }
}

fn running(numbers: &[f64]) -> Vec<f64> {
    let sums = numbers.iter().scan(0.0, |sum, number| {
        *sum += number;
        Some(*sum)
    });
    sums.collect()
}

/// Luminance that a unit area of a diffuse emitter of this radiance sends out.
pub(super) fn radiant_exitance(radiance: [f32; 3]) -> f64 {
    usable(radiance) * std::f64::consts::PI
}
