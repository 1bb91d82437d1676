//! Orientation, continuity, sampling and broken input of environment maps.

use super::*;
use crate::environment::EnvironmentDescription;
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
fn what_is_not_followed_of_a_file_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("map.png");
    let notes = |width, height| {
        crate::image::write_png(&file, &Image::new(width, height), 1.0).unwrap();
        let described = EnvironmentDescription::Map {
            path: file.clone(),
            scale: 1.0,
            to_world: DMat4::IDENTITY,
            rows: EnvironmentRows::CellCentred,
        };
        let map = Environment::from_description(&described).unwrap();
        map.notes().collect::<Vec<_>>()
    };
    assert!(notes(4, 2).is_empty());
    assert!(notes(4, 1).is_empty(), "a strip");
    let told = notes(4, 4);
    assert!(
        told[0].contains("map.png: 4x4 pixels are not twice"),
        "{told:?}"
    );
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
    let divided = e.for_lights();
    assert_eq!((divided.width(), divided.height()), (256, 128));
    assert!((divided.total_power()[0] - 8.0 * PI).abs() < 1e-9);
    assert_eq!(divided.for_lights().width(), 256);
}

#[test]
fn compensated_densities_integrate_to_one_and_leave_the_dim_out() {
    for map in maps() {
        for e in layouts(&map) {
            let (columns, rows) = (2 * e.width(), e.table_rows());
            let mean = e.total_luminance() / (4.0 * PI);
            let mut sum = 0.0;
            for i in 0..columns * rows {
                let (x, y) = (i % columns, i / columns);
                let edge = |y: usize| (PI * y as f64 / rows as f64).cos();
                let theta = PI * (y as f64 + 0.5) / rows as f64;
                let direction = e.direction((x as f64 + 0.5) / columns as f64, theta.cos());
                let (radiance, pdf) = e.radiance_and_pdf(direction, true);
                sum += f64::from(pdf) * (edge(y) - edge(y + 1)) * TAU / columns as f64;
                let constant = map.pixels.iter().all(|p| *p == map.pixels[0]);
                if f64::from(luminance(radiance)) < 0.99 * mean && !constant {
                    assert_eq!(pdf, 0.0);
                }
            }
            assert!((sum - 1.0).abs() < 1e-3, "{sum}");
            let mut rng = Rng::new(4, 0, 0, 0);
            let mut agreeing = 0;
            for _ in 0..500 {
                let u = [rng.next_f64(), rng.next_f64()];
                let s = e.compensated_sample(u).expect("light");
                let (_, pdf) = e.radiance_and_pdf(s.direction, true);
                agreeing += usize::from((pdf - s.pdf_sr).abs() < 1e-4 * s.pdf_sr);
            }
            // Rounding of the direction may cross an edge of a cell.
            assert!(agreeing > 480, "{agreeing}");
        }
    }
    let black = Environment::constant([0.0; 3]);
    assert!(black.compensated_sample([0.5; 2]).is_none());
    assert_eq!(black.radiance_and_pdf(Vec3::X, true).1, 0.0);
}
