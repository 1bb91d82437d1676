//! A scene at one moment as one viewer sees it: camera samples and the surface points they hit.

use std::ops::Range;

use glam::Vec3;

use super::Technique;
use crate::cache::{ShadingPoints, Sight};
use crate::image::Image;
use crate::sample::Rng;
use crate::scene::{Material, Scene, View};
use crate::shade::{Interaction, PathTracer};
use crate::trace::{Caster, Hit, Ray, Tracer};
use crate::world::Moment;

/// A scene at one moment, seen by one viewer with one film.
pub struct Shot<'a> {
    /// The world at the time of the frame.
    pub moment: Moment<'a>,
    /// Those of the moment.
    pub scene: &'a Scene,
    /// Answers rays against the scene at that time.
    pub tracer: &'a Tracer,
    /// The camera, moved with the geometry to the scene's centre.
    pub view: &'a View,
    /// Materials and lights, as far as the scene was loaded with them.
    pub paths: PathTracer<'a>,
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Sub-pixel samples of contenders and reference.
    pub spp: u32,
    /// Number of the viewer in the sequence.
    pub viewer: u16,
    /// Number of the frame in the sequence.
    pub frame: u32,
    /// Factor on radiance of reference and contenders, see [`Technique::exposure`].
    pub exposure: f32,
    /// Light that is added to the image of every contender, see [`Technique::shared_layer`].
    pub layer: Option<Image>,
    /// Whether camera rays may meet mirrors, glass or opacity masks.
    specular: bool,
    /// See [`View::half_tangents`].
    half_tangents: [f64; 2],
}

/// Size of a shot.
#[derive(Clone, Copy, Debug)]
pub struct Film {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Sub-pixel samples.
    pub spp: u32,
}

/// A surface point as cached functions see it, scene units.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Site {
    /// On the surface, relative to the scene's centre.
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
    /// The point, turned to the side it is seen from.
    pub site: Site,
    /// Length of the path from the camera.
    pub depth: f32,
    /// Row-major index.
    pub pixel: u32,
    /// Number of the sub-pixel sample within the pixel.
    pub sample: u32,
    /// Triangle and barycentric weights; `t` is along the last ray.
    pub hit: Hit,
    /// Unit direction of the last ray.
    pub direction: Vec3,
    /// Product of the specular reflections and transmissions on the way.
    pub throughput: Vec3,
}

impl Seen {
    /// What the centre of a pixel sees, as a shading point (by its index) remembers it.
    pub fn of(points: &ShadingPoints, point: u32) -> Self {
        let i = point as usize;
        let Sight {
            hit,
            direction,
            throughput,
        } = points.sight[i];
        Self {
            site: Site::of(points, point),
            depth: points.depth[i],
            pixel: points.pixel[i],
            sample: 0,
            hit,
            direction,
            throughput,
        }
    }
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

impl<'a> Shot<'a> {
    /// The first viewer's, in the first frame, unexposed.
    pub fn new(moment: Moment<'a>, view: &'a View, film: Film) -> Self {
        let Moment { scene, tracer, .. } = moment;
        Self {
            moment,
            scene,
            tracer,
            view,
            paths: PathTracer::new(scene, tracer),
            width: film.width,
            height: film.height,
            spp: film.spp,
            viewer: 0,
            frame: 0,
            exposure: 1.0,
            layer: None,
            specular: scene.materials.iter().any(Material::is_specular),
            half_tangents: view.half_tangents(film.width, film.height),
        }
    }

    /// As [`Shot::new`], with the exposure that a technique gives a sequence which begins here.
    pub fn exposed_for(
        technique: &dyn Technique,
        moment: Moment<'a>,
        view: &'a View,
        film: Film,
    ) -> Self {
        let mut shot = Self::new(moment, view, film);
        shot.exposure = technique.exposure(&shot);
        shot
    }

