//! Choosing a light: emitting triangles, points, parallel light and the environment.

mod choice;
mod emit;
mod even;
mod guide;
mod met;
mod near;
mod place;
mod point;
mod shared;
mod tile;

pub use emit::{Emitted, Source};
pub use even::EvenLights;
pub use met::Way;
pub use place::{Arriving, ChosenPlace, LIGHT_GROUPS, LightPlace, Unshadowed};
pub use shared::SharedTiles;
pub use tile::{LightTile, Sent, TilePart};

use glam::Vec3;

use self::choice::{EmittingShape, Total, radiant_exitance};
use self::guide::Guide;
use self::near::SphericalTriangle;
use super::surface::Interaction;
use crate::image::luminance;
use crate::sample::Rng;
use crate::scene::Scene;
use crate::trace::{Ray, offset_origin};

/// All lights of a scene: emitting shapes, points, parallel light and the environment. Each is chosen half by its power and
/// half as often as any other, so that a strong light far away cannot starve a lamp; places on it are chosen by power.
pub struct Lights<'a> {
    scene: &'a Scene,
    triangles: Vec<EmittingTriangle>,
    /// Running sums of the triangles' power.
    triangle_power: Vec<f64>,
    /// Running sums of the probabilities with which triangles are chosen, and points and parallel light likewise.
    triangle_sums: Vec<f64>,
    triangle_guide: Guide,
    point_sums: Vec<f64>,
    parallel_sums: Vec<f64>,
    /// Index of a shape's first entry in `triangles`, for shapes that emit.
    first_of_shape: Vec<Option<u32>>,
    all: Total,
    /// Probability of triangles, points, parallel light and the environment; all zero when nothing shines.
    groups: [f64; 4],
}

#[derive(Clone, Copy, Debug)]
struct EmittingTriangle {
    /// Index into the scene's triangles.
    number: u32,
    corner: Vec3,
    edges: [Vec3; 2],
    normal: Vec3,
    emission: Vec3,
    /// Probability among all lights over the area: density per unit area.
    pdf_area: f32,
    centre: Vec3,
    /// Squared longest edge.
    edge2: f32,
}

/// A point of an emitting triangle that shines to a position.
struct FacingPoint {
    point: Vec3,
    /// Unit, of its triangle.
    normal: Vec3,
    /// Unit, towards it.
    direction: Vec3,
    /// Density per steradian of a choice among all lights.
    pdf_sr: f32,
}

impl EmittingTriangle {
    /// The point at a place in [0, 1)².
    fn point(&self, [u, v]: [f32; 2]) -> Vec3 {
        let root = u.sqrt();
        self.corner + self.edges[0] * (root * (1.0 - v)) + self.edges[1] * (root * v)
    }

    /// Whether places are spread over directions, not over the area, for a position: see [`near`].
    fn is_near(&self, position: Vec3) -> bool {
        let height = (position - self.corner).dot(self.normal);
        near::is_near(position.distance_squared(self.centre), height, self.edge2)
    }

    /// The same, chosen among all lights.
    fn chosen(&self, at: [f32; 2]) -> ChosenPlace {
        ChosenPlace {
            place: LightPlace::Triangle(self.number, at),
            density: self.pdf_area,
        }
    }

    /// The point that a place in [0, 1)² is for a position: where that is near, one in a direction of its own.
    fn facing_place(&self, position: Vec3, at: [f32; 2]) -> Option<FacingPoint> {
        if !self.is_near(position) {
            return self.facing(position, at);
        }
        let [position, corner, normal] = [position, self.corner, self.normal].map(Vec3::as_dvec3);
        let way = corner - position;
        let [first, second] = self.edges.map(Vec3::as_dvec3);
        let height = -way.dot(normal);
        let seen = SphericalTriangle::of([way, way + first, way + second])?;
        let direction = seen.direction(at.map(f64::from));
        let distance = height / -direction.dot(normal);
        let area = 0.5 * first.cross(second).length();
        let pdf_sr = (f64::from(self.pdf_area) * area / seen.solid_angle) as f32;
        let shines = height > 0.0 && distance.is_finite() && distance > 0.0 && pdf_sr > 0.0;
        shines.then(|| FacingPoint {
            point: (position + direction * distance).as_vec3(),
            normal: self.normal,
            direction: direction.as_vec3(),
            pdf_sr,
        })
    }

    /// The point at a place in [0, 1)², unless it does not shine to a position.
    fn facing(&self, position: Vec3, at: [f32; 2]) -> Option<FacingPoint> {
        FacingPoint::of(self.point(at), self.normal, self.pdf_area, position)
    }
}

impl FacingPoint {
    /// A point of a triangle with this normal, selected with this density per unit area, as seen from a position.
    fn of(point: Vec3, normal: Vec3, pdf_area: f32, position: Vec3) -> Option<Self> {
        let towards = point - position;
        let distance2 = towards.length_squared();
        let direction = towards.try_normalize()?;
        let cos = -direction.dot(normal);
        let pdf_sr = pdf_area * distance2 / cos;
        (cos > 0.0 && pdf_sr.is_finite() && pdf_sr > 0.0).then_some(Self {
            point,
            normal,
            direction,
            pdf_sr,
        })
    }
}

