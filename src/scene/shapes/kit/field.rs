//! Signed distance fields (negative inside) and how they blend. Ellipsoids and displaced fields are
//! bounds, near to a distance close to the surface.

use glam::{Vec2, Vec3};

/// A ball.
pub fn ball(p: Vec3, centre: [f32; 3], radius: f32) -> f32 {
    p.distance(Vec3::from(centre)) - radius
}

/// An axis-aligned ellipsoid.
pub fn ellipsoid(p: Vec3, centre: [f32; 3], radii: [f32; 3]) -> f32 {
    let (q, radii) = (p - Vec3::from(centre), Vec3::from(radii));
    let k0 = (q / radii).length();
    let k1 = (q / (radii * radii)).length();
    if k1 < 1e-6 {
        return -radii.min_element();
    }
    k0 * (k0 - 1.0) / k1
}

/// A segment with a radius at each end, linear between them.
pub fn limb(p: Vec3, from: [f32; 3], to: [f32; 3], radii: [f32; 2]) -> f32 {
    let (a, b) = (Vec3::from(from), Vec3::from(to));
    let ab = b - a;
    let t = ((p - a).dot(ab) / ab.length_squared()).clamp(0.0, 1.0);
    p.distance(a + ab * t) - (radii[0] + (radii[1] - radii[0]) * t)
}

/// A box about `centre`, rounded by `radius` within its extents.
pub fn block(p: Vec3, centre: [f32; 3], half: [f32; 3], radius: f32) -> f32 {
    let q = (p - Vec3::from(centre)).abs() - Vec3::from(half) + radius;
    q.max(Vec3::ZERO).length() + q.max_element().min(0.0) - radius
}

/// A ring about +y.
pub fn ring(p: Vec3, centre: [f32; 3], major: f32, minor: f32) -> f32 {
    let q = p - Vec3::from(centre);
    let across = Vec2::new(q.x, q.z).length() - major;
    across.hypot(q.y) - minor
}

/// A disc (short cylinder) about +y with a rounded rim.
pub fn drum(p: Vec3, centre: [f32; 3], size: [f32; 2], round: f32) -> f32 {
    let q = p - Vec3::from(centre);
    let d = Vec2::new(Vec2::new(q.x, q.z).length(), q.y.abs()) - Vec2::from(size) + round;
    d.max(Vec2::ZERO).length() + d.max_element().min(0.0) - round
}

/// Union with a fillet of about `k` metres (polynomial smooth minimum).
pub fn blend(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

/// `a` without `b`, the edge rounded over about `k` metres.
pub fn carve(a: f32, b: f32, k: f32) -> f32 {
    -blend(-a, b, k)
}

/// 0 below `low`, 1 above `high`, smooth between; the other way round when `low > high`.
pub fn ramp(x: f32, low: f32, high: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A wave in `[-1, 1]` with round ridges and narrow valleys, like folded cloth.
pub fn fold(x: f32) -> f32 {
    1.0 - 2.0 * (0.5 - 0.5 * x.sin()).powi(2)
}
