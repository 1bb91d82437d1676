//! A synthetic image for benches: a bumpy ground that runs to the horizon and balls of many sizes
//! on it, seen in perspective, with depth edges, flat parts, fine curvature and some background.

use glam::Vec3;
use lightbench::cache::{NO_POINT, ShadingPoints};
use lightbench::sample::Rng;

/// Eye height and largest depth, scene units (metres).
const EYE: f32 = 1.7;
const FAR: f32 = 60.0;
const BALLS: usize = 150;

struct Ball {
    centre: Vec3,
    radius: f32,
}

/// The shading points of a `width` × `height` image.
pub fn points(width: usize, height: usize) -> ShadingPoints {
    let balls = balls();
    let mut out = ShadingPoints {
        width,
        height,
        point_of_pixel: vec![NO_POINT; width * height],
        metres_per_unit: 1.0,
        ..Default::default()
    };
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for pixel in 0..width * height {
        let x = (pixel % width) as f32 + 0.5 - 0.5 * width as f32;
        let y = (pixel / width) as f32 + 0.5 - 0.02 * height as f32;
        let scale = 1.2 / width as f32;
        let direction = Vec3::new(x * scale, 1.0, -y * scale).normalize();
        let Some((depth, normal)) = hit(direction, &balls) else {
            continue;
        };
        let position = direction * depth;
        (low, high) = (low.min(position), high.max(position));
        out.point_of_pixel[pixel] = out.position.len() as u32;
        out.position.push(position);
        out.normal.push(normal);
        out.geometric_normal.push(normal);
        out.depth.push(depth);
        out.pixel.push(pixel as u32);
    }
    out.diagonal = (high - low).length();
    out
}

fn balls() -> Vec<Ball> {
    let mut rng = Rng::new(11, 0, 0, 0);
    (0..BALLS)
        .map(|_| {
            let y = 2.0 + 40.0 * rng.next_f32() * rng.next_f32();
            let x = (rng.next_f32() - 0.5) * y * 1.2;
            let radius = 0.05 + 0.5 * rng.next_f32() * rng.next_f32();
            Ball {
                centre: Vec3::new(x, y, radius - EYE),
                radius,
            }
        })
        .collect()
}

fn hit(direction: Vec3, balls: &[Ball]) -> Option<(f32, Vec3)> {
    let mut nearest = None;
    let mut depth = FAR;
    for ball in balls {
        let along = direction.dot(ball.centre);
        let inside = along * along - ball.centre.length_squared() + ball.radius * ball.radius;
        if inside > 0.0 && along - inside.sqrt() < depth {
            depth = along - inside.sqrt();
            nearest = Some((direction * depth - ball.centre) / ball.radius);
        }
    }
    let ground = -EYE / direction.z;
    if direction.z < 0.0 && ground < depth {
        depth = ground;
        let p = direction * ground;
        let slope = |t: f32| 0.15 * (3.0 * t).sin() + 0.1 * (17.0 * t).cos();
        nearest = Some(Vec3::new(slope(p.x), slope(p.y), 1.0));
    }
    nearest.map(|normal: Vec3| (depth, normal.normalize()))
}
