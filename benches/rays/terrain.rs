//! A noisy terrain with blobs above it, 1.08 M triangles, generated.

use glam::Vec3;
use lightbench::sample::Rng;

use super::Scene;

/// Grid cells along a side of the terrain.
const CELLS: usize = 640;
const SIZE: f32 = 100.0;
const BLOBS: usize = 32;
/// Grid cells along a side of a blob.
const BLOB_CELLS: usize = 64;

pub fn scene() -> Scene {
    let mut scene = Scene {
        name: "terrain",
        positions: Vec::new(),
        triangles: Vec::new(),
        eye: Vec3::new(-45.0, 22.0, -45.0),
        look_at: Vec3::new(0.0, 2.0, 0.0),
    };
    grid(&mut scene, CELLS, |u, v| {
        let (x, z) = ((u - 0.5) * SIZE, (v - 0.5) * SIZE);
        Vec3::new(x, height(x, z), z)
    });
    let mut rng = Rng::new(7, 0, 0, 0);
    for blob in 0..BLOBS {
        let mut uniform = |low: f32, high: f32| low + (high - low) * rng.next_f32();
        let (x, z) = (uniform(-42.0, 42.0), uniform(-42.0, 42.0));
        let centre = Vec3::new(x, height(x, z) + uniform(1.0, 6.0), z);
        let radius = uniform(1.0, 4.0);
        grid(&mut scene, BLOB_CELLS, |u, v| {
            let (theta, phi) = (std::f32::consts::PI * v, std::f32::consts::TAU * u);
            let d = Vec3::new(
                theta.sin() * phi.cos(),
                theta.cos(),
                theta.sin() * phi.sin(),
            );
            let bumps = 1.0 + 0.2 * noise(3.0 * d.x + blob as f32, 3.0 * d.z + d.y);
            centre + radius * bumps * d
        });
    }
    scene
}

/// Appends a surface over the unit square.
fn grid(scene: &mut Scene, cells: usize, surface: impl Fn(f32, f32) -> Vec3) {
    let first = scene.positions.len() as u32;
    let side = cells as u32 + 1;
    for i in 0..side * side {
        let (u, v) = ((i % side) as f32, (i / side) as f32);
        scene
            .positions
            .push(surface(u / cells as f32, v / cells as f32));
    }
    for i in (0..side * (side - 1)).filter(|i| i % side != side - 1) {
        let [a, b, c, d] = [0, 1, side, side + 1].map(|k| first + i + k);
        scene.triangles.extend([[a, b, c], [b, d, c]]);
    }
}

fn height(x: f32, z: f32) -> f32 {
    let octave = |k: i32| noise(x * 0.05 * 2f32.powi(k), z * 0.05 * 2f32.powi(k)) * 0.5f32.powi(k);
    8.0 * (0..8).map(octave).sum::<f32>()
}

/// Smooth noise in −1…1 from a lattice of random values.
fn noise(x: f32, y: f32) -> f32 {
    let (column, row) = (x.floor(), y.floor());
    let smooth = |t: f32| t * t * (3.0 - 2.0 * t);
    let (s, t) = (smooth(x - column), smooth(y - row));
    let value = |dx: i64, dy: i64| {
        let mut rng = Rng::new(11, (column as i64 + dx) as u64, (row as i64 + dy) as u64, 0);
        2.0 * rng.next_f32() - 1.0
    };
    let low = value(0, 0) * (1.0 - s) + value(1, 0) * s;
    let high = value(0, 1) * (1.0 - s) + value(1, 1) * s;
    low * (1.0 - t) + high * t
}
