//! Shading points for placement tests, without a scene.

use glam::{EulerRot, Quat, Vec3};
use lightbench::cache::{NO_POINT, ShadingPoints};
use lightbench::sample::Rng;

/// Points in row-major order on a film of `width` columns; each pixel sees `seen(x, y)`, position
/// and normal, from a camera at the origin, or nothing.
pub fn film(
    (width, height): (usize, usize),
    seen: impl Fn(f32, f32) -> Option<(Vec3, Vec3)>,
) -> ShadingPoints {
    let mut points = ShadingPoints {
        width,
        height,
        point_of_pixel: vec![NO_POINT; width * height],
        metres_per_unit: 1.0,
        ..Default::default()
    };
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for pixel in 0..width * height {
        let x = ((pixel % width) as f32 + 0.5) / width as f32;
        let y = ((pixel / width) as f32 + 0.5) / height as f32;
        let Some((position, normal)) = seen(x, y) else {
            continue;
        };
        (low, high) = (low.min(position), high.max(position));
        points.point_of_pixel[pixel] = points.len() as u32;
        points.position.push(position);
        points.normal.push(normal);
        points.geometric_normal.push(normal);
        points.depth.push(position.length());
        points.pixel.push(pixel as u32);
    }
    points.diagonal = if points.is_empty() {
        0.0
    } else {
        (high - low).length()
    };
    points
}

/// A ball of radius 1 before a slightly irregular ground that runs away; the sky stays empty. Turned
/// so that no row of pixels lies along an axis.
pub fn room(width: usize, height: usize) -> ShadingPoints {
    let mut points = film((width, height), |x, y| {
        let mut rng = Rng::new(3, x.to_bits().into(), y.to_bits().into(), 0);
        let direction = Vec3::new(x - 0.5, 1.0, 0.45 - y);
        let centre = Vec3::new(0.3, 4.0, -0.4);
        let unit = direction.normalize();
        let along = unit.dot(centre);
        let inside = along * along - centre.length_squared() + 1.0;
        if inside > 0.0 {
            let p = unit * (along - inside.sqrt());
            return Some((p, p - centre));
        }
        let depth = -1.4 / unit.z;
        let bump = Vec3::new(rng.next_f32() - 0.5, rng.next_f32() - 0.5, 8.0);
        (unit.z < 0.0 && depth < 30.0).then(|| (unit * depth, bump.normalize()))
    });
    let turn = Quat::from_euler(EulerRot::XYZ, 0.3, -0.5, 0.8);
    points.position.iter_mut().for_each(|p| *p = turn * *p);
    points.normal.iter_mut().for_each(|n| *n = turn * *n);
    points
}

/// All pixels see the same point.
pub fn identical(width: usize, height: usize) -> ShadingPoints {
    film((width, height), |_, _| {
        Some((Vec3::new(1.0, 2.0, 3.0), Vec3::Y))
    })
}

/// A plane with one normal, every point at its own place.
pub fn plane(width: usize, height: usize) -> ShadingPoints {
    film((width, height), |x, y| {
        Some((Vec3::new(x - 0.5, 1.0, y - 0.5) * 3.0, -Vec3::Y))
    })
}

/// One position, two opposite normals.
pub fn antipodal(width: usize, height: usize) -> ShadingPoints {
    film((width, height), |x, _| {
        let normal = if x < 0.5 { Vec3::Z } else { -Vec3::Z };
        Some((Vec3::Y, normal))
    })
}

/// A sphere seen from its inside at one depth everywhere.
pub fn dome(width: usize, height: usize) -> ShadingPoints {
    film((width, height), |x, y| {
        let direction = Vec3::new(2.0 * x - 1.0, 1.0, 2.0 * y - 1.0).normalize();
        Some((direction * 5.0, -direction))
    })
}
