//! A latitude–longitude radiance map with its orientation and sampling table.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;
use std::sync::OnceLock;

use glam::{DMat3, DMat4, Mat3, Vec3};

use super::EnvironmentError;
use super::repair::{Sanitised, sanitise};
use super::table::SphereTable;
use crate::image::{Image, luminance};

/// Into how many texels, of a row and of a column, the one of a constant sky is divided for sets of lights.
const TEXELS_OF_ONE: [usize; 2] = [256, 128];

/// Where the rows of a map lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub enum EnvironmentRows {
    /// Row `i` of `H` is centred at θ = π (i + ½) / H.
    #[default]
    CellCentred,
    /// The first and the last row lie on the poles, θ = π i / (H − 1), as Mitsuba looks maps up.
    PoleCentred,
}

/// How an image becomes an environment.
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentOptions {
    /// Factor on the pixels.
    pub scale: f32,
    /// Turns the map: a rotation, possibly mirrored; uniform scale and translation are ignored.
    pub to_world: DMat4,
    /// Where its rows lie.
    pub rows: EnvironmentRows,
}

impl Default for EnvironmentOptions {
    fn default() -> Self {
        Self {
            scale: 1.0,
            to_world: DMat4::IDENTITY,
            rows: EnvironmentRows::default(),
        }
    }
}

/// A direction drawn by importance.
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentSample {
    /// Unit vector towards the light, world space.
    pub direction: Vec3,
    /// Linear RGB.
    pub radiance: [f32; 3],
    /// Per steradian, positive.
    pub pdf_sr: f32,
}

/// Light from infinity. u = 0.5, v = 0.5 looks along +z, u = 0.25 along +x and the top row along +y
/// of the space that `to_world` turns; lookups are bilinear, wrap in φ and go over the poles.
#[derive(Clone, Debug)]
pub struct Environment {
    width: usize,
    height: usize,
    rows: EnvironmentRows,
    pixels: Vec<[f32; 3]>,
    to_world: Mat3,
    to_map: Mat3,
    table: SphereTable,
    /// Made when it is first asked for.
    compensated: OnceLock<SphereTable>,
    /// What was wrong with the input.
    pub sanitised: Sanitised,
    /// What its file says and is not followed, or is unusual in it.
    pub(super) unheeded: Vec<String>,
    /// A file without any light.
    pub(super) black_file: Option<PathBuf>,
}

impl Environment {
    /// The same radiance from everywhere.
    pub fn constant(radiance: [f32; 3]) -> Self {
        let image = Image {
            width: 1,
            height: 1,
            pixels: vec![radiance],
        };
        Self::assemble(&image, &EnvironmentOptions::default(), Mat3::IDENTITY)
    }

