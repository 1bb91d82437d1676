//! How irradiance changes around a record, from the paths it was gathered with.

use glam::{Mat3, Vec3};

use super::gather::Gatherer;
use crate::sample::{Frame as LocalFrame, HemisphereEdges};
use crate::technique::Site;

/// Radiance and nearness of the directions of one record.
#[derive(Default)]
pub struct Hemisphere {
    /// A channel each.
    radiance: [Vec<f32>; 3],
    /// 1/t, 0 where nothing is hit.
    nearness: Vec<f32>,
}

/// How irradiance changes around a record, world space; columns of matrices belong to the colour
/// channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// `(2π/S) Σ L ω`: its cosine with a normal is the irradiance of a turned surface.
    pub vector: Mat3,
    /// By translation, per scene unit.
    pub gradient: Mat3,
    /// Harmonic mean of the distances that the rays travelled, scene units; infinite in the open.
    pub mean_distance: f32,
}

impl Hemisphere {
    /// The next direction: its radiance and the distance its ray travelled.
    pub fn push(&mut self, light: Vec3, distance: f32) {
        for (channel, value) in self.radiance.iter_mut().zip(light.to_array()) {
            channel.push(value);
        }
        self.nearness.push(1.0 / distance);
    }

    /// What the directions of a whole hemisphere say. Distances below 10⁻⁴ of the diagonal count as
    /// that long.
    pub fn change(&mut self, (gatherer, site): (&Gatherer, &Site), edges: &HemisphereEdges) -> Change {
        let count = self.nearness.len() as f32;
        let nearest = 1e4 / gatherer.frame.scene.diagonal;
        self.nearness.iter_mut().for_each(|near| *near = near.min(nearest));
        let local = LocalFrame::from_normal(site.normal);
        let vector = |channel: &Vec<f32>| {
            let directions = gatherer.directions.iter().zip(channel);
            let sum: Vec3 = directions.map(|(w, value)| *w * *value).sum();
            local.to_world(sum * (std::f32::consts::TAU / count))
        };
        let gradient = |channel: &Vec<f32>| local.to_world(edges.gradient(channel, &self.nearness));
        let [red, green, blue] = &self.radiance;
        let near: f32 = self.nearness.iter().sum();
        Change {
            vector: Mat3::from_cols(vector(red), vector(green), vector(blue)),
            gradient: Mat3::from_cols(gradient(red), gradient(green), gradient(blue)),
            mean_distance: count / near,
        }
    }
}

impl Change {
    /// Irradiance a `step` away at a surface with this normal; never negative. By the step it changes
    /// by at most `clamp` times the record's own, in each channel.
    pub fn extrapolate(&self, own: Vec3, (step, normal): (Vec3, Vec3), clamp: f32) -> Vec3 {
        let turned = self.vector.transpose() * normal;
        let moved = self.gradient.transpose() * step;
        let most = own * clamp;
        (turned + moved.clamp(-most, most)).max(Vec3::ZERO)
    }
}
