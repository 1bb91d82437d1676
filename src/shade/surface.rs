//! What a ray meets: position, orientation, scattering and emission at a hit.

mod blend;
mod materials;
mod normals;

use glam::{Vec2, Vec3};

use self::blend::Met;
pub use self::materials::Surfaces;
use self::materials::{Place, grey};
use super::bsdf::{
    BsdfSample, Incident, LANES, Lanes, Lobes, LocalBsdf, Model, VectorLanes, to_local,
};
use crate::sample::Frame;
use crate::scene::Scene;
use crate::trace::Hit;

/// A surface point seen from a direction.
#[derive(Clone, Copy, Debug)]
pub struct Interaction<'a> {
    /// World space.
    pub position: Vec3,
    /// Unit, on the side of the counter-clockwise winding.
    pub geometric_normal: Vec3,
    /// Unit, interpolated; not turned towards the viewer.
    pub shading_normal: Vec3,
    /// Texture coordinates, interpolated; barycentric ones where the shape has none.
    pub uv: Vec2,
    /// Index into the scene's shapes.
    pub shape: u32,
    /// Index into the scene's triangles.
    pub triangle: u32,
    /// Scattering in the frame of `normal_frame`.
    pub bsdf: LocalBsdf<'a>,
    /// Frame about the shading normal after bump mapping.
    frame: Frame,
    /// See [`normals::bend`]; 0 where terminators are hard.
    bend: f32,
    /// Unit, towards where the path comes from.
    pub view: Vec3,
    local_view: Vec3,
}

impl Surfaces<'_> {
    /// The surface at `hit`, seen along `direction` (the unit direction of the ray).
    pub fn interact(&self, hit: &Hit, direction: Vec3) -> Interaction<'_> {
        let scene = self.scene;
        let corners = scene.triangles[hit.triangle as usize].map(|i| i as usize);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let [p0, p1, p2] = corners.map(|i| scene.positions[i]);
        let (e1, e2) = (p1 - p0, p2 - p0);
        let geometric_normal = normals::unit_normal(e1, e2);
        let shading_normal =
            normals::shading_normal(scene, corners, weights).unwrap_or(geometric_normal);
        let corner_uvs = corner_uvs(scene, corners);
        let uv = (0..3).fold(Vec2::ZERO, |sum, i| sum + weights[i] * corner_uvs[i]);
        let shape = scene.triangle_shape.get(hit.triangle as usize).copied();
        let shape = shape.unwrap_or(0);
        let place = Place {
            uv,
            corners,
            weights,
        };
        let met = Met {
            hit,
            direction,
            behind: direction.dot(shading_normal) > 0.0,
            place: &place,
        };
        let declared = scene.shapes.get(shape as usize).map_or(0, |s| s.material);
        let index = self.material_met(declared as usize, &met);
        let material = scene.materials.get(index);
        let mut normal = shading_normal;
        let texture = |index: usize| scene.textures.get(index);
        let tangents = || normals::uv_tangents([e1, e2], corner_uvs, shading_normal);
        let bump = material.and_then(|m| m.bump);
        if let Some((texture, scale)) = bump.and_then(|(i, scale)| Some((texture(i)?, scale))) {
            let gradient = normals::height_gradient(texture, uv) * scale;
            normal = normals::bumped(shading_normal, tangents(), gradient);
            if normal.dot(geometric_normal) < 0.0 {
                normal = -normal;
            }
            normal = normals::turned_to_viewer(normal, shading_normal, -direction);
        }
        if let Some(texture) = material.and_then(|m| m.normals).and_then(texture) {
            let [along, _] = tangents();
            let mapped = normals::mapped(texture, uv, [along, shading_normal]);
            normal = normals::turned_to_viewer(mapped, shading_normal, -direction);
        }
        let frame = Frame::from_normal(normal);
        let soft = material.is_some_and(|m| m.soft_terminators);
        let view = -direction;
        Interaction {
            position: p0 + e1 * hit.u + e2 * hit.v,
            geometric_normal,
            shading_normal,
            uv,
            shape,
            triangle: hit.triangle,
            bsdf: material.map_or_else(grey, |m| self.resolve(m, index, &place)),
            frame,
            bend: if soft {
                normals::bend(normal, shading_normal)
            } else {
                0.0
            },
            view,
            local_view: frame.to_local(view),
        }
    }

    /// The surface at `hit` for those who ask what arrives there or what it emits: grey, with the normal of its triangle.
    pub fn bare(&self, hit: &Hit, direction: Vec3) -> Interaction<'_> {
        let scene = self.scene;
        let corners = scene.triangles[hit.triangle as usize];
        let [p0, p1, p2] = corners.map(|i| scene.positions[i as usize]);
        let (e1, e2) = (p1 - p0, p2 - p0);
        let normal = normals::unit_normal(e1, e2);
        let frame = Frame::from_normal(normal);
        let shape = scene.triangle_shape.get(hit.triangle as usize).copied();
        Interaction {
            position: p0 + e1 * hit.u + e2 * hit.v,
            geometric_normal: normal,
            shading_normal: normal,
            uv: Vec2::new(hit.u, hit.v),
            shape: shape.unwrap_or(0),
            triangle: hit.triangle,
            bsdf: grey(),
            frame,
            bend: 0.0,
            view: -direction,
            local_view: frame.to_local(-direction),
        }
    }
}

