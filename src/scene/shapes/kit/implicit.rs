//! Polygonises implicit bodies by surface nets: one vertex in every cell the surface crosses, one
//! quad around every lattice edge it crosses.

use glam::{IVec3, UVec3, Vec3};
use rayon::prelude::*;

use super::shade::mend_normals;
use crate::scene::Mesh;

/// Cells of a block per axis; blocks far from the surface are skipped by one evaluation.
const BLOCK: usize = 6;
const SAMPLES: usize = BLOCK + 1;
const ABSENT: u16 = u16::MAX;

/// A surface crossing found in one block.
struct Patch {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// Vertex of each of the block's cells, or [`ABSENT`].
    vertex_of_cell: Vec<u16>,
    /// The four cells around each crossed edge, counter-clockwise seen from outside.
    quads: Vec<[IVec3; 4]>,
}

/// The lattice and the field sampled on it.
struct Lattice<F> {
    origin: Vec3,
    cell: f32,
    blocks: UVec3,
    field: F,
}

/// The surface `field = 0` inside the box `bounds` with cells of `cell` metres and normals from the
/// gradient. `field` is negative inside and must grow by at most about 1.4 per metre; the body must
/// not touch the bounds. Deterministic for any number of threads.
pub fn polygonise(bounds: [[f32; 3]; 2], cell: f32, field: impl Fn(Vec3) -> f32 + Sync) -> Mesh {
    let [min, max] = bounds.map(Vec3::from);
    let blocks = ((max - min) / (cell * BLOCK as f32))
        .ceil()
        .max(Vec3::ONE)
        .as_uvec3();
    let lattice = Lattice {
        origin: min,
        cell,
        blocks,
        field,
    };
    let count = (blocks.x * blocks.y * blocks.z) as usize;
    let patches: Vec<Option<Patch>> = (0..count)
        .into_par_iter()
        .map(|index| lattice.patch(lattice.block(index)))
        .collect();
    lattice.stitch(&patches)
}

impl<F: Fn(Vec3) -> f32 + Sync> Lattice<F> {
    fn block(&self, index: usize) -> UVec3 {
        let (i, b) = (index as u32, self.blocks);
        UVec3::new(i % b.x, i / b.x % b.y, i / (b.x * b.y))
    }

    /// The block's part of the surface, `None` when there is none.
    fn patch(&self, block: UVec3) -> Option<Patch> {
        let first = block * BLOCK as u32;
        let size = self.cell * BLOCK as f32;
        let corner = self.origin + first.as_vec3() * self.cell;
        let reach = size * 0.5 * 3f32.sqrt() * 1.4 + self.cell;
        if (self.field)(corner + size * 0.5).abs() > reach {
            return None;
        }
        let mut samples = [0.0f32; SAMPLES * SAMPLES * SAMPLES];
        for (i, sample) in samples.iter_mut().enumerate() {
            let at = [i % SAMPLES, i / SAMPLES % SAMPLES, i / (SAMPLES * SAMPLES)];
            let offset = Vec3::from(at.map(|c| c as f32)) * self.cell;
            *sample = (self.field)(corner + offset);
        }
        let mut patch = Patch {
            positions: Vec::new(),
            normals: Vec::new(),
            vertex_of_cell: vec![ABSENT; BLOCK * BLOCK * BLOCK],
            quads: Vec::new(),
        };
        for i in 0..BLOCK * BLOCK * BLOCK {
            let at = [i % BLOCK, i / BLOCK % BLOCK, i / (BLOCK * BLOCK)];
            self.cell_vertex(&samples, at, corner, &mut patch, i);
            push_quads(&samples, at, first.as_ivec3(), &mut patch.quads);
        }
        (!patch.positions.is_empty() || !patch.quads.is_empty()).then_some(patch)
    }

    fn cell_vertex(
        &self,
        samples: &[f32],
        at: [usize; 3],
        corner: Vec3,
        patch: &mut Patch,
        slot: usize,
    ) {
        let Some(local) = crossing_mean(samples, at) else {
            return;
        };
        let low = corner + Vec3::from(at.map(|c| c as f32)) * self.cell;
        let mut p = low + local * self.cell;
        let slope = cell_slope(samples, at) / self.cell;
        let downhill = slope / slope.length_squared().max(0.05);
        // A little beyond its cell does no harm; much would fold the net over.
        let slack = self.cell * 0.1;
        for _ in 0..2 {
            let step = downhill * (self.field)(p);
            p = (p - step).clamp(low - slack, low + self.cell + slack);
        }
        patch.vertex_of_cell[slot] = patch.positions.len() as u16;
        patch.positions.push(p);
        patch
            .normals
            .push(self.gradient(p).normalize_or(slope.normalize_or(Vec3::Y)));
    }

    /// Four samples on a tetrahedron.
    fn gradient(&self, p: Vec3) -> Vec3 {
        let h = self.cell * 0.35;
        let directions = [
            Vec3::new(1.0, -1.0, -1.0),
            Vec3::new(-1.0, -1.0, 1.0),
            Vec3::new(-1.0, 1.0, -1.0),
            Vec3::new(1.0, 1.0, 1.0),
        ];
        let sum: Vec3 = directions
            .iter()
            .map(|&d| d * (self.field)(p + d * h))
            .sum();
        sum / (4.0 * h)
    }