/// A light seen from a surface point.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit, towards the light.
    pub direction: Vec3,
    /// Radiance, or irradiance of a facing surface when `delta`.
    pub radiance: Vec3,
    /// Density per steradian; the probability of the choice when `delta`.
    pub pdf_sr: f32,
    /// Whether sampling directions cannot find this light.
    pub delta: bool,
    /// Unoccluded when nothing is met by this ray.
    pub shadow_ray: Ray,
}

impl<'a> Lights<'a> {
    /// Collects what emits. Non-finite and negative emission counts as none.
    pub fn new(scene: &'a Scene) -> Self {
        let mut lights = Self {
            scene,
            triangles: Vec::new(),
            triangle_power: Vec::new(),
            triangle_sums: Vec::new(),
            triangle_guide: Guide::default(),
            point_sums: Vec::new(),
            parallel_sums: Vec::new(),
            first_of_shape: vec![None; scene.shapes.len()],
            all: Total::default(),
            groups: [0.0; 4],
        };
        lights.collect_triangles();
        lights.set_chances();
        lights
    }

    fn collect_triangles(&mut self) {
        let mut total = 0.0;
        let scene = self.scene;
        for (shape, first) in scene.shapes.iter().zip(&mut self.first_of_shape) {
            if shape.emission.is_none_or(|mean| usable(mean) <= 0.0) {
                continue;
            }
            *first = Some(self.triangles.len() as u32);
            let range = shape.first_triangle as usize..;
            let corners = &scene.triangles[range][..shape.triangle_count as usize];
            for (number, corners) in (shape.first_triangle..).zip(corners) {
                let [p0, p1, p2] = corners.map(|i| scene.positions[i as usize]);
                let edges = [p1 - p0, p2 - p0];
                let doubled = edges[0].as_dvec3().cross(edges[1].as_dvec3());
                let area = 0.5 * doubled.length();
                let emission = shape.emission_of(number).unwrap_or_default();
                total += area * radiant_exitance(emission);
                self.triangle_power.push(total);
                self.triangles.push(EmittingTriangle {
                    number,
                    corner: p0,
                    edges,
                    normal: doubled.normalize_or_zero().as_vec3(),
                    emission: emission.into(),
                    pdf_area: 0.0,
                    centre: (p0 + p1 + p2) / 3.0,
                    edge2: [p1 - p0, p2 - p1, p0 - p2]
                        .map(Vec3::length_squared)
                        .into_iter()
                        .fold(0.0, f32::max),
                });
            }
        }
    }

    /// Whether nothing shines.
    pub fn is_dark(&self) -> bool {
        self.groups == [0.0; 4]
    }

    /// One light as seen from `from`; `None` where the chosen light cannot reach it.
    pub fn sample(&self, from: &Interaction, rng: &mut Rng) -> Option<LightSample> {
        if self.is_dark() {
            return None;
        }
        let choice = rng.next_f64();
        let [u, v] = [rng.next_f64(), rng.next_f64()];
        let [area, points, parallel, _] = self.groups;
        if let Some(light) = self.triangle_for(choice) {
            self.sample_triangle(light, from, [u as f32, v as f32])
        } else if choice < area + points {
            self.sample_point(from, (choice - area) / points)
        } else if choice < area + points + parallel {
            self.sample_parallel(from, (choice - (area + points)) / parallel)
        } else {
            self.sample_environment([u, v], from)
        }
    }

    /// The emitting triangle that a number in [0, 1) selects among all lights; `None` where it selects another light.
    fn triangle_for(&self, choice: f64) -> Option<&EmittingTriangle> {
        let area = self.groups[0];
        (choice < area).then(|| &self.triangles[self.pick_triangle(choice / area)])
    }

    /// The emitting triangle that a number in [0, 1) selects.
    fn pick_triangle(&self, choice: f64) -> usize {
        self.triangle_guide.pick(&self.triangle_sums, choice)
    }

    fn sample_environment(&self, place: [f64; 2], from: &Interaction) -> Option<LightSample> {
        let sample = self.scene.environment.as_ref()?.sample(place)?;
        Some(LightSample {
            direction: sample.direction,
            radiance: sample.radiance.into(),
            pdf_sr: sample.pdf_sr * self.groups[3] as f32,
            delta: false,
            shadow_ray: self.spawn(from, sample.direction),
        })
    }

    fn sample_triangle(
        &self,
        light: &EmittingTriangle,
        from: &Interaction,
        place: [f32; 2],
    ) -> Option<LightSample> {
        self.triangle_sample(light, from, &light.facing(from.position, place)?)
    }

