//! Shapes that shine by a texture: cut into small triangles, each of which emits its mean.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::Vec2;

use super::{Mesh, Scene, SceneDescription, SceneError, Texture};

/// About as many triangles as a shape is cut into.
const TRIANGLES: usize = 2048;
/// Most samples along a side for the mean of a triangle.
const MOST_SAMPLES: f32 = 64.0;

/// Cuts every triangle into equally many of equal shape.
pub(super) fn cut(mesh: &Mesh) -> Mesh {
    let along = (TRIANGLES as f64 / mesh.triangles.len().max(1) as f64).sqrt();
    let along = (along as u32).max(1);
    let mut small = Mesh::default();
    for corners in &mesh.triangles {
        let base = small.positions.len() as u32;
        for row in 0..=along {
            for column in 0..=along - row {
                let (u, v) = (f64::from(column), f64::from(row));
                let n = f64::from(along);
                add_vertex(mesh, corners, [1.0 - (u + v) / n, u / n, v / n], &mut small);
            }
        }
        // The first vertex of a row.
        let start = |row: u32| base + row * (2 * along + 3 - row) / 2;
        for row in 0..along {
            for column in 0..along - row {
                let (below, above) = (start(row) + column, start(row + 1) + column);
                small.triangles.push([below, below + 1, above]);
                if column + 1 < along - row {
                    small.triangles.push([below + 1, above + 1, above]);
                }
            }
        }
    }
    small
}

fn add_vertex(mesh: &Mesh, corners: &[u32; 3], weights: [f64; 3], small: &mut Mesh) {
    let corner = |k: usize| corners[k] as usize;
    let position = (0..3).map(|k| mesh.positions[corner(k)] * weights[k]).sum();
    small.positions.push(position);
    let weights = weights.map(|w| w as f32);
    if !mesh.normals.is_empty() {
        let normal = (0..3).map(|k| mesh.normals[corner(k)] * weights[k]).sum();
        small.normals.push(normal);
    }
    if !mesh.uvs.is_empty() {
        let uv = (0..3).map(|k| mesh.uvs[corner(k)] * weights[k]).sum();
        small.uvs.push(uv);
    }
    if !mesh.colours.is_empty() {
        let channel = |c: usize| {
            (0..3)
                .map(|k| mesh.colours[corner(k)][c] * weights[k])
                .sum()
        };
        small.colours.push([0, 1, 2].map(channel));
    }
}

impl Scene {
    /// Gives every triangle of a shape with an emission texture the mean of that, and the shape their mean.
    pub(super) fn shine(&mut self, description: &SceneDescription) -> Result<(), SceneError> {
        let mut read: HashMap<usize, Texture> = HashMap::new();
        for (index, declared) in description.shapes.iter().enumerate() {
            let factor = self.shapes[index].emission;
            let (Some(texture), Some(factor)) = (declared.emission_texture, factor) else {
                continue;
            };
            let texture = match read.entry(texture) {
                Entry::Occupied(entry) => entry.into_mut(),
                Entry::Vacant(entry) => {
                    entry.insert(Texture::load(&description.textures[texture])?)
                }
            };
            let range = self.shapes[index].triangles();
            let mut means: Vec<[f32; 3]> = range
                .clone()
                .map(|triangle| self.mean_of(texture, triangle))
                .collect();
            let name = &declared.name;
            let negative = means.as_flattened().iter().filter(|mean| **mean < 0.0);
            if negative.count() > 0 {
                let channels = means.as_flattened_mut().iter_mut();
                channels.for_each(|mean| *mean = mean.max(0.0));
                let note =
                    format!("`{name}` shines by a texture with values below 0, which count as 0");
                self.report.notes.push(note);
            }
            self.report.notes.extend(texture.notes().iter().cloned());
            let (mut sum, mut area) = ([0.0; 3], 0.0);
            for (triangle, mean) in range.zip(&means) {
                let own = self.area_of(triangle);
                area += own;
                (0..3).for_each(|c| sum[c] += f64::from(mean[c]) * own);
            }
            let mean = sum.map(|s| if area > 0.0 { (s / area) as f32 } else { 0.0 });
            let ratio = |value: f32, mean: f32| if mean > 0.0 { value / mean } else { 0.0 };
            let shape = &mut self.shapes[index];
            shape.emission = Some([0, 1, 2].map(|c| factor[c] * mean[c]));
            shape.pattern = means
                .iter()
                .map(|of| [0, 1, 2].map(|c| ratio(of[c], mean[c])))
                .collect();
            self.report.notes.push(format!(
                "`{name}` shines by its texture, as {} triangles of one colour each",
                means.len()
            ));
        }
        Ok(())
    }

