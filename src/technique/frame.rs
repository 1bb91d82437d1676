//! One view of one scene at one size: camera samples and the surface points they hit.

use glam::Vec3;
use rayon::prelude::*;

use crate::cache::{NO_POINT, ShadingPoints};
use crate::scene::{Scene, View};
use crate::trace::{Caster, Hit, Ray, RayCounter, Tracer};

/// What all jobs of a view share.
pub struct Frame<'a> {
    pub scene: &'a Scene,
    pub tracer: &'a Tracer,
    pub view: &'a View,
    /// Pixels.
    pub width: usize,
    pub height: usize,
    /// Sub-pixel samples of contenders and reference.
    pub spp: u32,
}

/// A surface point as cached functions see it, scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    pub position: Vec3,
    /// Unit shading normal on the viewer's side.
    pub normal: Vec3,
    /// Unit geometric normal on the viewer's side.
    pub geometric_normal: Vec3,
}

impl Frame<'_> {
    /// Position in [0,1)² of a sub-pixel sample, the same in every pixel and for every contender:
    /// the R2 sequence, whose first member is the pixel's centre.
    pub fn sub_pixel(sample: u32) -> [f64; 2] {
        // Powers of the reciprocal of the plastic number.
        const STEP: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];
        STEP.map(|step| (0.5 + f64::from(sample) * step).fract())
    }

    /// The camera ray through sample `sample` of a pixel.
    pub fn camera_ray(&self, pixel: u32, sample: u32) -> Ray {
        let [dx, dy] = Self::sub_pixel(sample);
        let x = (pixel as usize % self.width) as f64 + dx;
        let y = (pixel as usize / self.width) as f64 + dy;
        let direction = self.view.direction(x, y, [self.width, self.height]);
        Ray::new(self.view.origin.as_vec3(), direction)
    }

    /// The surface point that a camera ray sees.
    pub fn site(&self, caster: &Caster, ray: &Ray) -> Option<(Site, f32)> {
        let hit = caster.closest(ray)?;
        Some((self.site_at(ray, &hit)?, hit.t))
    }

    fn site_at(&self, ray: &Ray, hit: &Hit) -> Option<Site> {
        let scene = self.scene;
        let corners = scene.triangles[hit.triangle as usize].map(|i| i as usize);
        let [a, b, c] = corners.map(|i| scene.positions[i]);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let geometric = (b - a).cross(c - a).try_normalize()?;
        let geometric = if geometric.dot(ray.direction) > 0.0 {
            -geometric
        } else {
            geometric
        };
        let smooth = if scene.normals.is_empty() {
            Vec3::ZERO
        } else {
            (0..3).map(|k| scene.normals[corners[k]] * weights[k]).sum()
        };
        let normal = smooth.try_normalize().unwrap_or(geometric);
        Some(Site {
            position: a * weights[0] + b * weights[1] + c * weights[2],
            normal: if normal.dot(geometric) < 0.0 {
                -normal
            } else {
                normal
            },
            geometric_normal: geometric,
        })
    }

    /// Pixels in row-major order.
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }
}

/// One shading point at the centre of each pixel that sees a surface.
pub fn shading_points(frame: &Frame, counter: &RayCounter) -> ShadingPoints {
    let rows: Vec<Vec<(u32, Site, f32)>> = (0..frame.height)
        .into_par_iter()
        .map(|y| {
            let caster = frame.tracer.caster(counter);
            (0..frame.width)
                .filter_map(|x| {
                    let pixel = (y * frame.width + x) as u32;
                    let (site, depth) = frame.site(&caster, &frame.camera_ray(pixel, 0))?;
                    Some((pixel, site, depth))
                })
                .collect()
        })
        .collect();
    let mut points = ShadingPoints {
        width: frame.width,
        height: frame.height,
        point_of_pixel: vec![NO_POINT; frame.pixels()],
        diagonal: frame.scene.diagonal,
        metres_per_unit: frame.scene.metres_per_unit as f32,
        ..ShadingPoints::default()
    };
    for (pixel, site, depth) in rows.into_iter().flatten() {
        points.point_of_pixel[pixel as usize] = points.len() as u32;
        points.position.push(site.position);
        points.normal.push(site.normal);
        points.geometric_normal.push(site.geometric_normal);
        points.depth.push(depth);
        points.pixel.push(pixel);
    }
    points
}
