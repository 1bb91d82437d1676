//! A latitude–longitude radiance map with its orientation and sampling table.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DMat4, Mat3, Vec3};

use super::table::SphereTable;
use super::{EnvironmentError, SunSky, sun_sky_image};
use crate::image::{Image, luminance};
use crate::scene::EnvironmentDescription;

/// Where the rows of a map lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

/// Values of the input that could not be radiance, and were replaced: NaN and negative by 0,
/// infinite by the largest finite value of the channel. Counted per channel value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Sanitised {
    pub nan: usize,
    pub infinite: usize,
    pub negative: usize,
}

impl Sanitised {
    /// A sentence about what was replaced; `None` when nothing was.
    pub fn note(&self) -> Option<String> {
        (*self != Self::default()).then(|| {
            format!(
                "environment map repaired: {} NaN and {} negative values became 0, {} infinite ones \
                 the largest finite one",
                self.nan, self.negative, self.infinite
            )
        })
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
    /// What was wrong with the input.
    pub sanitised: Sanitised,
}

impl Environment {
    /// Reads or generates what a scene declares.
    ///
    /// # Errors
    /// Unreadable or empty maps, transforms other than rotations, suns below the horizon.
    pub fn from_description(
        description: &EnvironmentDescription,
    ) -> Result<Self, EnvironmentError> {
        match description {
            EnvironmentDescription::Constant { radiance } => Ok(Self::constant(*radiance)),
            EnvironmentDescription::SunSky {
                sun_direction,
                turbidity,
                albedo,
                sun,
                sky,
                scale,
            } => {
                let image = sun_sky_image(&SunSky {
                    sun_direction: *sun_direction,
                    turbidity: *turbidity,
                    albedo: *albedo,
                    sun: *sun,
                    sky: *sky,
                })?;
                let options = EnvironmentOptions {
                    scale: *scale,
                    ..EnvironmentOptions::default()
                };
                Self::from_image(&image, &options)
            }
            EnvironmentDescription::Map {
                path,
                scale,
                to_world,
            } => {
                let image = crate::image::read(path).map_err(|error| EnvironmentError::Read {
                    path: path.clone(),
                    message: error.to_string(),
                })?;
                let options = EnvironmentOptions {
                    scale: *scale,
                    to_world: *to_world,
                    ..EnvironmentOptions::default()
                };
                Self::from_image(&image, &options)
            }
        }
    }

    /// The same radiance from everywhere.
    pub fn constant(radiance: [f32; 3]) -> Self {
        let image = Image {
            width: 1,
            height: 1,
            pixels: vec![radiance],
        };
        Self::assemble(&image, &EnvironmentOptions::default(), Mat3::IDENTITY)
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
            sanitised,
        };
        environment.table = environment.build_table();
        environment
    }

    /// Half-texel cells, so that each lies in one patch of the bilinear lookup and has its value at
    /// the centre: positive wherever the radiance is.
    fn build_table(&self) -> SphereTable {
        let count = self.table_rows();
        let edges = (0..=count)
            .map(|row| (PI * row as f64 / count as f64).cos())
            .collect();
        let columns = 2 * self.width;
        SphereTable::new(columns, edges, |column, row| {
            let u = (column as f64 + 0.5) / columns as f64;
            let v = (row as f64 + 0.5) / count as f64;
            f64::from(luminance(self.lookup(u, v)))
        })
    }

    fn table_rows(&self) -> usize {
        match self.rows {
            EnvironmentRows::CellCentred => 2 * self.height,
            EnvironmentRows::PoleCentred => (2 * (self.height - 1)).max(2),
        }
    }

    pub fn width(&self) -> usize {
        self.width
    }

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

    /// World direction of the centre of a texel.
    pub fn texel_direction(&self, x: usize, y: usize) -> Vec3 {
        let v = match self.rows {
            EnvironmentRows::CellCentred => (y as f64 + 0.5) / self.height as f64,
            EnvironmentRows::PoleCentred if self.height == 1 => 0.5,
            EnvironmentRows::PoleCentred => y as f64 / (self.height - 1) as f64,
        };
        let u = (x as f64 + 0.5) / self.width as f64;
        self.direction(u, (PI * v).cos())
    }

