//! Where houses stand, and what each of them is like.

use std::f64::consts::PI;

use glam::{DMat4, DVec3};

use super::{FACE_X, FAR_Z, FLOOR, NEAR_Z, SHOP};
use crate::scene::Mesh;
use crate::scene::shapes::Parameters;
use crate::scene::shapes::kit::{jitter, placed};

/// Thickness of a facade.
pub const WALL: f64 = 0.3;

/// A house in its own frame: x along the street from its left end as one faces it, y up, the street
/// towards +z and the facade's front at z = 0.
#[derive(Clone, Copy, Debug)]
pub struct House {
    /// Distinguishes its random numbers.
    pub key: u64,
    pub seed: u64,
    /// -1: the left side of the street (seen towards -z), +1: the right one.
    pub side: f64,
    /// z of its end nearer to z = [`NEAR_Z`].
    pub near: f64,
    pub width: f64,
    pub floors: usize,
}

impl House {
    /// Height of the roof.
    pub fn top(&self) -> f64 {
        SHOP + FLOOR * self.floors as f64 + 0.5
    }

    /// A random value; `item` numbers what the house has several of.
    pub fn random(&self, item: u64, range: [f64; 2]) -> f64 {
        jitter(self.seed, self.key * 4096 + item, range)
    }

    /// Takes a mesh from the frame of the house to the street.
    pub fn place(&self, mesh: &Mesh) -> Mesh {
        let z = if self.side < 0.0 {
            self.near
        } else {
            self.near - self.width
        };
        let at = DVec3::new(self.side * FACE_X, 0.0, z);
        let turn = DMat4::from_rotation_y(-self.side * PI * 0.5);
        placed(mesh, DMat4::from_translation(at) * turn)
    }

    /// Lower left corners of the windows of one floor (0: above the shop).
    pub fn windows(&self, floor: usize) -> impl Iterator<Item = [f64; 2]> + use<> {
        let count = (self.width / 2.3).floor();
        let pitch = self.width / count;
        let y = SHOP + FLOOR * floor as f64 + 0.85;
        (0..count as usize).map(move |i| [pitch * (i as f64 + 0.5) - WINDOW[0] * 0.5, y])
    }

    /// Whether a floor has balconies before its windows.
    pub fn has_balconies(&self, floor: usize) -> bool {
        self.random(40 + floor as u64, [0.0, 1.0]) < 0.45
    }

    /// Which of three colours of wall it has.
    pub fn colour(&self) -> usize {
        (self.random(1, [0.0, 3.0]) as usize).min(2)
    }
}

/// Width and height of a window.
pub const WINDOW: [f64; 2] = [1.15, 1.5];

/// All houses, those of the left side first.
pub fn houses(parameters: &Parameters) -> Vec<House> {
    let mut all = Vec::new();
    for side in [-1.0, 1.0] {
        let mut near = NEAR_Z;
        while near > FAR_Z + 4.0 {
            let key = all.len() as u64 + 1;
            let random = |k: u64, range| jitter(parameters.seed, key * 4096 + k, range);
            let width = random(2, [6.5, 11.5]).min(near - FAR_Z);
            all.push(House {
                key,
                seed: parameters.seed,
                side,
                near,
                width,
                floors: random(3, [2.0, 5.0]) as usize,
            });
            near -= width;
        }
    }
    all
}
