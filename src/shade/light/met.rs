//! Places on lights that rays of surfaces meet: so surfaces can draw light samples, beside those that are drawn by power.

use glam::Vec3;

use super::near::SphericalTriangle;
use super::{ChosenPlace, EmittingTriangle, LightPlace, Lights};
use crate::shade::surface::Interaction;
use crate::trace::Hit;

/// The way from a surface to a place on a light that has an extent.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Unit, towards the light.
    pub direction: Vec3,
    /// Solid angle of each unit of the measure of places, sr: densities per steradian times this are densities over places.
    pub steradians: f32,
}

/// Cosine of the angle by which rounding may turn the direction to a place of the environment: where places of many dark
/// directions are closer than numbers, they are no places.
const LEAST_COSINE: f32 = 0.9999;

impl Lights<'_> {
    /// The place that a ray from a surface met, or came to without meeting anything, with its density by [`Lights::choose`].
    /// `None` where nothing shines.
    pub fn place_met(
        &self,
        hit: Option<&Hit>,
        direction: Vec3,
        from: &Interaction,
    ) -> Option<ChosenPlace> {
        let Some(hit) = hit else {
            let chosen = self.environment_place(direction)?;
            return Some(ChosenPlace {
                density: chosen.density * self.groups[3] as f32,
                ..chosen
            });
        };
        let light = self.triangle_numbered(hit.triangle)?;
        Some(light.chosen(light.place_of([hit.u, hit.v], from.position)?))
    }

    /// The place of the environment in a direction, with its density among those of the environment alone. `None` where
    /// that is dark.
    pub fn environment_place(&self, direction: Vec3) -> Option<ChosenPlace> {
        let environment = self.scene.environment.as_ref()?;
        let at = environment.place(direction)?.map(below_one);
        let found = environment.sample(at.map(f64::from))?;
        (found.direction.dot(direction) > LEAST_COSINE).then_some(ChosenPlace {
            place: LightPlace::Environment(at),
            density: found.pdf_sr,
        })
    }

    /// The way to a place; `None` where there is none, and to lights without extent.
    pub fn way(&self, place: &LightPlace, from: &Interaction) -> Option<Way> {
        match *place {
            LightPlace::Triangle(number, at) => {
                let light = self.triangle_numbered(number)?;
                let facing = light.facing_place(from.position, at)?;
                Some(Way {
                    direction: facing.direction,
                    steradians: light.pdf_area / facing.pdf_sr,
                })
            }
            LightPlace::Environment(_) => Some(Way {
                direction: self.distant(place)?.direction,
                steradians: 1.0,
            }),
            LightPlace::Point(_) | LightPlace::Parallel(_) => None,
        }
    }
}

impl EmittingTriangle {
    /// The place in [0, 1)² of the point with these weights of the second and third corner, for a position: what
    /// [`EmittingTriangle::facing_place`] undoes.
    fn place_of(&self, [second, third]: [f32; 2], position: Vec3) -> Option<[f32; 2]> {
        if !self.is_near(position) {
            let root = second + third;
            let along = if root > 0.0 { third / root } else { 0.0 };
            return Some([root * root, along].map(|x| below_one(x.into())));
        }
        let [position, corner] = [position, self.corner].map(Vec3::as_dvec3);
        let way = corner - position;
        let edges = self.edges.map(Vec3::as_dvec3);
        let seen = SphericalTriangle::of([way, way + edges[0], way + edges[1]])?;
        let point = way + edges[0] * f64::from(second) + edges[1] * f64::from(third);
        Some(seen.place(point.try_normalize()?).map(below_one))
    }
}

/// The nearest number in [0, 1).
fn below_one(x: f64) -> f32 {
    (x as f32).clamp(0.0, 1.0 - f32::EPSILON / 2.0)
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3};

    use super::*;
    use crate::sample::Rng;
    use crate::scene::{Needs, Scene, SceneDescription, ShapeDescription, ShapeSource, View};
    use crate::shade::Surfaces;
    use crate::trace::{Ray, Tracer};

    /// A floor, `height` below a lamp of two triangles that looks down on it.
    fn scene(height: f64) -> Scene {
        let floor = ShapeDescription::new("floor", ShapeSource::Rectangle);
        let turned = DMat4::from_rotation_x(std::f64::consts::PI);
        let mut lamp = ShapeDescription::new("lamp", ShapeSource::Rectangle);
        lamp.to_world = DMat4::from_translation(DVec3::Z * height) * turned;
        lamp.emission = Some([2.0; 3]);
        let eye = [DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y];
        let description = SceneDescription {
            views: vec![View::look_at("v", eye, 60.0, [8, 8])],
            shapes: vec![floor, lamp],
            ..SceneDescription::default()
        };
        Scene::build(&description, Needs::ALL).expect("a scene")
    }

    /// Places that rays meet are those in the ray's direction, far from a lamp and near it, with the density of all.
    #[test]
    fn the_way_to_a_place_is_that_of_the_ray_that_met_it() {
        for height in [3.0, 0.1] {
            let scene = scene(height);
            let tracer = Tracer::new(&scene.positions, &scene.triangles);
            let counter = crate::trace::RayCounter::default();
            let caster = tracer.caster(&counter);
            let (lights, surfaces) = (Lights::new(&scene), Surfaces::new(&scene));
            let down = Ray::new(Vec3::new(0.1, 0.2, 0.05), -Vec3::Z);
            let hit = caster.closest(&down).expect("the floor");
            let at = surfaces.interact(&hit, down.direction);
            let mut rng = Rng::new(1, 2, 3, 4);
            let mut met = 0;
            for _ in 0..2000 {
                let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
                let direction = at.sample(u).expect("a direction").direction;
                let hit = caster.closest(&lights.spawn(&at, direction));
                let found = lights.place_met(hit.as_ref(), direction, &at);
                assert_eq!(found.is_some(), hit.is_some());
                let Some(found) = found else { continue };
                met += 1;
                let way = lights.way(&found.place, &at).expect("a way");
                let cosine = way.direction.dot(direction);
                assert!(cosine > 0.9999, "{height}: {cosine}");
                // Of the whole lamp the density is even, and it shines alone.
                assert!((found.density - 0.25).abs() < 1e-5, "{}", found.density);
                let light = lights.unshadowed(&found.place, &at).expect("light");
                let expected = 2.0 * way.steradians;
                assert!((light.irradiance.x / expected - 1.0).abs() < 1e-4);
            }
            assert!(met > 100, "{met}");
        }
    }
}