    /// Exact solid angle of each texel of row `y`; all texels together cover 4π.
    pub fn texel_solid_angle(&self, y: usize) -> f64 {
        let [top, bottom] = match self.rows {
            EnvironmentRows::CellCentred => [y, y + 1].map(|edge| edge as f64 / self.height as f64),
            EnvironmentRows::PoleCentred if self.height == 1 => [0.0, 1.0],
            EnvironmentRows::PoleCentred => [-0.5, 0.5]
                .map(|half| ((y as f64 + half) / (self.height - 1) as f64).clamp(0.0, 1.0)),
        };
        TAU / self.width as f64 * ((PI * top).cos() - (PI * bottom).cos())
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

    /// A direction with density proportional to the bilinear lookup's luminance (constant over half
    /// texels); `u` in [0, 1)². `None` for a black environment.
    pub fn sample(&self, u: [f64; 2]) -> Option<EnvironmentSample> {
        let ([phi, cos], pdf) = self.table.sample(u)?;
        let direction = self.direction(phi, cos);
        Some(EnvironmentSample {
            direction,
            radiance: self.lookup(phi, cos.acos() / PI),
            pdf_sr: pdf as f32,
        })
    }

    /// Density per steradian with which [`Environment::sample`] finds `direction` (unit).
    pub fn pdf(&self, direction: Vec3) -> f32 {
        let [u, v] = self.coordinates(direction);
        let row = (v * self.table_rows() as f64) as usize;
        self.table.density(u, row) as f32
    }

    /// Map coordinates of a world direction, both in [0, 1].
    fn coordinates(&self, direction: Vec3) -> [f64; 2] {
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
    fn wrapped(&self, column: isize, row: isize) -> [f32; 3] {
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

fn sanitise(image: &Image, scale: f32) -> (Vec<[f32; 3]>, Sanitised) {
    let mut largest = [0.0f32; 3];
    for pixel in &image.pixels {
        for (max, value) in largest.iter_mut().zip(pixel) {
            let value = value * scale;
            if value.is_finite() && value > *max {
                *max = value;
            }
        }
    }
    let mut counts = Sanitised::default();
    let mut clean = |value: f32, channel: usize| {
        let value = value * scale;
        if value.is_nan() {
            counts.nan += 1;
            0.0
        } else if value < 0.0 {
            counts.negative += 1;
            0.0
        } else if value.is_infinite() {
            counts.infinite += 1;
            largest[channel]
        } else {
            value
        }
    };
    let pixels = image
        .pixels
        .iter()
        .map(|p| [clean(p[0], 0), clean(p[1], 1), clean(p[2], 2)])
        .collect();
    (pixels, counts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    fn image(width: usize, height: usize, f: impl Fn(usize, usize) -> [f32; 3]) -> Image {
        Image {
            width,
            height,
            pixels: (0..width * height)
                .map(|i| f(i % width, i / width))
                .collect(),
        }
    }

    fn noise(width: usize, height: usize) -> Image {
        image(width, height, |x, y| {
            let mut rng = Rng::new(1, 2, (y * width + x) as u64, 0);
            [rng.next_f32(), rng.next_f32(), rng.next_f32()]
        })
    }

    /// Constant, one bright texel, tiny, and a sky with a sun.
    fn maps() -> Vec<Image> {
        let mut spot = Image::new(16, 8);
        spot.pixels[3 * 16 + 5] = [1000.0, 500.0, 1.0];
        let mut sun = image(64, 32, |_, y| [0.1, 0.2, 0.3 + y as f32 * 0.01]);
        sun.pixels[9 * 64 + 40] = [5000.0; 3];
        let mut pole = Image::new(8, 4);
        pole.pixels[0] = [3.0; 3];
        vec![
            image(1, 1, |_, _| [1.0; 3]),
            spot,
            noise(3, 2),
            sun,
            pole,
            noise(7, 5),
        ]
    }

    fn layouts(image: &Image) -> [Environment; 2] {
        [EnvironmentRows::CellCentred, EnvironmentRows::PoleCentred].map(|rows| {
            let options = EnvironmentOptions {
                rows,
                to_world: DMat4::from_rotation_x(0.3) * DMat4::from_rotation_y(1.0),
                ..EnvironmentOptions::default()
            };
            Environment::from_image(image, &options).expect("a rotation")
        })
    }

    #[test]
    fn orientation_is_that_of_the_references() {
        // A map whose red rises with u and whose green rises with v.
        let map = image(64, 32, |x, y| [x as f32 + 0.5, y as f32 + 0.5, 0.0]);
        let e = Environment::from_image(&map, &EnvironmentOptions::default()).expect("map");
        let at = |d: Vec3| e.radiance(d);
        assert!((at(Vec3::Z)[0] - 32.0).abs() < 1e-3 && (at(Vec3::Z)[1] - 16.0).abs() < 1e-3);
        assert!((at(Vec3::X)[0] - 16.0).abs() < 1e-3);
        assert!((at(-Vec3::X)[0] - 48.0).abs() < 1e-3);
        assert!((at(Vec3::Y)[1] - 0.5).abs() < 1e-3);
        assert!((at(-Vec3::Y)[1] - 31.5).abs() < 1e-3);
        let turned = EnvironmentOptions {
            to_world: DMat4::from_rotation_y(std::f64::consts::FRAC_PI_2),
            ..EnvironmentOptions::default()
        };
        // +z is carried to +x.
        let e = Environment::from_image(&map, &turned).expect("map");
        assert!((e.radiance(Vec3::X)[0] - 32.0).abs() < 1e-3);
        for (x, y) in [(0, 0), (63, 31), (20, 7)] {
            let value = e.radiance(e.texel_direction(x, y));
            assert!((value[0] - e.texel(x, y)[0]).abs() < 1e-3, "{value:?}");
        }
    }

    #[test]
    fn solid_angles_cover_the_sphere() {
        for map in maps() {
            for e in layouts(&map) {
                let sum: f64 = (0..e.height())
                    .map(|y| e.texel_solid_angle(y) * e.width() as f64)
                    .sum();
                assert!((sum - 4.0 * PI).abs() < 1e-12, "{sum}");
            }
        }
    }

    #[test]
    fn lookups_are_continuous_over_poles_and_seam() {
        for e in layouts(&noise(16, 8)) {
            for pole in [Vec3::Y, -Vec3::Y] {
                let pole = e.to_world * pole;
                let side = pole.any_orthonormal_vector();
                let value = |s: f32| e.radiance((pole + side * s).normalize());
                if e.rows == EnvironmentRows::CellCentred {
                    assert!((value(1e-4)[0] - value(-1e-4)[0]).abs() < 1e-2);
                }
            }
            for v in [0.2, 0.5, 0.9] {
                let (a, b) = (e.lookup(1e-7, v), e.lookup(1.0 - 1e-7, v));
                assert!((a[1] - b[1]).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn sampling_follows_the_density_and_finds_all_light() {
        for map in maps() {
            for e in layouts(&map) {
                let mut rng = Rng::new(9, 0, 0, 0);
                let n = 200_000;
                let (mut one, mut power) = (0.0f64, 0.0f64);
                for _ in 0..n {
                    let s = e.sample([rng.next_f64(), rng.next_f64()]).expect("light");
                    assert!(s.pdf_sr > 0.0 && (s.direction.length() - 1.0).abs() < 1e-5);
                    let pdf = e.pdf(s.direction);
                    // Rounding of the direction may cross an edge of a cell.
                    if (pdf - s.pdf_sr).abs() < 1e-4 * s.pdf_sr {
                        one += 1.0;
                    }
                    power += f64::from(luminance(s.radiance) / s.pdf_sr);
                }
                assert!(one / f64::from(n) > 0.999);
                // The estimate by importance against brute force over a fine grid.
                let (rows, columns) = (512, 1024);
                let mut brute = 0.0;
                for row in 0..rows {
                    let cos = |r: usize| (PI * r as f64 / f64::from(rows as u32)).cos();
                    let cell = (cos(row) - cos(row + 1)) * TAU / columns as f64;
                    for column in 0..columns {
                        let u = (column as f64 + 0.5) / columns as f64;
                        let v = (row as f64 + 0.5) / rows as f64;
                        brute += f64::from(luminance(e.lookup(u, v))) * cell;
                    }
                }
                let estimate = power / f64::from(n);
                assert!((estimate / brute - 1.0).abs() < 0.01, "{estimate} {brute}");
                // The table takes cell centres: rough for maps of a few texels only.
                let tolerance = if e.height() < 8 { 0.3 } else { 0.03 };
                assert!((e.total_luminance() / brute - 1.0).abs() < tolerance);
            }
        }
    }

    /// χ² of samples in equal-area cells against the integral of `pdf`.
    #[test]
    fn samples_pass_a_chi_square_test() {
        for map in maps() {
            for e in layouts(&map) {
                const ROWS: usize = 10;
                const COLUMNS: usize = 20;
                let cell = |d: Vec3| {
                    let row = ((1.0 - d.z) * 0.5 * ROWS as f32) as usize;
                    let phi = d.y.atan2(d.x).rem_euclid(std::f32::consts::TAU);
                    let column = (phi / std::f32::consts::TAU * COLUMNS as f32) as usize;
                    row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)
                };
                let n = 100_000;
                let mut counts = vec![0.0f64; ROWS * COLUMNS];
                let mut rng = Rng::new(10, 0, 0, 0);
                for _ in 0..n {
                    let s = e.sample([rng.next_f64(), rng.next_f64()]).expect("light");
                    counts[cell(s.direction)] += 1.0;
                }
                const FINE: usize = 60;
                let mut expected = vec![0.0f64; ROWS * COLUMNS];
                let (rows, columns) = (ROWS * FINE, COLUMNS * FINE);
                for i in 0..rows * columns {
                    let z = 1.0 - 2.0 * ((i / columns) as f32 + 0.5) / rows as f32;
                    let phi = ((i % columns) as f32 + 0.5) / columns as f32 * std::f32::consts::TAU;
                    let s = (1.0 - z * z).sqrt();
                    let d = Vec3::new(s * phi.cos(), s * phi.sin(), z);
                    expected[cell(d)] +=
                        f64::from(e.pdf(d)) * 4.0 * PI / (rows * columns) as f64 * f64::from(n);
                }
                let (mut chi2, mut degrees) = (0.0, 0.0);
                for (c, m) in counts.iter().zip(&expected).filter(|(_, m)| **m > 20.0) {
                    // One per cent of the mean is the error of the grid itself.
                    chi2 += (c - m).powi(2) / (m + (0.01 * m).powi(2));
                    degrees += 1.0;
                }
                let limit = degrees + 6.0 * (2.0f64 * degrees).sqrt() + 10.0;
                assert!(
                    degrees > 0.0 && chi2 < limit,
                    "{}: {chi2} {degrees}",
                    map.width
                );
            }
        }
    }

    #[test]
    fn black_and_broken_maps_are_legal() {
        let black = Environment::constant([0.0; 3]);
        assert!(black.sample([0.3, 0.7]).is_none());
        assert_eq!(black.pdf(Vec3::X), 0.0);
        assert_eq!(black.total_power(), [0.0; 3]);
        let mut broken = image(4, 2, |_, _| [1.0, 2.0, 3.0]);
        broken.pixels[0] = [f32::NAN, -1.0, f32::INFINITY];
        broken.pixels[5] = [f32::NEG_INFINITY, 0.5, 0.5];
        let e = Environment::from_image(&broken, &EnvironmentOptions::default()).expect("map");
        let expected = Sanitised {
            nan: 1,
            infinite: 1,
            negative: 2,
        };
        assert_eq!(e.sanitised, expected);
        assert_eq!(e.texel(0, 0), [0.0, 0.0, 3.0]);
        assert!(e.total_power().iter().all(|p| p.is_finite()));
        let empty = Image::default();
        assert!(Environment::from_image(&empty, &EnvironmentOptions::default()).is_err());
        let sheared = EnvironmentOptions {
            to_world: DMat4::from_scale(glam::DVec3::new(1.0, 2.0, 1.0)),
            ..EnvironmentOptions::default()
        };
        assert!(Environment::from_image(&broken, &sheared).is_err());
    }

    #[test]
    fn constants_are_sampled_uniformly() {
        let e = Environment::constant([2.0, 1.0, 0.5]);
        for d in [Vec3::X, Vec3::Y, -Vec3::Y, Vec3::new(0.6, 0.0, -0.8)] {
            assert!((f64::from(e.pdf(d)) * 4.0 * PI - 1.0).abs() < 1e-6);
            assert_eq!(e.radiance(d), [2.0, 1.0, 0.5]);
        }
        assert!((e.total_power()[0] - 8.0 * PI).abs() < 1e-9);
    }
}