    fn area_of(&self, triangle: usize) -> f64 {
        let corners = self.triangles[triangle].map(|i| self.positions[i as usize].as_dvec3());
        let [a, b, c] = corners;
        0.5 * (b - a).cross(c - a).length()
    }

    /// Mean of a texture over a triangle; of all of it where there are no texture coordinates.
    fn mean_of(&self, texture: &Texture, triangle: usize) -> [f32; 3] {
        let corners = self.triangles[triangle].map(|i| self.uvs.get(i as usize).copied());
        let [Some(a), Some(b), Some(c)] = corners.map(|uv| uv.filter(|uv| !uv.is_nan())) else {
            return texture.mean();
        };
        let texels = Vec2::new(texture.width as f32, texture.height as f32);
        let reach = ((b - a).abs().max((c - a).abs()) * texels).max_element();
        let along = (2.0 * reach).ceil().clamp(2.0, MOST_SAMPLES) as u32;
        let mut sum = [0.0_f64; 3];
        for (i, j) in (0..along * along).map(|k| (k / along, k % along)) {
            // The centre of one of the equal triangles that it is divided into, inside of it.
            let place = |k: u32, third: f32| (k as f32 + third / 3.0) / along as f32;
            let (u, v) = match i + j >= along {
                true => (place(along - 1 - i, 2.0), place(along - 1 - j, 2.0)),
                false => (place(i, 1.0), place(j, 1.0)),
            };
            let colour = texture.lookup(a + (b - a) * u + (c - a) * v);
            (0..3).for_each(|k| sum[k] += f64::from(colour[k]));
        }
        let count = f64::from(along * along);
        sum.map(|s| (s / count) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{
        Needs, ShapeDescription, ShapeSource, TextureDescription, TextureSource, primitive,
    };

    #[test]
    fn a_cut_mesh_is_the_same_surface() {
        let whole = primitive::rectangle();
        let small = cut(&whole);
        assert_eq!(small.triangles.len(), TRIANGLES);
        assert_eq!(small.uvs.len(), small.positions.len());
        let doubled: f64 = small
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| small.positions[i as usize]);
                (b - a).cross(c - a).z
            })
            .sum();
        assert!((doubled - 8.0).abs() < 1e-9, "{doubled}");
    }

    #[test]
    fn nothing_shines_less_than_not_at_all() {
        let description = SceneDescription {
            shapes: vec![ShapeDescription {
                emission: Some([1.0; 3]),
                emission_texture: Some(0),
                ..ShapeDescription::new("lamp", ShapeSource::Rectangle)
            }],
            materials: vec![super::super::Material::diffuse("default", [0.5; 3])],
            textures: vec![TextureDescription {
                source: TextureSource::Checkerboard([[1.0; 3], [-1.0; 3]]),
                nearest: true,
                ..TextureDescription::file("".into())
            }],
            ..SceneDescription::default()
        };
        let scene = Scene::build(&description, Needs::ALL).expect("a scene");
        let mean = scene.shapes[0].emission.expect("shines");
        assert!((mean[0] - 0.5).abs() < 0.02, "{mean:?}");
        let notes = &scene.report.notes;
        assert!(
            notes.iter().any(|note| note.contains("below 0")),
            "{notes:?}"
        );
    }

    #[test]
    fn every_triangle_emits_the_mean_of_its_part_of_the_texture() {
        let [red, blue] = [[4.0, 0.0, 0.0], [0.0, 0.0, 2.0]];
        let description = SceneDescription {
            shapes: vec![ShapeDescription {
                emission: Some([0.5; 3]),
                emission_texture: Some(0),
                ..ShapeDescription::new("lamp", ShapeSource::Rectangle)
            }],
            materials: vec![super::super::Material::diffuse("default", [0.5; 3])],
            textures: vec![TextureDescription {
                source: TextureSource::Checkerboard([red, blue]),
                nearest: true,
                ..TextureDescription::file("".into())
            }],
            ..SceneDescription::default()
        };
        let scene = Scene::build(&description, Needs::ALL).expect("a scene");
        let shape = &scene.shapes[0];
        let mean = shape.emission.expect("shines");
        assert!(
            (mean[0] - 1.0).abs() < 0.01 && (mean[2] - 0.5).abs() < 0.01,
            "{mean:?}"
        );
        assert_eq!(shape.pattern.len(), shape.triangle_count as usize);
        for triangle in shape.triangles() {
            let corners = scene.triangles[triangle].map(|i| scene.positions[i as usize]);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            // Red at the top left.
            let expected = match middle.x * middle.y < 0.0 {
                true => [2.0, 0.0, 0.0],
                false => [0.0, 0.0, 1.0],
            };
            let of = shape.emission_of(triangle as u32).expect("shines");
            assert!(
                (0..3).all(|c| (of[c] - expected[c]).abs() < 0.02),
                "{of:?} {expected:?}"
            );
        }
    }
}