    /// Joins the patches; quads whose neighbour was skipped by mistake are left out.
    fn stitch(&self, patches: &[Option<Patch>]) -> Mesh {
        let mut base = Vec::with_capacity(patches.len());
        let mut mesh = Mesh::default();
        for patch in patches {
            base.push(mesh.positions.len() as u32);
            if let Some(patch) = patch {
                mesh.positions
                    .extend(patch.positions.iter().map(|p| p.as_dvec3()));
                mesh.normals.extend_from_slice(&patch.normals);
            }
        }
        let vertex = |cell: IVec3| {
            let (block, local) = (cell / BLOCK as i32, cell % BLOCK as i32);
            if cell.min_element() < 0 || block.cmpge(self.blocks.as_ivec3()).any() {
                return None;
            }
            let b = self.blocks.as_ivec3();
            let index = (block.x + b.x * (block.y + b.y * block.z)) as usize;
            let side = BLOCK as i32;
            let slot = (local.x + side * (local.y + side * local.z)) as usize;
            let v = patches[index].as_ref()?.vertex_of_cell[slot];
            (v != ABSENT).then(|| base[index] + u32::from(v))
        };
        for quad in patches.iter().flatten().flat_map(|p| &p.quads) {
            let [Some(a), Some(b), Some(c), Some(d)] = quad.map(vertex) else {
                continue;
            };
            push_split(&mut mesh, [a, b, c, d]);
        }
        mend_normals(&mut mesh);
        mesh
    }
}

/// Splits a quad along the diagonal whose triangles agree better with the normals.
fn push_split(mesh: &mut Mesh, [a, b, c, d]: [u32; 4]) {
    let worst = |triangles: [[u32; 3]; 2]| {
        triangles
            .iter()
            .map(|t| {
                let face = super::face_normal(t.map(|i| mesh.positions[i as usize]));
                let dots = t.map(|i| face.dot(mesh.normals[i as usize]));
                dots[0].min(dots[1]).min(dots[2])
            })
            .fold(f32::INFINITY, f32::min)
    };
    let one = [[a, b, c], [a, c, d]];
    let other = [[b, c, d], [b, d, a]];
    let chosen = if worst(one) >= worst(other) {
        one
    } else {
        other
    };
    mesh.triangles.extend(chosen);
}

/// The eight samples at the corners of a cell; bit k of the index is the step along axis k.
fn corner_values(samples: &[f32], at: [usize; 3]) -> [f32; 8] {
    std::array::from_fn(|corner| {
        let c = [0, 1, 2].map(|axis| at[axis] + (corner >> axis & 1));
        samples[c[0] + SAMPLES * (c[1] + SAMPLES * c[2])]
    })
}

/// Mean gradient of a cell, per cell unit.
fn cell_slope(samples: &[f32], at: [usize; 3]) -> Vec3 {
    let values = corner_values(samples, at);
    let along = |axis: usize| {
        let signed = |corner: usize| {
            if corner >> axis & 1 == 1 {
                values[corner]
            } else {
                -values[corner]
            }
        };
        (0..8).map(signed).sum::<f32>() * 0.25
    };
    Vec3::new(along(0), along(1), along(2))
}

/// Mean of the crossings on the twelve edges of a cell, in cell units.
fn crossing_mean(samples: &[f32], at: [usize; 3]) -> Option<Vec3> {
    let values = corner_values(samples, at);
    let inside = values.iter().filter(|v| **v < 0.0).count();
    if inside == 0 || inside == 8 {
        return None;
    }
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    for axis in 0..3 {
        for from in (0..8usize).filter(|c| c >> axis & 1 == 0) {
            let (a, b) = (values[from], values[from | 1 << axis]);
            if (a < 0.0) != (b < 0.0) {
                let mut p = [0, 1, 2].map(|k| (from >> k & 1) as f32);
                p[axis] = a / (a - b);
                sum += Vec3::from(p);
                count += 1.0;
            }
        }
    }
    Some(sum / count)
}

/// Quads around the crossed edges that start at lattice point `at` of the block.
fn push_quads(samples: &[f32], at: [usize; 3], first: IVec3, quads: &mut Vec<[IVec3; 4]>) {
    let value = |p: [usize; 3]| samples[p[0] + SAMPLES * (p[1] + SAMPLES * p[2])];
    let here = value(at) < 0.0;
    let cell = first + IVec3::from(at.map(|c| c as i32));
    let units = [IVec3::X, IVec3::Y, IVec3::Z];
    for axis in 0..3 {
        let mut next = at;
        next[axis] += 1;
        if here == (value(next) < 0.0) {
            continue;
        }
        let (b, c) = (units[(axis + 1) % 3], units[(axis + 2) % 3]);
        let mut quad = [cell - b - c, cell - c, cell, cell - b];
        if !here {
            quad.reverse();
        }
        quads.push(quad);
    }
}
