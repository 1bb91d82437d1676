//! Surfaces that are lit: what of them is remembered, and what a light sample is worth at one.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::image::luminance;
use crate::sample::Rng;
use crate::shade::{Arriving, ChosenPlace, Interaction, LightPlace, LightTile, Sent, Unshadowed};
use crate::technique::Shot;
use crate::trace::{Caster, Hit, Ray};

/// A surface that a pixel shows, by its place on the scene's triangles: it moves with them.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Surface {
    pub hit: Hit,
    /// Unit direction of the ray that met it.
    pub direction: Vec3,
    /// Unit shading normal on the viewer's side, when it was seen.
    pub normal: Vec3,
    /// Length of the path from the camera, scene units.
    pub depth: f32,
}

/// A surface ready to be lit.
pub struct Receiver<'a> {
    shot: &'a Shot<'a>,
    at: Interaction<'a>,
}

/// How different surfaces may be that share samples.
#[derive(Clone, Copy, Debug)]
pub struct Tolerances {
    /// Least cosine between their normals.
    pub cosine: f32,
    /// Largest difference of their depths, relative.
    pub depth: f32,
}

impl Surface {
    /// What a ray met, `depth` away from the camera. Whether it passes an opacity mask is decided.
    pub fn new(shot: &Shot, hit: Hit, direction: Vec3, depth: f32) -> Self {
        let at = shot.paths.surfaces().interact(&hit, direction);
        Self {
            hit,
            direction,
            normal: at.facing_shading_normal(),
            depth,
        }
    }

    /// Whether samples may pass between this surface and another; `depth` is the other's distance from the camera that
    /// saw this one.
    pub fn resembles(&self, normal: Vec3, depth: f32, tolerances: Tolerances) -> bool {
        let near = (self.depth - depth).abs() <= tolerances.depth * depth.abs();
        near && self.normal.dot(normal) >= tolerances.cosine
    }
}

impl<'a> Receiver<'a> {
    /// The surface where it is now.
    pub fn new(shot: &'a Shot<'a>, surface: &Surface) -> Self {
        let surfaces = shot.paths.surfaces();
        let mut at = surfaces.interact(&surface.hit, surface.direction);
        at.bsdf.opacity = 1.0;
        Self { shot, at }
    }

    /// Scene units.
    pub fn position(&self) -> Vec3 {
        self.at.position
    }

    /// What a place on a light sends, and what of it the surface scatters to the camera, without shadows, for each unit of
    /// the measure of places. `None` where that is nothing.
    pub fn scattered(&self, place: &LightPlace) -> Option<(Vec3, Arriving)> {
        let arriving = self.shot.paths.lights().arriving(place, &self.at)?;
        let scattered = self.at.evaluate(arriving.direction) * arriving.irradiance;
        (scattered != Vec3::ZERO).then_some((scattered, arriving))
    }

    /// p̂: what selects samples, the luminance of [`Receiver::scattered`]. 0 where that is not finite.
    pub fn target(&self, place: &LightPlace) -> f32 {
        let light = self.shot.paths.lights().unshadowed(place, &self.at);
        light.map_or(
            0.0,
            |Unshadowed {
                 direction,
                 irradiance,
             }| { target_of(self.at.evaluate(direction) * irradiance) },
        )
    }

    /// The places of a tile that add anything, with their targets.
    pub fn each_lit(&self, tile: &LightTile, mut offer: impl FnMut(ChosenPlace, f32)) {
        let mut sent = Sent::default();
        for part in tile.parts() {
            part.send(self.shot.paths.lights(), &self.at, &mut sent);
            let candidates = part.places().iter().zip(part.density());
            for ((&place, &density), target) in candidates.zip(sent.scattered(&self.at)) {
                if target.is_finite() && target > 0.0 {
                    offer(ChosenPlace { place, density }, target);
                }
            }
        }
    }

    /// A ray in a direction that the surface draws by how it scatters; `None` where that absorbs it, or is a mirror.
    pub fn sampled_ray(&self, rng: &mut Rng) -> Option<Ray> {
        let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        let sample = self.at.sample(u).filter(|sample| !sample.delta)?;
        let lights = self.shot.paths.lights();
        Some(lights.spawn(&self.at, sample.direction))
    }

    /// The place on a light that such a ray met: see [`crate::shade::Lights::place_met`].
    pub fn place_met(&self, hit: Option<&Hit>, direction: Vec3) -> Option<ChosenPlace> {
        let lights = self.shot.paths.lights();
        lights.place_met(hit, direction, &self.at)
    }

    /// Density over places with which such rays, where nothing is between, come to one. 0 of lights without extent.
    pub fn density(&self, place: &LightPlace) -> f32 {
        let way = self.shot.paths.lights().way(place, &self.at);
        way.map_or(0.0, |way| self.at.pdf(way.direction) * way.steradians)
    }

    /// The target, 0 in shadow.
    pub fn shadowed_target(&self, caster: &Caster, place: &LightPlace) -> f32 {
        match self.scattered(place) {
            Some((rgb, arriving)) if target_of(rgb) > 0.0 => {
                match self.shot.paths.occluded(caster, &arriving.shadow_ray) {
                    true => 0.0,
                    false => target_of(rgb),
                }
            }
            _ => 0.0,
        }
    }
}

fn target_of(scattered: Vec3) -> f32 {
    let target = luminance(scattered.into());
    if target.is_finite() {
        target.max(0.0)
    } else {
        0.0
    }
}
