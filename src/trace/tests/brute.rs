//! Every triangle for every ray, in f32 as the wide kernels do it and in f64 independently.

use glam::{DVec3, Vec3};

use super::scenes::Soup;
use crate::trace::{Hit, Ray};

pub struct Brute<'a> {
    soup: &'a Soup,
}

/// `U, V, T, den` of a triangle, the denominator made positive.
struct Crossing32([f32; 4]);

fn cross(a: Vec3, b: Vec3) -> Vec3 {
    let each = |x: f32, y: f32, z: f32, w: f32| x.mul_add(y, -(z * w));
    Vec3::new(
        each(a.y, b.z, a.z, b.y),
        each(a.z, b.x, a.x, b.z),
        each(a.x, b.y, a.y, b.x),
    )
}

fn dot(a: Vec3, b: Vec3) -> f32 {
    a.z.mul_add(b.z, a.y.mul_add(b.y, a.x * b.x))
}

impl<'a> Brute<'a> {
    pub fn new(soup: &'a Soup) -> Self {
        Self { soup }
    }

    fn corners(&self, id: usize) -> [Vec3; 3] {
        self.soup.triangles[id].map(|i| self.soup.positions[i as usize])
    }

    fn crossing(&self, ray: &Ray, id: usize) -> Option<Crossing32> {
        let [a, b, c] = self.corners(id);
        if (b - a).as_dvec3().cross((c - a).as_dvec3()) == DVec3::ZERO {
            return None;
        }
        let (e1, e2, c) = (a - b, c - a, a - ray.origin);
        let normal = cross(e2, e1);
        let den = dot(normal, ray.direction);
        let signed = |x: f32| if den.is_sign_negative() { -x } else { x };
        let u = signed(dot(cross(e2, c), ray.direction));
        let v = signed(dot(cross(e1, c), ray.direction));
        let t = signed(dot(normal, c));
        let inside = u >= 0.0 && v >= 0.0 && u + v <= den.abs();
        (inside && den.abs() * ray.t_min.max(0.0) < t).then_some(Crossing32([u, v, t, den.abs()]))
    }

    pub fn occluded(&self, ray: &Ray) -> bool {
        let hit = |id| {
            self.crossing(ray, id)
                .is_some_and(|Crossing32([_, _, t, den])| t <= den * ray.t_max)
        };
        (0..self.soup.triangles.len()).any(hit)
    }

    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        for id in 0..self.soup.triangles.len() {
            let Some(Crossing32([u, v, t, den])) = self.crossing(ray, id) else {
                continue;
            };
            if t / den <= best.map_or(ray.t_max, |b| b.t.next_down()) {
                best = Some(Hit {
                    t: t / den,
                    u: u / den,
                    v: v / den,
                    triangle: id as u32,
                });
            }
        }
        best
    }

    /// Weights and distance in f64: `[u, v, w, t]` and the sine of the angle to the plane.
    fn exact(&self, ray: &Ray, id: usize) -> Option<([f64; 4], f64)> {
        let [a, b, c] = self.corners(id).map(|p| p.as_dvec3());
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let normal = (b - a).cross(c - a);
        let area = normal.length();
        if area == 0.0 {
            return None;
        }
        let den = normal.dot(direction);
        let t = normal.dot(a - origin) / den;
        let p = origin + t * direction;
        let weight =
            |from: DVec3, to: DVec3| normal.dot((to - from).cross(p - from)) / (area * area);
        let (u, v) = (weight(c, a), weight(a, b));
        Some((
            [u, v, 1.0 - u - v, t],
            (den / (area * direction.length())).abs(),
        ))
    }

    /// Whether a triangle that matters is crossed so flatly that its distance is unsure.
    pub fn is_doubtful(&self, ray: &Ray) -> bool {
        (0..self.soup.triangles.len()).any(|id| {
            let Some((_, sine)) = self.exact(ray, id) else {
                return false;
            };
            let [a, b, c] = self.corners(id).map(|p| p.as_dvec3());
            let (long, area) = (
                (b - a).length().max((c - a).length()),
                (b - a).cross(c - a).length(),
            );
            sine * area / (long * long) < 1e-4 && self.crossing(ray, id).is_some()
        })
    }

    /// The closest hit if it is beyond doubt: `Some(None)` is a certain miss.
    pub fn certain(&self, ray: &Ray) -> Option<Option<(u32, f64)>> {
        let mut found: Vec<(u32, f64)> = Vec::new();
        for id in 0..self.soup.triangles.len() {
            let Some(([u, v, w, t], sine)) = self.exact(ray, id) else {
                continue;
            };
            let inside = u.min(v).min(w);
            let limits = [f64::from(ray.t_min.max(0.0)), f64::from(ray.t_max)];
            let close = limits
                .iter()
                .any(|l| (t - l).abs() <= 1e-3 * (t.abs() + l.abs()));
            let [a, b, c] = self.corners(id).map(|p| p.as_dvec3());
            let long = (b - a).length().max((c - a).length());
            let is_thin = (b - a).cross(c - a).length() < 1e-3 * long * long;
            if is_thin || !inside.is_finite() || sine < 1e-3 || inside.abs() < 1e-3 || close {
                let reach = long * 1.01;
                let along = (a - ray.origin.as_dvec3()).dot(ray.direction.as_dvec3());
                let nearest = ray.origin.as_dvec3() + along * ray.direction.as_dvec3();
                if (nearest - a).length() <= reach {
                    return None;
                }
                continue;
            }
            if inside > 0.0 && t > limits[0] && t < limits[1] {
                found.push((id as u32, t));
            }
        }
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        match found.as_slice() {
            [first, second, ..] if second.1 - first.1 < 1e-3 * first.1 => None,
            [first, ..] => Some(Some(*first)),
            [] => Some(None),
        }
    }
}
