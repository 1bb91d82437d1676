//! The cones of one surface point.

use glam::Vec3;

use super::Cone;
use super::surprise::Watch;
use crate::image::luminance;

/// Cones that an entry can have.
pub const MOST_CONES: usize = 8;

/// The cones of one surface point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    pub(super) cones: [Cone; MOST_CONES],
    pub(super) used: usize,
    /// C: how many samples (or updates) its light is the mean of, at most 255; 0 in an entry without an update.
    pub count: f32,
    /// What its last updates say of whether the light has changed.
    pub(super) watch: Watch,
}

impl Entry {
    /// An entry with these cones, of which there are at most [`MOST_CONES`].
    pub fn of(cones: &[Cone], count: f32) -> Self {
        let mut entry = Self {
            count,
            used: cones.len(),
            ..Self::default()
        };
        entry.cones[..cones.len()].copy_from_slice(cones);
        entry
    }

    /// Its cones.
    pub fn cones(&self) -> &[Cone] {
        &self.cones[..self.used]
    }

    /// Light of all its cones: the irradiance of a surface that faced them all.
    pub fn light(&self) -> Vec3 {
        self.cones().iter().map(|cone| cone.light).sum()
    }

    /// The same cones as seen in another frame.
    pub fn carried(&self, direction: impl Fn(Vec3) -> Vec3) -> Self {
        let mut carried = *self;
        for cone in &mut carried.cones[..carried.used] {
            cone.axis = direction(cone.axis);
        }
        carried
    }

    pub(super) fn remove(&mut self, index: usize) {
        self.cones.copy_within(index + 1..self.used, index);
        self.used -= 1;
        self.cones[self.used] = Cone::default();
    }

    /// Gives up what holds no light, or less than this part of all, unless it is `kept`.
    pub(super) fn tidy(&mut self, negligible: f32, kept: &[bool; MOST_CONES]) {
        let all = luminance(self.light().into());
        for index in (0..self.used).rev() {
            let light = luminance(self.cones[index].light.into());
            if light <= 0.0 || (light < negligible * all && !kept[index]) {
                self.remove(index);
            }
        }
    }
}
