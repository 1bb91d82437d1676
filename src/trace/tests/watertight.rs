//! Closed meshes keep every ray in.

use glam::Vec3;

use crate::sample::{Frame, Rng, equal_area_hemisphere};
use crate::trace::{Caster, Instructions, Kernel, Ray, RayCounter, Tracer};

struct Mesh {
    name: &'static str,
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// An octahedron whose triangles are split into four, with every vertex moved by `shape`.
    fn closed(name: &'static str, splits: usize, shape: impl Fn(Vec3) -> Vec3) -> Self {
        let mut positions = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
        let mut triangles: Vec<[u32; 3]> = (0..8)
            .map(|i| [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)])
            .collect();
        for _ in 0..splits {
            let mut middles = std::collections::HashMap::new();
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let sum = positions[a as usize] + positions[b as usize];
                    positions.push(sum.normalize());
                    positions.len() as u32 - 1
                })
            };
            let split = |[a, b, c]: [u32; 3]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            };
            triangles = triangles.into_iter().flat_map(split).collect();
        }
        Self {
            name,
            positions: positions.into_iter().map(shape).collect(),
            triangles,
        }
    }

    fn centre(&self) -> Vec3 {
        self.positions.iter().sum::<Vec3>() / self.positions.len() as f32
    }

    /// Directions from a point to vertices, to points on edges, to and around anything.
    fn directions(&self, from: Vec3, rng: &mut Rng) -> Vec<Vec3> {
        let mut targets = self.positions.clone();
        for &[a, b, c] in &self.triangles {
            let [a, b, c] = [a, b, c].map(|i| self.positions[i as usize]);
            targets.extend([a.lerp(b, rng.next_f32()), b.midpoint(c)]);
        }
        let frame = Frame::from_normal((self.positions[0] - from).normalize());
        let both = [1.0, -1.0].map(|side| {
            let turned = move |&d: &Vec3| side * frame.to_world(d);
            equal_area_hemisphere(if cfg!(miri) { 2 } else { 64 })
                .iter()
                .map(turned)
                .collect::<Vec<_>>()
        });
        let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
        let aimed = targets.iter().map(|&target| (target - from).normalize());
        aimed
            .chain(axes)
            .chain(both.into_iter().flatten())
            .collect()
    }
}

fn meshes() -> Vec<Mesh> {
    let splits = if cfg!(miri) { 1 } else { 5 };
    vec![
        Mesh::closed("octahedron", 0, |p| p),
        Mesh::closed("sphere", splits, |p| p),
        Mesh::closed("lens", splits, |p| p * Vec3::new(1.0, 0.01, 1.0)),
        Mesh::closed("crumpled", splits, |p| {
            p * (1.0 + 0.3 * (17.0 * p.x).sin() * (13.0 * p.y + 5.0 * p.z).cos())
        }),
        Mesh::closed("cube", splits, |p| p / p.abs().max_element()),
        Mesh::closed("tiny", splits, |p| p * 1e-3),
        Mesh::closed("huge", splits, |p| p * 1e5),
        Mesh::closed("far", splits, |p| p + Vec3::new(1e3, -2e3, 3e3)),
    ]
}

/// Rays that miss, by every query.
fn leaks(caster: &Caster, origin: Vec3, directions: &[Vec3]) -> usize {
    let mut bits = vec![0; directions.len().div_ceil(64)];
    caster.occluded_bundle(origin, directions, f32::INFINITY, &mut bits);
    let mut hits = vec![None; directions.len()];
    caster.closest_bundle(origin, directions, f32::INFINITY, &mut hits);
    let missed = |i: &usize| {
        let ray = Ray::new(origin, directions[*i]);
        bits[i / 64] >> (i % 64) & 1 == 0
            || hits[*i].is_none()
            || !caster.occluded(&ray)
            || caster.closest(&ray).is_none()
    };
    (0..directions.len()).filter(missed).count()
}

fn total_leaks(mesh: &Mesh, kernel: Kernel) -> (usize, usize) {
    let tracer = Tracer::with_kernel(&mesh.positions, &mesh.triangles, kernel);
    let counter = RayCounter::default();
    let caster = tracer.caster(&counter);
    let mut rng = Rng::new(5, mesh.positions.len() as u64, 0, 0);
    let (mut leaked, mut total) = (0, 0);
    for _ in 0..if cfg!(miri) { 1 } else { 4 } {
        let corner = mesh.positions[rng.below(mesh.positions.len())];
        let origin = mesh.centre().lerp(corner, 0.5 * rng.next_f32());
        let directions = mesh.directions(origin, &mut rng);
        total += directions.len();
        leaked += leaks(&caster, origin, &directions);
    }
    (leaked, total)
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    for instructions in [Instructions::Avx512, Instructions::Avx2] {
        let kernel = Kernel::Watertight(instructions);
        if !kernel.is_available() {
            println!("skipped: this processor cannot run {}", kernel.name());
            continue;
        }
        for mesh in meshes() {
            let (leaked, total) = total_leaks(&mesh, kernel);
            let (fast, _) = total_leaks(&mesh, Kernel::Wide(instructions));
            println!(
                "{}: {leaked} of {total} rays leak, {fast} by the fast test",
                mesh.name
            );
            assert_eq!(leaked, 0, "{} of {total} rays", mesh.name);
        }
    }
}
