//! Texels as images are made of them: cones as they lie in the world, kept while neighbouring pixels read them.

use crate::cache::cones::{Cone, MOST_CONES};
use crate::cache::surface::Texel;
use crate::sample::{Frame, hash};

/// A cone as it lies in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShownCone {
    /// About its axis; directions of the cone are told in it.
    pub frame: Frame,
    /// Of its half angle.
    pub sine: f32,
    /// See `sine`.
    pub cosine: f32,
    /// 1 − cos α, without cancellation in narrow cones.
    pub height: f32,
    /// See [`Cone::light`].
    pub light: glam::Vec3,
}

/// The cones of a texel; there are none of one that was never updated.
#[derive(Clone, Copy)]
pub(super) struct Shown {
    /// Whether it was ever updated.
    pub known: bool,
    /// Cones that it has.
    pub used: usize,
    pub cones: [ShownCone; MOST_CONES],
}

/// Texels that were shown of late, each in a place that follows from where it lies, so that neighbours have others.
pub(super) struct ShownTexels {
    places: Vec<(Option<Texel>, Shown)>,
}

/// Texels along a side of the square that has places of its own.
const SIDE: u32 = 16;

impl Default for ShownTexels {
    fn default() -> Self {
        Self {
            places: vec![(None, Shown::EMPTY); (SIDE * SIDE) as usize],
        }
    }
}

impl ShownTexels {
    /// The cones of a texel, made unless they are at hand; `None` where it was never updated.
    pub fn get(&mut self, texel: Texel, make: impl FnOnce(&mut Shown)) -> Option<&[ShownCone]> {
        let [column, row] = texel.position().map(|i| i % SIDE);
        let other = hash(texel.block.sheet()) as u32 % (SIDE * SIDE);
        let (key, shown) = &mut self.places[((row * SIDE + column) ^ other) as usize];
        if *key != Some(texel) {
            *key = Some(texel);
            make(shown);
        }
        shown.known.then(|| &shown.cones[..shown.used])
    }
}

impl Shown {
    const EMPTY: Self = Self {
        known: false,
        used: 0,
        cones: [ShownCone {
            frame: Frame {
                tangent: glam::Vec3::X,
                bitangent: glam::Vec3::Y,
                normal: glam::Vec3::Z,
            },
            sine: 0.0,
            cosine: 1.0,
            height: 0.0,
            light: glam::Vec3::ZERO,
        }; MOST_CONES],
    };
}

impl ShownCone {
    /// A cone in the world whose frame is turned around the axis by an angle of this sine and cosine.
    pub fn of(cone: &Cone, [turn_sine, turn_cosine]: [f32; 2]) -> Self {
        let frame = Frame::from_normal(cone.axis);
        let height = cone.height();
        Self {
            frame: Frame {
                tangent: frame.tangent * turn_cosine + frame.bitangent * turn_sine,
                bitangent: frame.bitangent * turn_cosine - frame.tangent * turn_sine,
                normal: frame.normal,
            },
            sine: (height * (2.0 - height)).max(0.0).sqrt(),
            cosine: 1.0 - height,
            height,
            light: cone.light,
        }
    }
}