impl Interaction<'_> {
    /// Scattering × |cosine| towards the unit world direction `light`, without delta parts.
    pub fn evaluate(&self, light: Vec3) -> Vec3 {
        let local = self.frame.to_local(light);
        if self.inconsistent(local, light) {
            return Vec3::ZERO;
        }
        self.bsdf.evaluate(self.local_view, local) * self.left_of(light)
    }

    /// A world direction in the frame that [`Interaction::scattered`] takes, z along the normal that scattering is
    /// evaluated about.
    pub fn to_local(&self, world: Vec3) -> Vec3 {
        self.frame.to_local(world)
    }

    /// The sum of [`Interaction::evaluate`] times power over directions that are told as [`Interaction::to_local`] has them,
    /// up to rounding.
    pub fn scattered(&self, incident: &mut Incident) -> Vec3 {
        if self.is_plain() {
            return self.bsdf.scattered(self.local_view, incident);
        }
        let one = |(local, power): (Vec3, Vec3)| self.evaluate(self.frame.to_world(local)) * power;
        incident.each(self.viewer_side()).map(one).sum()
    }

    /// Luminance of [`Interaction::evaluate`] times irradiance for unit world directions, up to rounding. `None` of materials
    /// that are evaluated one direction after another.
    pub fn luminances(&self, directions: &VectorLanes, irradiance: &VectorLanes) -> Option<Lanes> {
        if !self.is_plain() {
            return None;
        }
        let mut local = [[0.0; LANES]; 3];
        to_local(directions, &self.frame, &mut local);
        self.bsdf.luminances(self.local_view, &local, irradiance)
    }

    /// Whether the material alone says what is scattered: no bump mapping and no soft terminator.
    fn is_plain(&self) -> bool {
        self.bend == 0.0 && self.frame.normal == self.shading_normal
    }

    /// Sign of z of the viewer in the frame of [`Interaction::to_local`]; 0 counts as above.
    fn viewer_side(&self) -> f32 {
        if self.local_view.z < 0.0 { -1.0 } else { 1.0 }
    }

    /// Density (1/sr) of [`Interaction::sample`] for the unit world direction `light`.
    pub fn pdf(&self, light: Vec3) -> f32 {
        let local = self.frame.to_local(light);
        if self.inconsistent(local, light) {
            return 0.0;
        }
        self.bsdf.pdf(self.local_view, local)
    }

    /// See [`LocalBsdf::directional_albedo`].
    pub fn directional_albedo(&self) -> Vec3 {
        self.bsdf.directional_albedo(self.local_view)
    }

    /// See [`LocalBsdf::base_albedo`].
    pub fn base_albedo(&self) -> Vec3 {
        self.bsdf.base_albedo(self.local_view)
    }

    /// See [`LocalBsdf::reflections`]; unit world directions.
    pub fn reflections(&self) -> impl Iterator<Item = (Vec3, Vec3)> {
        let reflections = self.bsdf.reflections(self.local_view);
        reflections.filter_map(|(local, weight)| {
            let world = self.frame.to_world(local);
            let weight = weight * self.left_of(world);
            (!self.inconsistent(local, world)).then_some((world, weight))
        })
    }

    /// What the scattering of light that arrives along `view` must be multiplied by so that paths
    /// from the lights agree with paths from the camera where shading normals differ from geometric
    /// ones: `|view·n| |light·g| / (|view·g| |light·n|)` (Veach 1997, section 5.3.2), and soft terminators weaken what
    /// arrives. 1 where they agree, 0 where a direction grazes.
    pub fn adjoint(&self, light: Vec3) -> f32 {
        let (n, g) = (self.frame.normal, self.geometric_normal);
        if n == g {
            return 1.0;
        }
        let soft = self.left_of(self.view) / self.left_of(light);
        let factor = soft * self.view.dot(n) * light.dot(g) / (self.view.dot(g) * light.dot(n));
        if factor.is_finite() {
            factor.abs()
        } else {
            0.0
        }
    }

    /// The geometric normal on the side of the viewer.
    pub fn facing_normal(&self) -> Vec3 {
        if self.view.dot(self.geometric_normal) < 0.0 {
            -self.geometric_normal
        } else {
            self.geometric_normal
        }
    }

    /// The normal that scattering is evaluated about, on the side of the viewer.
    pub fn facing_shading_normal(&self) -> Vec3 {
        if self.local_view.z < 0.0 {
            -self.frame.normal
        } else {
            self.frame.normal
        }
    }

    /// What scatters towards the viewer, about [`Interaction::facing_shading_normal`].
    pub fn lobes(&self) -> Lobes {
        let cos = self.local_view.z;
        let cos = if self.bsdf.two_sided { cos.abs() } else { cos };
        self.bsdf.lobes(cos)
    }

    /// Scattering if it is the same for all directions on the viewer's side and none on the other:
    /// reflectance × opacity / π. `None` for other models and for bump mapping.
    pub fn lambertian(&self) -> Option<Vec3> {
        match &self.bsdf.model {
            Model::Diffuse(diffuse) if self.frame.normal == self.shading_normal => {
                let lit = self.bsdf.two_sided || self.local_view.z > 0.0;
                let factor = if lit { self.bsdf.opacity } else { 0.0 };
                Some(diffuse.reflectance * (factor * std::f32::consts::FRAC_1_PI))
            }
            _ => None,
        }
    }

    /// A world direction by importance; `None` absorbs the path.
    pub fn sample(&self, u: [f32; 3]) -> Option<BsdfSample> {
        self.turned_to_world(self.bsdf.sample(self.local_view, u)?)
    }

    /// Whether a sampled direction goes on as if the surface were not there: through its opacity mask, or a pane.
    pub fn goes_straight(&self, sample: &BsdfSample) -> bool {
        sample.delta && self.bsdf.may_be_passed() && sample.direction.dot(self.view) < -0.999_999
    }

    /// See [`LocalBsdf::base_share`]; `light` is a unit world direction.
    pub fn base_share(&self, light: Vec3) -> f32 {
        let local = self.frame.to_local(light);
        if self.inconsistent(local, light) {
            return 0.0;
        }
        self.bsdf.base_share(self.local_view, local) * self.left_of(light)
    }

    /// See [`LocalBsdf::evaluate_gloss`]; `light` is a unit world direction.
    pub fn evaluate_gloss(&self, light: Vec3) -> Vec3 {
        let local = self.frame.to_local(light);
        if self.inconsistent(local, light) {
            return Vec3::ZERO;
        }
        self.bsdf.evaluate_gloss(self.local_view, local) * self.left_of(light)
    }

    /// See [`LocalBsdf::gloss_pdf`]; `light` is a unit world direction.
    pub fn gloss_pdf(&self, light: Vec3) -> f32 {
        let local = self.frame.to_local(light);
        if self.inconsistent(local, light) {
            return 0.0;
        }
        self.bsdf.gloss_pdf(self.local_view, local)
    }

    /// See [`LocalBsdf::gloss_chance`].
    pub fn gloss_chance(&self) -> f32 {
        self.bsdf.gloss_chance(self.local_view)
    }

    /// See [`LocalBsdf::sample_gloss`]; unit world direction.
    pub fn sample_gloss(&self, u: [f32; 3]) -> Option<BsdfSample> {
        let sample = self.bsdf.sample_gloss(self.local_view, u)?;
        self.turned_to_world(sample)
    }

    /// A unit world direction to which either part scatters, the gloss with the chance
    /// [`Interaction::gloss_chance`]. Unlike [`Interaction::sample`] it finds the base where that is black.
    pub fn sample_part(&self, u: [f32; 3]) -> Option<BsdfSample> {
        let chance = self.gloss_chance();
        let local = if u[0] < chance {
            let u = [u[0] / chance, u[1], u[2]];
            let gloss = self.bsdf.sample_gloss(self.local_view, u)?;
            if gloss.delta {
                return self.turned_to_world(BsdfSample {
                    weight: gloss.weight / chance,
                    pdf_sr: gloss.pdf_sr * chance,
                    ..gloss
                });
            }
            gloss.direction
        } else {
            self.bsdf.sample_base(self.local_view, [u[1], u[2]])?
        };
        let pdf_sr = self.local_part_pdf(local);
        if pdf_sr <= 0.0 {
            return None;
        }
        self.turned_to_world(BsdfSample {
            direction: local,
            weight: self.bsdf.evaluate(self.local_view, local) / pdf_sr,
            pdf_sr,
            delta: false,
        })
    }

    /// Density (1/sr) of [`Interaction::sample_part`] for a unit world direction, without delta parts.
    pub fn part_pdf(&self, light: Vec3) -> f32 {
        let local = self.frame.to_local(light);
        if self.inconsistent(local, light) {
            return 0.0;
        }
        self.local_part_pdf(local)
    }

    fn local_part_pdf(&self, local: Vec3) -> f32 {
        let chance = self.gloss_chance();
        let base = (1.0 - chance) * self.bsdf.base_pdf(self.local_view, local);
        base + chance * self.bsdf.gloss_pdf(self.local_view, local)
    }

    fn turned_to_world(&self, sample: BsdfSample) -> Option<BsdfSample> {
        let direction = self.frame.to_world(sample.direction).normalize();
        let consistent = !self.inconsistent(sample.direction, direction);
        consistent.then_some(BsdfSample {
            direction,
            weight: sample.weight * self.left_of(direction),
            ..sample
        })
    }

    /// The share of light from a direction that soft terminators leave.
    fn left_of(&self, light: Vec3) -> f32 {
        match self.bend > 0.0 {
            true => normals::left_by(self.bend, light.dot(self.shading_normal)),
            false => 1.0,
        }
    }

    /// Bump mapping must not turn a direction to the other side of the unperturbed surface.
    fn inconsistent(&self, local: Vec3, world: Vec3) -> bool {
        self.frame.normal != self.shading_normal && local.z * world.dot(self.shading_normal) <= 0.0
    }
}

fn corner_uvs(scene: &Scene, corners: [usize; 3]) -> [Vec2; 3] {
    // The barycentric coordinates stand in, as in Mitsuba, with v downwards there.
    const BARYCENTRIC: [Vec2; 3] = [Vec2::Y, Vec2::ONE, Vec2::ZERO];
    match scene.uvs.is_empty() || corners.iter().any(|&i| scene.uvs[i].is_nan()) {
        true => BARYCENTRIC,
        false => corners.map(|i| scene.uvs[i]),
    }
}
