//! One view of one scene at one size: camera samples and the surface points they hit.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use crate::cache::{NO_POINT, ShadingPoints};
use crate::sample::Rng;
use crate::scene::{Material, Scene, View};
use crate::shade::{Interaction, PathTracer};
use crate::trace::{Caster, Hit, Ray, RayCounter, Tracer};

/// What all jobs of a view share.
pub struct Frame<'a> {
    pub scene: &'a Scene,
    pub tracer: &'a Tracer,
    pub view: &'a View,
    /// Materials and lights, as far as the scene was loaded with them.
    pub paths: PathTracer<'a>,
    /// Pixels.
    pub width: usize,
    pub height: usize,
    /// Sub-pixel samples of contenders and reference.
    pub spp: u32,
    /// Whether camera rays may meet mirrors, glass or opacity masks.
    specular: bool,
}

/// Size of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Film {
    /// Pixels.
    pub width: usize,
    pub height: usize,
    /// Sub-pixel samples.
    pub spp: u32,
}

/// A surface point as cached functions see it, scene units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Site {
    pub position: Vec3,
    /// Unit shading normal on the viewer's side.
    pub normal: Vec3,
    /// Unit geometric normal on the viewer's side.
    pub geometric_normal: Vec3,
}

impl Site {
    /// A shading point by its index.
    pub fn of(points: &ShadingPoints, point: u32) -> Self {
        let i = point as usize;
        Self {
            position: points.position[i],
            normal: points.normal[i],
            geometric_normal: points.geometric_normal[i],
        }
    }
}

/// What one camera sample sees: the first surface that is not specular.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    pub site: Site,
    /// Length of the path from the camera.
    pub depth: f32,
    /// Row-major index.
    pub pixel: u32,
    pub sample: u32,
    pub hit: Hit,
    /// Unit direction of the last ray.
    pub direction: Vec3,
    /// Product of the specular reflections and transmissions on the way.
    pub throughput: Vec3,
}

/// A camera sample that sees no surface.
#[derive(Clone, Copy, Debug)]
pub struct Missed {
    /// Unit direction in which it leaves the scene.
    pub direction: Vec3,
    /// Product of the specular reflections and transmissions on the way; black when it was absorbed.
    pub throughput: Vec3,
}

/// Most specular surfaces that a camera sample passes; what lies behind more of them is not seen.
const MOST_SPECULAR: u32 = 16;
/// Keys the choices between reflection and transmission.
const SPECULAR_STREAM: u64 = 0x7370_6563_756c;

impl<'a> Frame<'a> {
    /// `tracer` was built from the scene's triangles.
    pub fn new((scene, tracer): (&'a Scene, &'a Tracer), view: &'a View, film: Film) -> Self {
        Self {
            scene,
            tracer,
            view,
            paths: PathTracer::new(scene, tracer),
            width: film.width,
            height: film.height,
            spp: film.spp,
            specular: scene.materials.iter().any(Material::is_specular),
        }
    }

    /// Tells frames that one technique is used for apart.
    pub fn key(&self) -> String {
        format!(
            "{} {} {}x{}x{}",
            self.scene.name, self.view.name, self.width, self.height, self.spp
        )
    }

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

    /// The surface that a camera sample sees, through mirrors, glass and opacity masks where the
    /// technique loads materials; `None` for the background. Choices between reflection and
    /// transmission depend on pixel and sample alone, so that all contenders and the reference see
    /// the same.
    pub fn look(&self, caster: &Caster, pixel: u32, sample: u32) -> Option<Seen> {
        self.look_out(caster, pixel, sample).ok()
    }

    /// As [`Frame::look`], and for the background what the sample sees of it.
    pub fn look_out(&self, caster: &Caster, pixel: u32, sample: u32) -> Result<Seen, Missed> {
        let ray = self.camera_ray(pixel, sample);
        let hit = caster.closest(&ray);
        self.look_on(caster, [pixel, sample], (ray, hit))
    }

