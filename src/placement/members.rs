//! Shading points packed for clustering: all that a split reads lies in 32 bytes, or in 20 if it is a
//! split in space.

use glam::Vec3;
use rayon::prelude::*;

use super::partition::Coordinates;
use crate::cache::ShadingPoints;
use crate::memory::room_for;

/// Lanes of the position.
pub(super) const POSITION: [usize; 3] = [0, 1, 2];
/// Lanes of the normal.
pub(super) const NORMAL: [usize; 3] = [4, 5, 6];
/// All lanes that are coordinates.
pub(super) const COORDINATES: [usize; 6] = [0, 1, 2, 4, 5, 6];
const DEPTH: usize = 3;
const INDEX: usize = 7;

/// Lanes 0–2: position; 3: depth; 4–6: normal times the normal scale; 7: index of the point, as
/// bits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member([f32; 8]);

impl Member {
    pub fn new(points: &ShadingPoints, index: u32, normal_scale: f32) -> Self {
        let (p, n) = (
            points.position[index as usize],
            points.normal[index as usize] * normal_scale,
        );
        let depth = points.depth[index as usize];
        let index = f32::from_bits(index);
        Self([p.x, p.y, p.z, depth, n.x, n.y, n.z, index])
    }

    /// A point whose position and depth are known already.
    #[inline]
    pub fn of(spot: &Spot, normal: Vec3) -> Self {
        let [x, y, z, depth] = spot.lanes;
        let index = f32::from_bits(spot.index);
        Self([x, y, z, depth, normal.x, normal.y, normal.z, index])
    }

    /// Its position and depth.
    pub fn spot(&self) -> Spot {
        let [x, y, z, depth, ..] = self.0;
        Spot {
            lanes: [x, y, z, depth],
            index: self.index(),
        }
    }

    pub fn lanes(&self) -> &[f32; 8] {
        &self.0
    }

    pub fn position(&self) -> Vec3 {
        Vec3::new(self.0[0], self.0[1], self.0[2])
    }

    pub fn normal(&self) -> Vec3 {
        Vec3::new(self.0[4], self.0[5], self.0[6])
    }

    #[inline]
    pub fn depth(&self) -> f32 {
        self.0[DEPTH]
    }

    #[inline]
    pub fn index(&self) -> u32 {
        self.0[INDEX].to_bits()
    }
}

impl Coordinates for Member {
    #[inline]
    fn coordinate(&self, axis: usize) -> f32 {
        self.0[axis]
    }

    #[inline]
    fn index(&self) -> u32 {
        self.0[INDEX].to_bits()
    }
}

/// A shading point without its normal: all that a split in space reads.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// Position, then depth.
    pub lanes: [f32; 4],
    pub index: u32,
}

impl Spot {
    pub fn new(points: &ShadingPoints, index: u32) -> Self {
        let [x, y, z] = points.position[index as usize].to_array();
        Self {
            lanes: [x, y, z, points.depth[index as usize]],
            index,
        }
    }
}

impl Coordinates for Spot {
    #[inline]
    fn coordinate(&self, axis: usize) -> f32 {
        self.lanes[axis]
    }

    #[inline]
    fn index(&self) -> u32 {
        self.index
    }
}

/// Indices of the points whose position, normal and depth are finite, in order.
pub(super) fn usable(points: &ShadingPoints) -> Vec<u32> {
    let all = 0..points.len() as u32;
    if finite(&points.position, |v| v.is_finite())
        && finite(&points.normal, |v| v.is_finite())
        && finite(&points.depth, |d| d.is_finite())
    {
        return all.into_par_iter().collect();
    }
    all.into_par_iter()
        .filter(|&i| is_usable(points, i as usize))
        .collect()
}

/// Whether the position, normal and depth of a point are finite.
pub(super) fn is_usable(points: &ShadingPoints, i: usize) -> bool {
    points.position[i].is_finite() && points.normal[i].is_finite() && points.depth[i].is_finite()
}

/// Whether all values are finite; looks at whole chunks, which is faster than one at a time.
fn finite<T: Sync>(values: &[T], is_finite: impl Fn(&T) -> bool + Sync) -> bool {
    let chunk = |values: &[T]| {
        values
            .iter()
            .fold(true, |all, value| all & is_finite(value))
    };
    values.par_chunks(1 << 12).all(chunk)
}

/// All shading points `usable` without their normals.
pub(super) fn spots(points: &ShadingPoints, usable: &[u32]) -> Vec<Spot> {
    let mut spots = room_for(usable.len());
    spots.par_extend(usable.par_iter().map(|&i| Spot::new(points, i)));
    spots
}

/// Appends the members at `spots`, with unscaled normals.
pub(super) fn complete(points: &ShadingPoints, spots: &[Spot], members: &mut Vec<Member>) {
    let member = |spot: &Spot| Member::of(spot, points.normal[spot.index as usize]);
    members.extend(spots.iter().map(member));
}

/// Packs the given points.
pub(super) fn pack(points: &ShadingPoints, usable: &[u32], normal_scale: f32) -> Vec<Member> {
    let mut members = room_for(usable.len());
    let member = |&i: &u32| Member::new(points, i, normal_scale);
    members.par_extend(usable.par_iter().map(member));
    members
}

/// The smallest box around coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds<const LANES: usize> {
    min: [f32; LANES],
    max: [f32; LANES],
}

impl<const LANES: usize> Bounds<LANES> {
    pub const EMPTY: Self = Self {
        min: [f32::INFINITY; LANES],
        max: [f32::NEG_INFINITY; LANES],
    };

    #[inline]
    pub fn add(&mut self, lanes: &[f32; LANES]) {
        for (lane, &value) in lanes.iter().enumerate() {
            let (min, max) = (&mut self.min[lane], &mut self.max[lane]);
            *min = if value < *min { value } else { *min };
            *max = if value > *max { value } else { *max };
        }
    }

    /// Grows to hold the other box.
    pub fn join(&mut self, other: &Self) {
        for lane in 0..LANES {
            self.min[lane] = self.min[lane].min(other.min[lane]);
            self.max[lane] = self.max[lane].max(other.max[lane]);
        }
    }

    pub fn extent(&self, axis: usize) -> f32 {
        self.max[axis] - self.min[axis]
    }

    /// The axis of widest extent among `axes`; the first of equal ones.
    pub fn widest(&self, axes: &[usize]) -> usize {
        axes.iter().fold(axes[0], |best, &axis| {
            if self.extent(axis) > self.extent(best) {
                axis
            } else {
                best
            }
        })
    }

    /// The middle of an axis, moved where rounding would put all members on one side of it.
    pub fn middle(&self, axis: usize) -> f32 {
        let (min, max) = (self.min[axis], self.max[axis]);
        let middle = 0.5 * min + 0.5 * max;
        if middle > min { middle } else { max }
    }
}

impl Bounds<8> {
    /// The box around members.
    pub fn around(members: &[Member]) -> Self {
        let mut bounds = Self::EMPTY;
        members.iter().for_each(|m| bounds.add(&m.0));
        bounds
    }
}
