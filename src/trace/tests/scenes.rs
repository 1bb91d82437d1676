//! Triangle soups and the rays that are hard for them.

use glam::Vec3;

use crate::sample::{Frame, Rng, equal_area_hemisphere};
use crate::trace::Ray;

pub struct Soup {
    pub name: &'static str,
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Where rays are aimed, and how far around.
    pub centre: Vec3,
    pub scale: f32,
    /// Few rays have a certain answer.
    pub is_hard: bool,
}

impl Soup {
    fn new(name: &'static str, corners: Vec<[Vec3; 3]>) -> Self {
        Self {
            name,
            triangles: (0..corners.len() as u32)
                .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
                .collect(),
            positions: corners.into_iter().flatten().collect(),
            centre: Vec3::ZERO,
            scale: 1.0,
            is_hard: false,
        }
    }

    fn hard(self) -> Self {
        Self {
            is_hard: true,
            ..self
        }
    }

    fn placed(mut self, name: &'static str, scale: f32, centre: Vec3) -> Self {
        for p in &mut self.positions {
            *p = *p * scale + centre;
        }
        Self {
            name,
            scale,
            centre,
            ..self
        }
    }
}

fn point(rng: &mut Rng) -> Vec3 {
    Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * 2.0 - 1.0
}

fn direction(rng: &mut Rng) -> Vec3 {
    loop {
        if let Some(d) = point(rng).try_normalize() {
            return d;
        }
    }
}

fn random(count: usize, size: f32) -> Vec<[Vec3; 3]> {
    let mut rng = Rng::new(1, count as u64, 0, 0);
    let mut triangle = || {
        let centre = point(&mut rng);
        [0; 3].map(|_| centre + size * point(&mut rng))
    };
    (0..count).map(|_| triangle()).collect()
}

/// An axis-aligned floor at y = 0.25 and a wall at x = 0: boxes without thickness, shared edges.
fn flat_grid() -> Vec<[Vec3; 3]> {
    let mut corners = Vec::new();
    for cell in 0..64 {
        let (i, j) = ((cell % 8) as f32, (cell / 8) as f32);
        let at = |i: f32, j: f32| (i / 4.0 - 1.0, j / 4.0 - 1.0);
        for place in [
            |(x, z): (f32, f32)| Vec3::new(x, 0.25, z),
            |(y, z): (f32, f32)| Vec3::new(0.0, y, z),
        ] {
            let [a, b, c, d] = [
                at(i, j),
                at(i + 1.0, j),
                at(i, j + 1.0),
                at(i + 1.0, j + 1.0),
            ]
            .map(place);
            corners.extend([[a, b, c], [b, d, c]]);
        }
    }
    corners
}

pub fn all() -> Vec<Soup> {
    let slivers = random(200, 0.5)
        .into_iter()
        .map(|[a, b, _]| [a, b, a + (b - a) * 0.5 + Vec3::Y * 1e-5]);
    let points = random(60, 0.3).into_iter().map(|[a, _, _]| [a, a, a]);
    let lines = random(60, 0.3)
        .into_iter()
        .map(|[a, b, _]| [a, b, a + (b - a) * 0.5]);
    let twins: Vec<_> = random(40, 0.4).into_iter().flat_map(|t| [t; 5]).collect();
    let coplanar = random(120, 0.4)
        .into_iter()
        .map(|t| t.map(|p| Vec3::new(p.x, p.y, 0.5)));
    let mixed = random(3, 3.0).into_iter().chain(random(400, 0.02));
    let mut degenerate: Vec<_> = points.chain(lines).collect();
    let only_degenerate = degenerate.clone();
    degenerate.extend(random(100, 0.3));
    vec![
        Soup::new("random", random(1000, 0.15)),
        Soup::new("large", random(100, 1.0)),
        Soup::new("one", random(1, 1.0)),
        Soup::new("two", random(2, 1.0)),
        Soup::new("nine", random(9, 1.0)),
        Soup::new("none", Vec::new()),
        Soup::new("slivers", slivers.collect()).hard(),
        Soup::new("degenerate", degenerate).hard(),
        Soup::new("only degenerate", only_degenerate),
        Soup::new("same point", vec![[Vec3::splat(0.5); 3]; 300]),
        Soup::new("twins", twins).hard(),
        Soup::new("same triangle", vec![random(1, 1.0)[0]; 300]).hard(),
        Soup::new("coplanar", coplanar.collect()).hard(),
        Soup::new("flat grid", flat_grid()).hard(),
        Soup::new("mixed sizes", mixed.collect()),
        Soup::new("huge", random(300, 0.2)).placed("huge", 1e6, Vec3::ZERO),
        Soup::new("tiny", random(300, 0.2)).placed("tiny", 1e-4, Vec3::ZERO),
        Soup::new("far", random(300, 0.2))
            .placed("far", 1.0, Vec3::new(1e4, -2e4, 3e4))
            .hard(),
    ]
}