    /// What `samples` of a tile of neighbouring pixels see, pixel by pixel: exactly what
    /// [`Frame::look`] answers, but the camera rays of a tile are cast together.
    pub fn look_tile(
        &self,
        caster: &Caster,
        (pixels, samples): (&[u32], Range<u32>),
        seen: &mut Vec<Seen>,
    ) {
        let mut rays = Vec::with_capacity(pixels.len() * samples.len());
        let mut hits = vec![None; pixels.len() * samples.len()];
        let mut directions = Vec::with_capacity(pixels.len());
        for (sample, hits) in samples.clone().zip(hits.chunks_mut(pixels.len().max(1))) {
            let first = rays.len();
            rays.extend(pixels.iter().map(|&pixel| self.camera_ray(pixel, sample)));
            directions.clear();
            directions.extend(rays[first..].iter().map(|ray: &Ray| ray.direction));
            let origin = self.view.origin.as_vec3();
            caster.closest_bundle(origin, &directions, f32::INFINITY, hits);
        }
        for (i, &pixel) in pixels.iter().enumerate() {
            for (k, sample) in samples.clone().enumerate() {
                let at = k * pixels.len() + i;
                let start = (rays[at], hits[at]);
                seen.extend(self.look_on(caster, [pixel, sample], start).ok());
            }
        }
    }