    /// The map that sets of lights are chosen on: itself, and of a single texel one that is divided into many, since no
    /// light stands for less than one.
    pub fn for_lights(&self) -> Cow<'_, Self> {
        let [radiance] = self.pixels[..] else {
            return Cow::Borrowed(self);
        };
        let [width, height] = TEXELS_OF_ONE;
        let image = Image {
            width,
            height,
            pixels: vec![radiance; width * height],
        };
        let options = EnvironmentOptions::default();
        let mut divided = Self::assemble(&image, &options, self.to_world);
        divided.sanitised = self.sanitised;
        Cow::Owned(divided)
    }

    /// Turns a latitude–longitude image into an environment.
    ///
    /// # Errors
    /// Empty images and transforms other than rotations.
    pub fn from_image(
        image: &Image,
        options: &EnvironmentOptions,
    ) -> Result<Self, EnvironmentError> {
        let (width, height) = (image.width, image.height);
        if width == 0 || height == 0 || image.pixels.len() != width * height {
            return Err(EnvironmentError::Empty { width, height });
        }
        let rotation = rotation_part(options.to_world)?;
        Ok(Self::assemble(image, options, rotation))
    }

    fn assemble(image: &Image, options: &EnvironmentOptions, to_world: Mat3) -> Self {
        let (pixels, sanitised) = sanitise(image, options.scale);
        let mut environment = Self {
            width: image.width,
            height: image.height,
            rows: options.rows,
            pixels,
            to_world,
            to_map: to_world.transpose(),
            table: SphereTable::new(1, vec![1.0, -1.0], |_, _| 0.0),
            compensated: OnceLock::new(),
            sanitised,
            unheeded: Vec::new(),
            black_file: None,
        };
        environment.table = environment.build_table(|luminance| luminance);
        environment
    }

    /// Half-texel cells, so that each lies in one patch of the bilinear lookup and has its value at
    /// the centre: positive wherever the radiance is.
    fn build_table(&self, value: impl Fn(f64) -> f64 + Sync) -> SphereTable {
        let count = self.table_rows();
        let edges = (0..=count)
            .map(|row| (PI * row as f64 / count as f64).cos())
            .collect();
        let columns = 2 * self.width;
        SphereTable::new(columns, edges, |column, row| {
            let u = (column as f64 + 0.5) / columns as f64;
            let v = (row as f64 + 0.5) / count as f64;
            value(f64::from(luminance(self.lookup(u, v))))
        })
    }

    fn table_rows(&self) -> usize {
        match self.rows {
            EnvironmentRows::CellCentred => 2 * self.height,
            EnvironmentRows::PoleCentred => (2 * (self.height - 1)).max(2),
        }
    }

    /// Texels of a row: azimuths.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Texels of a column: from +y down to −y before `to_world`.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Bytes held by the pixels and the table.
    pub fn bytes(&self) -> usize {
        size_of_val(self.pixels.as_slice()) + self.table.bytes()
    }

    /// Radiance stored in column `x` of row `y` (from the top), scaled and sanitised.
    pub fn texel(&self, x: usize, y: usize) -> [f32; 3] {
        self.pixels[y * self.width + x]
    }

    /// All texels, row-major from the top.
    pub(super) fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// Carries directions of the map to the world; orthogonal.
    pub(crate) fn to_world(&self) -> Mat3 {
        self.to_world
    }

    /// Turns the map, which a rotation (mirrored at most) takes to the world.
    pub(crate) fn turn_to(&mut self, to_world: Mat3) {
        self.to_world = to_world;
        self.to_map = to_world.transpose();
    }

    /// Polar angle θ of the centre of row `y`.
    pub(super) fn row_angle_rad(&self, y: usize) -> f64 {
        PI * match self.rows {
            EnvironmentRows::CellCentred => (y as f64 + 0.5) / self.height as f64,
            EnvironmentRows::PoleCentred if self.height == 1 => 0.5,
            EnvironmentRows::PoleCentred => y as f64 / (self.height - 1) as f64,
        }
    }

    /// World direction of the centre of a texel.
    pub fn texel_direction(&self, x: usize, y: usize) -> Vec3 {
        let u = (x as f64 + 0.5) / self.width as f64;
        self.direction(u, self.row_angle_rad(y).cos())
    }

    /// Exact solid angle of each texel of row `y`; all texels together cover 4π.
    pub fn texel_solid_angle(&self, y: usize) -> f64 {
        let [top, bottom] = self.texel_edges(y);
        TAU / self.width as f64 * (top - bottom)
    }

    /// cos θ of the upper and the lower edge of the texels of row `y`.
    fn texel_edges(&self, y: usize) -> [f64; 2] {
        let edges = match self.rows {
            EnvironmentRows::CellCentred => [y, y + 1].map(|edge| edge as f64 / self.height as f64),
            EnvironmentRows::PoleCentred if self.height == 1 => [0.0, 1.0],
            EnvironmentRows::PoleCentred => [-0.5, 0.5]
                .map(|half| ((y as f64 + half) / (self.height - 1) as f64).clamp(0.0, 1.0)),
        };
        edges.map(|edge| (PI * edge).cos())
    }

    /// Σ radiance · solid angle over all texels, per channel.
    pub fn total_power(&self) -> [f64; 3] {
        let mut total = [0.0; 3];
        for (y, row) in self.pixels.chunks_exact(self.width).enumerate() {
            let solid_angle = self.texel_solid_angle(y);
            for pixel in row {
                for (sum, value) in total.iter_mut().zip(pixel) {
                    *sum += f64::from(*value) * solid_angle;
                }
            }
        }
        total
    }

    /// ∫ luminance over the sphere as the sampling table sees it; 0 for a black environment.
    pub fn total_luminance(&self) -> f64 {
        self.table.total()
    }

    /// Radiance that arrives from the world direction `direction` (unit).
    pub fn radiance(&self, direction: Vec3) -> [f32; 3] {
        let [u, v] = self.coordinates(direction);
        self.lookup(u, v)
    }

    /// [`Environment::radiance`] and [`Environment::pdf`] (of the compensated density if asked for) at
    /// once.
    pub fn radiance_and_pdf(&self, direction: Vec3, compensated: bool) -> ([f32; 3], f32) {
        let [u, v] = self.coordinates(direction);
        let table = match compensated {
            true => self.compensated(),
            false => &self.table,
        };
        let row = (v * self.table_rows() as f64) as usize;
        (self.lookup(u, v), table.density(u, row) as f32)
    }

    /// A direction with density proportional to the bilinear lookup's luminance (constant over half
    /// texels); `u` in [0, 1)². `None` for a black environment.
    pub fn sample(&self, u: [f64; 2]) -> Option<EnvironmentSample> {
        self.sample_of(&self.table, u)
    }

    /// What [`Environment::sample`] finds `direction` (unit) with, in [0, 1]². `None` where the density is zero.
    pub fn place(&self, direction: Vec3) -> Option<[f64; 2]> {
        let [u, v] = self.coordinates(direction);
        self.table.place([u, (PI * v).cos()])
    }

    /// Density per steradian with which [`Environment::sample`] finds `direction` (unit).
    pub fn pdf(&self, direction: Vec3) -> f32 {
        self.radiance_and_pdf(direction, false).1
    }

    /// The density of MIS compensation (Karlík et al. 2019): proportional to what the luminance has
    /// above its average; uniform where nothing has.
    fn compensated(&self) -> &SphereTable {
        self.compensated.get_or_init(|| {
            let mean = self.table.total() / (4.0 * PI);
            // Rounding leaves a constant map something above its average.
            let table = self.build_table(|l| (l - mean * (1.0 + 1e-6)).max(0.0));
            if table.total() > 0.0 || mean == 0.0 {
                table
            } else {
                self.build_table(|_| 1.0)
            }
        })
    }

    /// As [`Environment::sample`] by the compensated density, which other samples must complement.
    pub fn compensated_sample(&self, u: [f64; 2]) -> Option<EnvironmentSample> {
        self.sample_of(self.compensated(), u)
    }

    fn sample_of(&self, table: &SphereTable, u: [f64; 2]) -> Option<EnvironmentSample> {
        let ([phi, cos], pdf) = table.sample(u)?;
        Some(EnvironmentSample {
            direction: self.direction(phi, cos),
            radiance: self.lookup(phi, cos.acos() / PI),
            pdf_sr: pdf as f32,
        })
    }

    /// Map coordinates (u, v) of a world direction, both in [0, 1].
    pub fn coordinates(&self, direction: Vec3) -> [f64; 2] {
        let d = (self.to_map * direction).as_dvec3();
        let phi = d.x.atan2(-d.z) / TAU;
        let theta = d.x.hypot(d.z).atan2(d.y);
        [if phi < 0.0 { phi + 1.0 } else { phi }, theta / PI]
    }

    /// World direction at φ (share of the circle) and cos θ.
    fn direction(&self, u: f64, cos: f64) -> Vec3 {
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        let (sin_phi, cos_phi) = (TAU * u).sin_cos();
        let local = glam::DVec3::new(sin_phi * sin, cos, -cos_phi * sin).as_vec3();
        (self.to_world * local).normalize()
    }

    /// World direction of a point in texel (x, y): `at` in [0, 1)², uniform in solid angle.
    pub(super) fn within_texel(&self, x: usize, y: usize, at: [f64; 2]) -> Vec3 {
        let [top, bottom] = self.texel_edges(y);
        let u = (x as f64 + at[0]) / self.width as f64;
        self.direction(u, top + at[1] * (bottom - top))
    }

    fn lookup(&self, u: f64, v: f64) -> [f32; 3] {
        let x = u * self.width as f64 - 0.5;
        let y = match self.rows {
            EnvironmentRows::CellCentred => v * self.height as f64 - 0.5,
            EnvironmentRows::PoleCentred => v * (self.height - 1) as f64,
        };
        let (column, row) = (x.floor(), y.floor());
        let (fx, fy) = ((x - column) as f32, (y - row) as f32);
        let (column, row) = (column as isize, row as isize);
        let mut sum = [0.0f32; 3];
        let corners = [
            (0, 0, (1.0 - fx) * (1.0 - fy)),
            (1, 0, fx * (1.0 - fy)),
            (0, 1, (1.0 - fx) * fy),
            (1, 1, fx * fy),
        ];
        for (dx, dy, weight) in corners {
            if weight > 0.0 {
                let texel = self.wrapped(column + dx, row + dy);
                for (sum, value) in sum.iter_mut().zip(texel) {
                    *sum += weight * value;
                }
            }
        }
        sum
    }

    /// A texel of the endless map: columns wrap, rows beyond a pole continue on its other side.
    pub(super) fn wrapped(&self, column: isize, row: isize) -> [f32; 3] {
        let (width, height) = (self.width as isize, self.height as isize);
        let over = row < 0 || row >= height;
        let row = if row < 0 {
            (-1 - row).min(height - 1)
        } else if row >= height {
            (2 * height - 1 - row).max(0)
        } else {
            row
        };
        let column = if over { column + width / 2 } else { column };
        self.texel(column.rem_euclid(width) as usize, row as usize)
    }
}

fn rotation_part(to_world: DMat4) -> Result<Mat3, EnvironmentError> {
    let m = DMat3::from_mat4(to_world);
    let scale = m.determinant().abs().cbrt();
    let rotation = m * (1.0 / scale);
    let error = (rotation * rotation.transpose() - DMat3::IDENTITY)
        .to_cols_array()
        .iter()
        .fold(0.0f64, |a, b| a.max(b.abs()));
    if scale > 0.0 && error < 1e-3 {
        Ok(rotation.as_mat3())
    } else {
        Err(EnvironmentError::NotARotation {
            matrix: format!("{m}"),
        })
    }
}

#[cfg(test)]
#[path = "map_tests.rs"]
mod tests;