    fn triangle_sample(
        &self,
        light: &EmittingTriangle,
        from: &Interaction,
        facing: &FacingPoint,
    ) -> Option<LightSample> {
        Some(LightSample {
            direction: facing.direction,
            radiance: light.emission,
            pdf_sr: facing.pdf_sr,
            delta: false,
            shadow_ray: self.shadow_ray(from, facing.direction, [facing.point, facing.normal])?,
        })
    }

    /// The ray from a surface in a direction to a point of an emitting triangle with this normal.
    fn shadow_ray(
        &self,
        from: &Interaction,
        direction: Vec3,
        [point, normal]: [Vec3; 2],
    ) -> Option<Ray> {
        let start = self.spawn(from, direction).origin;
        let end = offset_origin(point, normal, self.scene.diagonal);
        let way = end - start;
        let length = way.length();
        Some(Ray {
            t_max: length * (1.0 - 1e-6),
            ..Ray::new(start, way.try_normalize()?)
        })
    }

    fn sample_parallel(&self, from: &Interaction, choice: f64) -> Option<LightSample> {
        let index = pick(&self.parallel_sums, choice);
        self.parallel_sample(index, from)
    }

    /// Directional light number `index` as seen from a surface.
    fn parallel_sample(&self, index: usize, from: &Interaction) -> Option<LightSample> {
        let (travel, irradiance) = *self.scene.directional_lights.get(index)?;
        let direction = -travel.try_normalize()?;
        Some(LightSample {
            direction,
            radiance: irradiance.into(),
            pdf_sr: self.parallel_chance(index) as f32,
            delta: true,
            shadow_ray: self.spawn(from, direction),
        })
    }

    fn disk(&self) -> f64 {
        let radius = f64::from(self.scene.diagonal) * 0.5;
        std::f64::consts::PI * radius * radius
    }

    /// A ray that leaves the surface on the side of `direction`.
    pub fn spawn(&self, from: &Interaction, direction: Vec3) -> Ray {
        let side = if direction.dot(from.geometric_normal) < 0.0 {
            -from.geometric_normal
        } else {
            from.geometric_normal
        };
        Ray::new(
            offset_origin(from.position, side, self.scene.diagonal),
            direction,
        )
    }

    /// Radiance emitted at `at` towards its viewer: on the front of the geometric normal only.
    pub fn emitted(&self, at: &Interaction) -> Vec3 {
        match self.triangle_of(at) {
            Some(light) if at.view.dot(at.geometric_normal) > 0.0 => light.emission,
            _ => Vec3::ZERO,
        }
    }

    /// Whether a surface emits, on either side.
    pub fn shines(&self, at: &Interaction) -> bool {
        self.triangle_of(at).is_some()
    }

    /// Density (1/sr) with which [`Lights::sample`] finds the emitting point `at`, `distance` away
    /// against its `view`.
    pub fn pdf_emitted(&self, at: &Interaction, distance: f32) -> f32 {
        let cos = at.view.dot(at.geometric_normal);
        match self.triangle_of(at) {
            Some(light) if cos > 0.0 => light.pdf_area * distance * distance / cos,
            _ => 0.0,
        }
    }

    fn triangle_of(&self, at: &Interaction) -> Option<&EmittingTriangle> {
        self.triangle_of_shape(at.shape, at.triangle)
    }

    /// What triangle `number` of the scene emits.
    fn triangle_numbered(&self, number: u32) -> Option<&EmittingTriangle> {
        let shape = *self.scene.triangle_shape.get(number as usize)?;
        self.triangle_of_shape(shape, number)
    }

    /// What triangle `number` of the scene, which belongs to a shape, emits.
    fn triangle_of_shape(&self, shape: u32, number: u32) -> Option<&EmittingTriangle> {
        let first = (*self.first_of_shape.get(shape as usize)?)?;
        let offset = number - self.scene.shapes[shape as usize].first_triangle;
        self.triangles.get((first + offset) as usize)
    }

    /// Radiance of the environment from a direction; black without one.
    pub fn environment(&self, direction: Vec3) -> Vec3 {
        self.scene
            .environment
            .as_ref()
            .map_or(Vec3::ZERO, |e| e.radiance(direction).into())
    }

    /// Density (1/sr) with which [`Lights::sample`] finds the environment in `direction`.
    pub fn pdf_environment(&self, direction: Vec3) -> f32 {
        self.scene
            .environment
            .as_ref()
            .map_or(0.0, |e| e.pdf(direction) * self.groups[3] as f32)
    }
}

/// Luminance of a light's colour; 0 unless all channels are finite and none is negative.
fn usable(rgb: [f32; 3]) -> f64 {
    if rgb.iter().all(|c| c.is_finite() && *c >= 0.0) {
        f64::from(luminance(rgb))
    } else {
        0.0
    }
}

/// The entry of a running sum that `u` in [0, 1) falls into.
fn pick(sums: &[f64], u: f64) -> usize {
    let target = u * sums[sums.len() - 1];
    sums.partition_point(|&s| s <= target).min(sums.len() - 1)
}

#[cfg(test)]
mod tests;