    /// The surface that a sample sees: opaque, because an opacity mask has had its say when the sample
    /// did not pass it.
    pub fn surface(&self, seen: &Seen) -> Interaction<'_> {
        let surfaces = self.paths.surfaces();
        let mut at = surfaces.interact(&seen.hit, seen.direction);
        at.bsdf.opacity = 1.0;
        at
    }

    /// Follows a camera ray from its first hit, if there is one.
    fn look_on(
        &self,
        caster: &Caster,
        [pixel, sample]: [u32; 2],
        (mut ray, mut hit): (Ray, Option<Hit>),
    ) -> Result<Seen, Missed> {
        let mut seen = Seen {
            site: Site::default(),
            depth: 0.0,
            pixel,
            sample,
            hit: Hit::default(),
            direction: ray.direction,
            throughput: Vec3::ONE,
        };
        let mut rng = Rng::new(0, SPECULAR_STREAM, u64::from(pixel), u64::from(sample));
        for passed in 0..=MOST_SPECULAR {
            if passed > 0 {
                hit = caster.closest(&ray);
            }
            let Some(hit) = hit else {
                return Err(Missed {
                    direction: ray.direction,
                    throughput: seen.throughput,
                });
            };
            seen.depth += hit.t;
            if self.specular {
                let at = self.paths.surfaces().interact(&hit, ray.direction);
                let u = rng.next_f32();
                if at.bsdf.is_delta() || u >= at.bsdf.opacity {
                    let Some(through) = at.sample([u, 0.0, 0.0]) else {
                        break;
                    };
                    seen.throughput *= through.weight;
                    ray = self.paths.lights().spawn(&at, through.direction);
                    continue;
                }
            }
            let Some(site) = self.site_at(&ray, &hit) else {
                break;
            };
            seen.site = site;
            seen.hit = hit;
            seen.direction = ray.direction;
            return Ok(seen);
        }
        Err(Missed {
            direction: ray.direction,
            throughput: Vec3::ZERO,
        })
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

/// Pixels along a side of the tiles whose camera rays are cast together.
const TILE: usize = 8;

/// What samples `0..samples` of rows `top..bottom` see, tile by tile: neighbours follow each other.
pub fn look_band(
    frame: &Frame,
    counter: &RayCounter,
    rows: Range<usize>,
    samples: u32,
) -> Vec<Seen> {
    let across = frame.width.div_ceil(TILE);
    let down = rows.len().div_ceil(TILE);
    let tiles: Vec<Vec<Seen>> = (0..across * down)
        .into_par_iter()
        .map(|tile| {
            let caster = frame.tracer.caster(counter);
            let (x0, y0) = (tile % across * TILE, rows.start + tile / across * TILE);
            let (x1, y1) = ((x0 + TILE).min(frame.width), (y0 + TILE).min(rows.end));
            let row = |y: usize| (x0..x1).map(move |x| (y * frame.width + x) as u32);
            let pixels: Vec<u32> = (y0..y1).flat_map(row).collect();
            let mut seen = Vec::with_capacity(pixels.len() * samples as usize);
            frame.look_tile(&caster, (&pixels, 0..samples), &mut seen);
            seen
        })
        .collect();
    tiles.into_iter().flatten().collect()
}

/// One shading point at the centre of each pixel that sees a surface, in row-major order.
pub fn shading_points(frame: &Frame, counter: &RayCounter) -> ShadingPoints {
    let mut all = look_band(frame, counter, 0..frame.height, 1);
    all.par_sort_unstable_by_key(|seen| seen.pixel);
    let mut points = ShadingPoints {
        width: frame.width,
        height: frame.height,
        point_of_pixel: vec![NO_POINT; frame.pixels()],
        diagonal: frame.scene.diagonal,
        metres_per_unit: frame.scene.metres_per_unit as f32,
        unit_is_assumed: frame.scene.unit_is_assumed,
        ..ShadingPoints::default()
    };
    for seen in all {
        points.point_of_pixel[seen.pixel as usize] = points.len() as u32;
        points.position.push(seen.site.position);
        points.normal.push(seen.site.normal);
        points.geometric_normal.push(seen.site.geometric_normal);
        points.depth.push(seen.depth);
        points.pixel.push(seen.pixel);
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bsdf, ColourSource, Needs, find_scene};

    /// Robots of mirrors and glass behind holes.
    fn specular_scene() -> Scene {
        let mut description = find_scene("robots").expect("an embedded scene");
        let mirror = Bsdf::Conductor {
            eta: [0.0; 3],
            k: [0.0; 3],
            specular: ColourSource::Constant([0.9, 0.8, 0.7]),
            alpha: 0.0,
            distribution: Default::default(),
        };
        let glass = Bsdf::Dielectric {
            ior: 1.5,
            thin: false,
            reflectance: [1.0; 3],
            transmittance: [1.0; 3],
        };
        for (i, material) in description.materials.iter_mut().enumerate() {
            match i % 4 {
                1 => material.bsdf = mirror.clone(),
                2 => material.bsdf = glass.clone(),
                3 => material.opacity = Some(ColourSource::Constant([0.5; 3])),
                _ => {}
            }
        }
        Scene::build(&description, Needs::ALL).expect("a scene")
    }

    #[test]
    fn tiles_see_what_single_samples_see() {
        let scene = specular_scene();
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        let film = Film {
            width: 45,
            height: 27,
            spp: 3,
        };
        let frame = Frame::new((&scene, &tracer), &scene.views[0], film);
        assert!(frame.specular);
        let counter = RayCounter::default();
        let caster = tracer.caster(&counter);
        let single: Vec<Seen> = (0..frame.pixels() as u32)
            .flat_map(|pixel| (0..frame.spp).map(move |sample| (pixel, sample)))
            .filter_map(|(pixel, sample)| frame.look(&caster, pixel, sample))
            .collect();
        let passed = single.iter().filter(|seen| seen.throughput != Vec3::ONE);
        assert!(passed.count() > 50, "samples that pass mirrors");
        let mut tiled = look_band(&frame, &counter, 0..frame.height, frame.spp);
        tiled.sort_by_key(|seen| (seen.pixel, seen.sample));
        assert_eq!(single.len(), tiled.len());
        for (a, b) in single.iter().zip(&tiled) {
            assert_eq!(format!("{a:?}"), format!("{b:?}"));
        }
    }
}
