//! Shading points packed for clustering: all that a split reads lies in 32 bytes.

use glam::Vec3;
use rayon::prelude::*;

use crate::cache::ShadingPoints;

/// Lanes of the position.
pub(super) const POSITION: [usize; 3] = [0, 1, 2];
/// Lanes of the normal.
pub(super) const NORMAL: [usize; 3] = [4, 5, 6];
/// All lanes that are coordinates.
pub(super) const COORDINATES: [usize; 6] = [0, 1, 2, 4, 5, 6];
/// Clusters of this many members fit a core's cache.
const CACHED: usize = 1 << 14;
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

    #[inline]
    pub fn coordinate(&self, axis: usize) -> f32 {
        self.0[axis]
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

    pub fn index(&self) -> u32 {
        self.0[INDEX].to_bits()
    }
}

/// Indices of the points whose position, normal and depth are finite, in order.
pub(super) fn usable(points: &ShadingPoints) -> Vec<u32> {
    (0..points.len() as u32)
        .into_par_iter()
        .filter(|&i| {
            let i = i as usize;
            points.position[i].is_finite()
                && points.normal[i].is_finite()
                && points.depth[i].is_finite()
        })
        .collect()
}

/// Packs the given points.
pub(super) fn pack(points: &ShadingPoints, usable: &[u32], normal_scale: f32) -> Vec<Member> {
    usable
        .par_iter()
        .map(|&i| Member::new(points, i, normal_scale))
        .collect()
}

/// The smallest box around members, over all coordinate lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    min: [f32; 8],
    max: [f32; 8],
}

impl Bounds {
    pub const EMPTY: Self = Self {
        min: [f32::INFINITY; 8],
        max: [f32::NEG_INFINITY; 8],
    };

    #[inline]
    pub fn add(&mut self, member: &Member) {
        for lane in 0..8 {
            let value = member.0[lane];
            self.min[lane] = if value < self.min[lane] {
                value
            } else {
                self.min[lane]
            };
            self.max[lane] = if value > self.max[lane] {
                value
            } else {
                self.max[lane]
            };
        }
    }

    /// The box around positions only, and the mean depth.
    pub fn of_positions(members: &[Member]) -> (Self, f32) {
        let mut bounds = Self::EMPTY;
        let mut depth = 0.0f64;
        for member in members {
            for lane in 0..4 {
                let value = member.0[lane];
                let (min, max) = (&mut bounds.min[lane], &mut bounds.max[lane]);
                *min = if value < *min { value } else { *min };
                *max = if value > *max { value } else { *max };
            }
            depth += f64::from(member.depth());
        }
        (bounds, (depth / members.len() as f64) as f32)
    }

    pub fn around(members: &[Member]) -> Self {
        let mut bounds = Self::EMPTY;
        members.iter().for_each(|m| bounds.add(m));
        bounds
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

/// Moves members below `plane` to the front and returns how many there are.
pub(super) fn partition(members: &mut [Member], axis: usize, plane: f32) -> usize {
    let (mut low, mut high) = (0, members.len());
    if members.len() > CACHED {
        // Large clusters are bound by memory: touch only what is on the wrong side.
        loop {
            while low < high && members[low].coordinate(axis) < plane {
                low += 1;
            }
            while low < high && members[high - 1].coordinate(axis) >= plane {
                high -= 1;
            }
            if low >= high {
                return low;
            }
            members.swap(low, high - 1);
        }
    }
    for i in 0..members.len() {
        // Swapping members that both belong above does no harm and saves a branch.
        let below = members[i].coordinate(axis) < plane;
        members.swap(low, i);
        low += usize::from(below);
    }
    low
}

/// Moves the lower half along an axis to the front and returns its size.
pub(super) fn halve(members: &mut [Member], axis: usize) -> usize {
    let middle = members.len() / 2;
    members.select_nth_unstable_by(middle, |a, b| {
        let order = a.coordinate(axis).total_cmp(&b.coordinate(axis));
        order.then(a.index().cmp(&b.index()))
    });
    middle
}
