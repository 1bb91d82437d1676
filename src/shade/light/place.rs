//! Places on lights, which several surfaces can be lit from: what lets them share light samples.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{Lights, pick};
use crate::sample::Rng;
use crate::shade::surface::Interaction;
use crate::trace::Ray;

/// A place on a light, whichever surface it lights. Densities over places are per unit area (scene units) of emitting
/// triangles and per steradian of the environment; lights without extent have probabilities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LightPlace {
    /// Index into the scene's triangles, and where on it: [0, 1)², even over its area, or, for surfaces near by, over the
    /// directions to it. Either way it is a place of the triangle's area that densities are of.
    Triangle(u32, [f32; 2]),
    /// Index into the scene's point and spot lights.
    Point(u32),
    /// Index into the scene's directional lights.
    Parallel(u32),
    /// Where on the map, as [`crate::environment::Environment::sample`] takes it: [0, 1)², even in power.
    Environment([f32; 2]),
}

/// Groups of lights that are remembered apart.
pub const LIGHT_GROUPS: usize = 16;
/// Parts of the environment along each side, even in power.
const ENVIRONMENT_PARTS: u32 = 4;

/// A place that was selected at random.
#[derive(Clone, Copy, Debug)]
pub struct ChosenPlace {
    /// Which light, and where on it.
    pub place: LightPlace,
    /// Density over places with which it was selected.
    pub density: f32,
}

/// What a place on a light sends to a surface, unless something is between them.
#[derive(Clone, Copy, Debug)]
pub struct Arriving {
    /// Unit, towards the light.
    pub direction: Vec3,
    /// Irradiance of a facing surface for each unit of the measure of places: emitted radiance times cosine over squared
    /// distance of a triangle, radiance of the environment, irradiance of a light without extent.
    pub irradiance: Vec3,
    /// Unoccluded when nothing is met by this ray.
    pub shadow_ray: Ray,
}

/// What a place on a light sends to a surface, without the way between them: see [`Arriving`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Unshadowed {
    /// Unit, towards the light.
    pub direction: Vec3,
    /// As in [`Arriving`].
    pub irradiance: Vec3,
}

impl Lights<'_> {
    /// A place by power, with the density of [`Lights::sample`]; `choice` in [0, 1) selects the light. `None` where
    /// nothing shines.
    pub fn choose(&self, choice: f64, rng: &mut Rng) -> Option<ChosenPlace> {
        if self.is_dark() {
            return None;
        }
        self.choose_at(choice, [rng.next_f32(), rng.next_f32()])
    }

    /// [`Lights::choose`] of something that shines, with the random numbers of the place on it.
    pub(super) fn choose_at(&self, choice: f64, at: [f32; 2]) -> Option<ChosenPlace> {
        let [area, points, parallel, _] = self.groups;
        if let Some(light) = self.triangle_for(choice) {
            Some(light.chosen(at))
        } else if choice < area + points {
            let index = pick(&self.point_sums, (choice - area) / points);
            Some(ChosenPlace {
                place: LightPlace::Point(index as u32),
                density: self.point_chance(index) as f32,
            })
        } else if choice < area + points + parallel {
            let index = pick(&self.parallel_sums, (choice - (area + points)) / parallel);
            Some(ChosenPlace {
                place: LightPlace::Parallel(index as u32),
                density: self.parallel_chance(index) as f32,
            })
        } else {
            let chosen = self.choose_environment(at)?;
            Some(ChosenPlace {
                density: chosen.density * self.groups[3] as f32,
                ..chosen
            })
        }
    }

    /// Which of [`LIGHT_GROUPS`] groups a place is in: all of an emitting shape in one, the environment in parts.
    pub fn group(&self, place: &LightPlace) -> u32 {
        let number = match *place {
            LightPlace::Triangle(triangle, _) => self.scene.triangle_shape[triangle as usize],
            LightPlace::Point(number) | LightPlace::Parallel(number) => number,
            LightPlace::Environment(at) => {
                let [u, v] = at.map(|x| (x * ENVIRONMENT_PARTS as f32) as u32);
                v * ENVIRONMENT_PARTS + u
            }
        };
        number % LIGHT_GROUPS as u32
    }

    /// The place `at` of the environment, with its density among those of the environment alone. `None` without one.
    pub fn choose_environment(&self, at: [f32; 2]) -> Option<ChosenPlace> {
        let environment = self.scene.environment.as_ref()?;
        Some(ChosenPlace {
            place: LightPlace::Environment(at),
            density: environment.sample(at.map(f64::from))?.pdf_sr,
        })
    }

    /// The direction and the irradiance of [`Lights::arriving`], which take less than the shadow ray.
    pub fn unshadowed(&self, place: &LightPlace, from: &Interaction) -> Option<Unshadowed> {
        match *place {
            LightPlace::Triangle(number, at) => {
                let light = self.triangle_numbered(number)?;
                let facing = light.facing_place(from.position, at)?;
                Some(Unshadowed {
                    direction: facing.direction,
                    irradiance: light.emission * (light.pdf_area / facing.pdf_sr),
                })
            }
            LightPlace::Point(_) => {
                let arriving = self.arriving(place, from)?;
                Some(Unshadowed {
                    direction: arriving.direction,
                    irradiance: arriving.irradiance,
                })
            }
            LightPlace::Parallel(_) | LightPlace::Environment(_) => self.distant(place),
        }
    }

    /// What a place at infinity sends to any surface; `None` of other places.
    pub(super) fn distant(&self, place: &LightPlace) -> Option<Unshadowed> {
        let (direction, irradiance) = match *place {
            LightPlace::Parallel(index) => {
                let (travel, irradiance) = *self.scene.directional_lights.get(index as usize)?;
                (-travel.try_normalize()?, irradiance)
            }
            LightPlace::Environment(at) => {
                let sample = self.scene.environment.as_ref()?.sample(at.map(f64::from))?;
                (sample.direction, sample.radiance)
            }
            LightPlace::Triangle(..) | LightPlace::Point(_) => return None,
        };
        Some(Unshadowed {
            direction,
            irradiance: irradiance.into(),
        })
    }

    /// What a place sends to a surface; `None` where it cannot reach it, or shines no longer.
    pub fn arriving(&self, place: &LightPlace, from: &Interaction) -> Option<Arriving> {
        let sample = match *place {
            LightPlace::Triangle(number, at) => {
                let light = self.triangle_numbered(number)?;
                let facing = light.facing_place(from.position, at)?;
                let mut sample = self.triangle_sample(light, from, &facing)?;
                // The density of directions is that of the place over this factor.
                sample.radiance *= light.pdf_area / sample.pdf_sr;
                sample
            }
            LightPlace::Point(index) => {
                let light = self.scene.point_lights.get(index as usize)?;
                self.point_sample(light, 1.0, from)?
            }
            LightPlace::Parallel(index) => self.parallel_sample(index as usize, from)?,
            LightPlace::Environment(at) => self.sample_environment(at.map(f64::from), from)?,
        };
        Some(Arriving {
            direction: sample.direction,
            irradiance: sample.radiance,
            shadow_ray: sample.shadow_ray,
        })
    }
}