/// Rounds of rays a soup; an interpreter that checks every access has time for few.
const ROUNDS: usize = if cfg!(miri) { 2 } else { 1200 };

/// Random rays, rays at vertices, through and along edges, along axes, with zero components, from inside and
/// from surfaces, with every kind of limit.
pub fn rays_for(soup: &Soup) -> Vec<Ray> {
    let mut rng = Rng::new(2, soup.positions.len() as u64, 0, 0);
    let mut rays = Vec::new();
    let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    for i in 0..ROUNDS {
        let outside = soup.centre + 2.0 * soup.scale * direction(&mut rng);
        let inside = soup.centre + soup.scale * point(&mut rng);
        let vertex = soup.positions.get(rng.below(soup.positions.len()));
        let other = soup.positions.get(rng.below(soup.positions.len()));
        let (a, b) = (
            *vertex.unwrap_or(&soup.centre),
            *other.unwrap_or(&soup.centre),
        );
        let towards = |target: Vec3| (target - outside).try_normalize().unwrap_or(Vec3::X);
        let axis = axes[rng.below(6)];
        let mut flat = direction(&mut rng);
        flat[rng.below(3)] = if rng.below(2) == 0 { 0.0 } else { -0.0 };
        let origin = [outside, inside][i % 2];
        rays.push(Ray::new(origin, direction(&mut rng)));
        rays.push(Ray::new(outside, towards(inside)));
        rays.push(Ray::new(outside, towards(a)));
        rays.push(Ray::new(outside, towards(0.5 * (a + b))));
        let corner = rng.below(soup.triangles.len().max(1)) * 3;
        let edge = soup.positions.get(corner..corner + 2);
        let [from, to] = [0, 1].map(|k| edge.map_or(soup.centre, |edge| edge[k]));
        rays.push(Ray::new(outside, towards(from.lerp(to, rng.next_f32()))));
        rays.push(Ray::new(from, (to - from).try_normalize().unwrap_or(axis)));
        rays.push(Ray::new(origin, axis));
        rays.push(Ray::new(a - 2.0 * soup.scale * axis, axis));
        rays.push(Ray::new(a, flat.normalize()));
        rays.push(Ray::new(origin, flat.normalize()));
    }
    let limits = [
        [0.0, f32::INFINITY],
        [0.0, 0.0],
        [0.3, 1.5],
        [1.5, 0.3],
        [-1.0, 1.0],
        [0.0, f32::MAX],
    ];
    for (i, ray) in rays.iter_mut().enumerate().filter(|(i, _)| i % 3 == 0) {
        let [t_min, t_max] = limits[i / 3 % limits.len()];
        (ray.t_min, ray.t_max) = (t_min * soup.scale, t_max * soup.scale);
    }
    rays
}

/// Origins inside and outside with hemispheres, odd numbers, random and axis directions.
pub fn bundles_for(soup: &Soup) -> Vec<(Vec3, Vec<Vec3>)> {
    let mut rng = Rng::new(3, soup.positions.len() as u64, 0, 0);
    let mut bundles = Vec::new();
    let sides: &[usize] = if cfg!(miri) {
        &[3, 8]
    } else {
        &[1, 3, 8, 16, 32]
    };
    for &side in sides {
        let origin = soup.centre + soup.scale * point(&mut rng);
        let frame = Frame::from_normal(direction(&mut rng));
        let grid = equal_area_hemisphere(side);
        bundles.push((origin, grid.iter().map(|&d| frame.to_world(d)).collect()));
    }
    let axis_frame = Frame::from_normal(Vec3::Y);
    let on_plane = soup.centre + soup.scale * Vec3::new(0.0, 0.25, 0.0);
    let grid = equal_area_hemisphere(if cfg!(miri) { 4 } else { 16 });
    bundles.push((
        on_plane,
        grid.iter().map(|&d| axis_frame.to_world(d)).collect(),
    ));
    let counts: &[usize] = if cfg!(miri) {
        &[0, 65]
    } else {
        &[0, 7, 65, 200]
    };
    for &count in counts {
        let origin = soup.centre + 1.5 * soup.scale * point(&mut rng);
        bundles.push((origin, (0..count).map(|_| direction(&mut rng)).collect()));
    }
    let axes = [
        Vec3::X,
        Vec3::NEG_X,
        Vec3::Y,
        Vec3::NEG_Y,
        Vec3::Z,
        Vec3::NEG_Z,
    ];
    let vertex = soup.positions.first().copied().unwrap_or_default();
    bundles.push((vertex, axes.repeat(if cfg!(miri) { 1 } else { 12 })));
    bundles
}
