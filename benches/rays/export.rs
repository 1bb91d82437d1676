//! Triangles and rays as raw files, for scripts that run other ray tracers on them.
//!
//! `DIR/<scene>/positions.f32` (x y z), `triangles.u32` (three indices), `camera.f32` (eye, point
//! looked at), `sets.tsv` (index, any or closest, rays, hits of the wide kernel, Mrays per CPU-second portable, single
//! and bundle, name) and one `<index>.f32` a set (origin, direction, t_min, t_max: eight numbers a
//! ray). Little-endian.

use std::fs;
use std::io;
use std::path::Path;

use super::{Row, Scene};

fn floats(values: impl Iterator<Item = f32>) -> Vec<u8> {
    values.flat_map(f32::to_le_bytes).collect()
}

/// Writes one scene with its measured rows.
pub fn write(directory: &Path, scene: &Scene, rows: &[Row]) -> io::Result<()> {
    let directory = directory.join(scene.name);
    fs::create_dir_all(&directory)?;
    let positions = floats(scene.positions.iter().flat_map(|p| p.to_array()));
    fs::write(directory.join("positions.f32"), positions)?;
    let indices = scene.triangles.iter().flatten().copied();
    let indices: Vec<u8> = indices.flat_map(u32::to_le_bytes).collect();
    fs::write(directory.join("triangles.u32"), indices)?;
    let camera = [scene.eye, scene.look_at];
    let camera = floats(camera.iter().flat_map(|p| p.to_array()));
    fs::write(directory.join("camera.f32"), camera)?;
    let mut table = String::new();
    for (index, row) in rows.iter().enumerate() {
        let rays = row.set.work.singles();
        let numbers = rays.iter().flat_map(|ray| {
            let (o, d) = (ray.origin, ray.direction);
            [o.x, o.y, o.z, d.x, d.y, d.z, ray.t_min, ray.t_max]
        });
        fs::write(directory.join(format!("{index}.f32")), floats(numbers))?;
        let kind = if row.set.work.is_any_hit() {
            "any"
        } else {
            "closest"
        };
        let (count, name) = (rays.len(), row.set.name);
        let hits = row.hits[1].unwrap_or(0);
        let [portable, single, bundle] = [0, 1, 2].map(|k| row.rate[k]);
        table += &format!(
            "{index}\t{kind}\t{count}\t{hits}\t{portable:.4}\t{single:.4}\t{bundle:.4}\t{name}\n"
        );
    }
    fs::write(directory.join("sets.tsv"), table)
}
