//! The texels of a map as samplers see them: directions in the map's own space, exact solid angles,
//! luminance; and sums over clusters of them.

use std::borrow::Cow;
use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{Environment, Light, LightKind};
use crate::image::luminance;

/// A row of texels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub sin: f64,
    pub cos: f64,
    /// Of one texel.
    pub solid_angle: f64,
}

/// Texels by index, row-major from the top.
pub(super) struct Texels<'a> {
    /// Linear RGB.
    pub pixels: Cow<'a, [[f32; 3]]>,
    pub rows: Vec<Row>,
    /// (sin φ, cos φ) of the columns.
    pub columns: Vec<[f64; 2]>,
    pub luminance: Vec<f32>,
}

impl<'a> Texels<'a> {
    pub fn new(map: &'a Environment) -> Self {
        Self::with_pixels(map, Cow::Borrowed(map.pixels()))
    }

    /// Every texel with the mean of the bilinear lookup over it.
    pub fn of_lookup(map: &Environment) -> Self {
        Self::with_pixels(map, Cow::Owned(lookup_means(map)))
    }

    /// Texels of the given colours where those of the map are.
    fn with_pixels(map: &Environment, pixels: Cow<'a, [[f32; 3]]>) -> Self {
        let (width, height) = (map.width(), map.height());
        let rows = (0..height)
            .map(|y| {
                let (sin, cos) = map.row_angle_rad(y).sin_cos();
                let solid_angle = map.texel_solid_angle(y);
                Row {
                    sin,
                    cos,
                    solid_angle,
                }
            })
            .collect();
        let columns = (0..width)
            .map(|x| {
                let (sin, cos) = (TAU * (x as f64 + 0.5) / width as f64).sin_cos();
                [sin, cos]
            })
            .collect();
        Self {
            rows,
            columns,
            luminance: pixels.par_iter().map(|&rgb| luminance(rgb)).collect(),
            pixels,
        }
    }

    pub fn width(&self) -> usize {
        self.columns.len()
    }

    pub fn height(&self) -> usize {
        self.rows.len()
    }

    pub fn row_of(&self, index: usize) -> &Row {
        &self.rows[index / self.width()]
    }

    /// Unit, in the map's space.
    pub fn direction(&self, index: usize) -> DVec3 {
        self.direction_at(index % self.width(), index / self.width())
    }

    /// Unit, in the map's space.
    pub fn direction_at(&self, x: usize, y: usize) -> DVec3 {
        let (row, [sin, cos]) = (&self.rows[y], self.columns[x]);
        DVec3::new(sin * row.sin, row.cos, -cos * row.sin)
    }

    /// Luminance × solid angle.
    pub fn energy(&self, index: usize) -> f64 {
        f64::from(self.luminance[index]) * self.row_of(index).solid_angle
    }

    /// Radiance × solid angle.
    pub fn power(&self, index: usize) -> DVec3 {
        let rgb = self.pixels[index];
        DVec3::from(rgb.map(f64::from)) * self.row_of(index).solid_angle
    }
}

/// The mean of the bilinear lookup over every texel: ¾ of it and ⅛ of each neighbour, along both axes.
fn lookup_means(map: &Environment) -> Vec<[f32; 3]> {
    let (width, height) = (map.width(), map.height());
    let mut means = vec![[0.0f32; 3]; width * height];
    means
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            let y = y as isize;
            let column = |x: isize| -> Vec3 {
                let at = |y: isize| Vec3::from(map.wrapped(x, y));
                0.75 * at(y) + 0.125 * (at(y - 1) + at(y + 1))
            };
            let mut before = column(-1);
            let mut here = column(0);
            for (x, mean) in row.iter_mut().enumerate() {
                let after = column(x as isize + 1);
                *mean = (0.75 * here + 0.125 * (before + after)).into();
                (before, here) = (here, after);
            }
        });
    means
}

/// Sums over the texels of a cluster.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cluster {
    /// Σ radiance · solid angle.
    pub power: DVec3,
    /// Σ luminance · solid angle · direction.
    pub moment: DVec3,
    /// Σ luminance · solid angle.
    pub energy: f64,
    /// The texel with the largest luminance, and that luminance.
    pub brightest: (f32, u32),
}

impl Cluster {
    pub fn add(&mut self, texels: &Texels, index: usize) {
        let energy = texels.energy(index);
        self.power += texels.power(index);
        self.moment += texels.direction(index) * energy;
        self.energy += energy;
        let luminance = texels.luminance[index];
        if luminance > self.brightest.0 {
            self.brightest = (luminance, index as u32);
        }
    }

    pub fn merge(&mut self, other: &Self) {
        self.power += other.power;
        self.moment += other.moment;
        self.energy += other.energy;
        if other.brightest.0 > self.brightest.0 {
            self.brightest = other.brightest;
        }
    }

    /// The energy centroid; the brightest texel where light from opposite sides cancels; `None` for a
    /// black cluster.
    pub fn direction(&self, texels: &Texels) -> Option<DVec3> {
        if self.energy <= 0.0 {
            return None;
        }
        if self.moment.length() > 1e-6 * self.energy {
            Some(self.moment.normalize())
        } else {
            Some(texels.direction(self.brightest.1 as usize))
        }
    }
}

/// The angle between unit vectors, exact for small ones.
pub(super) fn angle_rad(a: DVec3, b: DVec3) -> f64 {
    2.0 * (0.5 * (a - b).length()).min(1.0).asin()
}

/// Gets texels and their clusters.
pub(super) type Visit<'a> = dyn FnMut(usize, usize) + 'a;

/// Lights of a partition: one for each cluster that is not black, at its energy centroid, in the
/// map's space. `members` calls its argument with every (texel, cluster). Extents reach to the
/// farthest texel that is not black.
pub(super) fn lights_of_partition(
    texels: &Texels,
    count: usize,
    members: &dyn Fn(&mut Visit),
) -> Vec<Light> {
    let mut clusters = vec![Cluster::default(); count];
    members(&mut |texel, cluster| clusters[cluster].add(texels, texel));
    let directions: Vec<Option<DVec3>> = clusters.iter().map(|c| c.direction(texels)).collect();
    let mut farthest = vec![0.0f64; count];
    members(&mut |texel, cluster| {
        if let Some(axis) = directions[cluster]
            && texels.luminance[texel] > 0.0
        {
            let chord = (texels.direction(texel) - axis).length_squared();
            farthest[cluster] = farthest[cluster].max(chord);
        }
    });
    (0..count)
        .filter_map(|i| {
            Some(Light {
                direction: directions[i]?.as_vec3(),
                power: clusters[i].power.to_array(),
                kind: LightKind::Global,
                extent_rad: (2.0 * (0.5 * farthest[i].sqrt()).min(1.0).asin()) as f32,
            })
        })
        .collect()
}