    /// Adds the light that all contenders share to the image of one.
    pub fn add_layer(&self, image: &mut Image) {
        let Some(layer) = &self.layer else {
            return;
        };
        for (pixel, light) in image.pixels.iter_mut().zip(&layer.pixels) {
            (0..3).for_each(|c| pixel[c] += light[c]);
        }
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
        self.ray_through(x, y)
    }

    /// What finding the first hits of so many samples a pixel takes, as a found parameter: a rasteriser would need no ray.
    pub fn camera_rays(&self, samples: u32) -> (&'static str, f64) {
        ("camera_rays", self.pixels() as f64 * f64::from(samples))
    }

    /// The camera ray through a film position in pixels, the top left corner at (0, 0).
    pub fn ray_through(&self, x: f64, y: f64) -> Ray {
        let size = [self.width, self.height];
        let direction = self.view.direction_within(self.half_tangents, [x, y], size);
        Ray::new(self.view.origin.as_vec3(), direction)
    }

    /// The surface that a camera sample sees, through mirrors, glass and opacity masks where the
    /// technique loads materials; `None` for the background. Choices between reflection and
    /// transmission depend on pixel and sample alone, so that all contenders and the reference see
    /// the same.
    pub fn look(&self, caster: &Caster, pixel: u32, sample: u32) -> Option<Seen> {
        self.look_out(caster, pixel, sample).ok()
    }

    /// As [`Shot::look`], and for the background what the sample sees of it.
    pub fn look_out(&self, caster: &Caster, pixel: u32, sample: u32) -> Result<Seen, Missed> {
        let ray = self.camera_ray(pixel, sample);
        let hit = caster.closest(&ray);
        self.look_on(caster, [pixel, sample], ray, hit)
    }

    /// What `samples` of a tile of neighbouring pixels see, pixel by pixel: exactly what
    /// [`Shot::look`] answers, but the camera rays of a tile are cast together.
    pub fn look_tile(
        &self,
        caster: &Caster,
        pixels: &[u32],
        samples: Range<u32>,
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
                seen.extend(
                    self.look_on(caster, [pixel, sample], rays[at], hits[at])
                        .ok(),
                );
            }
        }
    }

    /// The surface that a sample sees: opaque, because whether the sample
    /// passes an opacity mask is decided where it is cast.
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
        mut ray: Ray,
        mut hit: Option<Hit>,
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
pub(super) const TILE: usize = 8;

/// Row-major indices of the tile whose top left pixel this is, above row `bottom`.
pub(super) fn tile_pixels(shot: &Shot, [left, top]: [usize; 2], bottom: usize) -> Vec<u32> {
    let right = (left + TILE).min(shot.width);
    let rows = top..(top + TILE).min(shot.height).min(bottom);
    let row = |y: usize| (left..right).map(move |x| (y * shot.width + x) as u32);
    rows.flat_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Bsdf, ColourSource, Needs, find_scene};
    use crate::trace::RayCounter;

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
            roughness: None,
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
        let shot = Shot::new(Moment::still(&scene, &tracer), &scene.views[0], film);
        assert!(shot.specular);
        let counter = RayCounter::default();
        let caster = tracer.caster(&counter);
        let single: Vec<Seen> = (0..shot.pixels() as u32)
            .flat_map(|pixel| (0..shot.spp).map(move |sample| (pixel, sample)))
            .filter_map(|(pixel, sample)| shot.look(&caster, pixel, sample))
            .collect();
        let passed = single.iter().filter(|seen| seen.throughput != Vec3::ONE);
        assert!(passed.count() > 50, "samples that pass mirrors");
        let mut tiled = Vec::new();
        for top in (0..shot.height).step_by(TILE) {
            for left in (0..shot.width).step_by(TILE) {
                let tile = tile_pixels(&shot, [left, top], shot.height);
                shot.look_tile(&caster, &tile, 0..shot.spp, &mut tiled);
            }
        }
        tiled.sort_by_key(|seen| (seen.pixel, seen.sample));
        assert_eq!(single.len(), tiled.len());
        for (a, b) in single.iter().zip(&tiled) {
            assert_eq!(format!("{a:?}"), format!("{b:?}"));
        }
    }
}
