//! A map as up to thousands of lights that keep their texels: strata for sampling it.
//!
//! The texels are those of the decomposition, emissive ones first and none excluded; in each group
//! neighbouring lights follow each other (k-d order of their directions), so that equal steps along
//! the list are strata on the sphere.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::directs::{Steps, directs};
use super::emissive::{Classification, Rule};
use super::halving::halve;
use super::indirects::{Weights, cut};
use super::leaves::{Leaf, cells_of_texels, leaves};
use super::texel_lists::TexelLists;
use super::texels::{Cluster, Texels, angle_rad};
use super::{Environment, Light, LightKind, LightSet};

/// Lights are padded with black ones to a multiple of this in both groups.
pub const BLOCK: usize = 512;
/// Directions that are drawn from every light in advance, a power of two.
pub const DRAWS: usize = 16;

/// Lights in arrays, world space; emissive ones (group 0) before the others (group 1).
#[derive(Clone, Debug, Default)]
pub struct TexelLights {
    /// Unit vectors towards the lights, by axis.
    pub direction: [Vec<f32>; 3],
    /// |Σ energy · direction| / Σ energy, in [0, 1]: the mean cosine towards the light's direction.
    pub moment: Vec<f32>,
    /// Half-angle of a cone that holds all texels, in [0, π/2].
    pub reach_rad: Vec<f32>,
    /// Σ radiance · solid angle, by channel.
    pub power: [Vec<f32>; 3],
    /// The lights of each group, padding included.
    pub groups: [Range<usize>; 2],
    /// [`DRAWS`] unit directions of every light, in the order of equal parts of its energy.
    pub draws: Vec<Vec3>,
    /// What was found on the way.
    pub set: LightSet,
    /// The texels of every light, where they are kept.
    texels: Option<TexelLists>,
}

/// A direction drawn from a light.
#[derive(Clone, Copy, Debug)]
pub struct TexelSample {
    /// Unit, world space.
    pub direction: Vec3,
    /// Density per steradian among the directions of the light.
    pub pdf_sr: f32,
}

/// What the lights are made from; the decomposition's defaults.
const RULE: Rule = Rule {
    average_factor: 3.0,
    maximum_factor: 0.001,
    quantile: 0.98,
    count_texels: false,
};
const WEIGHTS: Weights = Weights {
    variance: 1.0,
    extent: 5.0,
    energy: 1.0,
};
const LEAVES: usize = 8192;
/// Rounds of the cut, about.
const ROUNDS: usize = 64;
const MASKING: f64 = 0.15;
/// No light: black texels.
pub(super) const NONE: u32 = u32::MAX;

impl TexelLights {
    /// At most `count` lights, with directions drawn from them; none for a black map.
    pub fn new(map: &Environment, count: usize, seed: u64) -> Self {
        let texels = Texels::new(map);
        let groups = Groups::new(&texels, count, seed);
        Self::of_groups(map, &texels, &groups).0
    }

    /// As [`TexelLights::new`], for [`TexelLights::sample`]. Texels count with the mean of the bilinear
    /// lookup over them, so that every direction from which light comes belongs to a light.
    pub fn with_texels(map: &Environment, count: usize, seed: u64) -> Self {
        let texels = Texels::of_lookup(map);
        let groups = Groups::new(&texels, count, seed);
        let (mut lights, position) = Self::of_groups(map, &texels, &groups);
        let labels = groups.labels(&texels);
        let number = |label: u32| match label {
            NONE => NONE,
            label => position[label as usize],
        };
        let of_texel = labels.into_iter().map(number).collect();
        lights.texels = Some(TexelLists::new(&texels, of_texel, lights.len()));
        lights
    }

    /// The lights, and the position of every part in them.
    fn of_groups(map: &Environment, texels: &Texels, groups: &Groups) -> (Self, Vec<u32>) {
        let parts = groups.parts(texels);
        let mut lights = Self::default();
        let mut position = vec![NONE; parts.len()];
        let kinds = [LightKind::Direct, LightKind::Indirect];
        let direct = groups.direct;
        for (group, range) in [0..direct, direct..parts.len()].into_iter().enumerate() {
            let mut order: Vec<u32> = range
                .filter(|&i| parts[i].sums.energy > 0.0)
                .map(|i| i as u32)
                .collect();
            k_d_order(&mut order, &parts);
            lights.groups[group].start = lights.len();
            for &index in &order {
                position[index as usize] = lights.len() as u32;
                lights.push(map, &parts[index as usize], kinds[group]);
            }
            while !lights.len().is_multiple_of(BLOCK) {
                lights.pad();
            }
            lights.groups[group].end = lights.len();
            let name = ["direct_lights", "indirect_lights"][group];
            lights.set.found.push((name, order.len() as f64));
        }
        (lights, position)
    }

    /// Number of lights, padding included; a multiple of [`BLOCK`].
    pub fn len(&self) -> usize {
        self.moment.len()
    }

    /// Whether the map is black.
    pub fn is_empty(&self) -> bool {
        self.moment.is_empty()
    }

    fn push(&mut self, map: &Environment, part: &Part, kind: LightKind) {
        let turn = |d: DVec3| (map.to_world() * d.as_vec3()).normalize();
        let axis = turn(part.axis);
        for c in 0..3 {
            self.direction[c].push(axis[c]);
            self.power[c].push(part.sums.power[c] as f32);
        }
        let moment = part.sums.moment.length() / part.sums.energy;
        self.moment.push(moment.min(1.0) as f32);
        let reach = part.reach_rad.min(std::f64::consts::FRAC_PI_2) as f32;
        self.reach_rad.push(reach);
        self.draws.extend(part.draws.iter().map(|&d| turn(d)));
        self.set.lights.push(Light {
            direction: axis,
            power: part.sums.power.to_array(),
            kind,
            extent_rad: reach,
        });
    }

    fn pad(&mut self) {
        for c in 0..3 {
            self.direction[c].push(f32::from(u8::from(c == 1)));
            self.power[c].push(0.0);
        }
        self.moment.push(0.0);
        self.reach_rad.push(0.0);
        self.draws.extend([Vec3::Y; DRAWS]);
    }

    /// A direction of a light and its density: a texel by `u`, a point in it by `v`, all in [0, 1).
    /// `None` without lists of texels.
    pub fn sample(
        &self,
        map: &Environment,
        light: usize,
        u: f32,
        v: [f32; 2],
    ) -> Option<TexelSample> {
        let (texel, share) = self.texels.as_ref()?.texel(light, u)?;
        let (x, y) = (texel as usize % map.width(), texel as usize / map.width());
        Some(TexelSample {
            direction: map.within_texel(x, y, v.map(f64::from)),
            pdf_sr: share / map.texel_solid_angle(y) as f32,
        })
    }
}

/// A map in parts: emissive texels by their cells, and runs of leaves for the others.
struct Groups {
    emissive: Vec<u32>,
    /// The part of each emissive texel.
    cells: Vec<u32>,
    /// Number of parts of emissive texels, which come first.
    direct: usize,
    leaves: Vec<Leaf>,
    runs: Vec<Range<usize>>,
    /// Column that leaves are counted from.
    origin: usize,
}

/// What a light stands for, in the map's space.
struct Part {
    sums: Cluster,
    axis: DVec3,
    reach_rad: f64,
    draws: Vec<DVec3>,
}

impl Groups {
    fn new(texels: &Texels, count: usize, seed: u64) -> Self {
        let classes = Classification::new(texels, &RULE);
        let wanted = classes.split(count, None);
        let steps = Steps {
            masking_rad: MASKING * 4.0 * PI / count.max(1) as f64,
            k_means: false,
            exclusion_rad: PI,
        };
        let found = directs(texels, &classes.emissive, wanted, seed, &steps);
        let direct = found.labels.iter().max().map_or(0, |&l| l as usize + 1);
        let mut masked = vec![false; texels.luminance.len()];
        if direct > 0 {
            for &texel in &classes.emissive {
                masked[texel as usize] = true;
            }
        }
        let mut rest = leaves(texels, LEAVES, &masked, classes.origin);
        let at_once = count.div_ceil(ROUNDS);
        let runs = cut(&mut rest, count.saturating_sub(direct), WEIGHTS, at_once);
        Self {
            emissive: classes.emissive,
            cells: found.labels,
            direct,
            leaves: rest,
            runs,
            origin: classes.origin,
        }
    }

    fn parts(&self, texels: &Texels) -> Vec<Part> {
        let size = [TAU / texels.width() as f64, PI / texels.height() as f64];
        let mut members: Vec<Vec<Member>> = (0..self.direct).map(|_| Vec::new()).collect();
        for (&texel, &cell) in self.emissive.iter().zip(&self.cells) {
            let mut sums = Cluster::default();
            sums.add(texels, texel as usize);
            members[cell as usize].push(Member {
                sums,
                direction: texels.direction(texel as usize),
                size,
                tent: [size[0] < WIDEST, size[1] < WIDEST],
            });
        }
        let side = (4.0 * PI / LEAVES as f64).sqrt();
        members.extend(self.runs.iter().map(|run| {
            let leaves = self.leaves[run.clone()].iter();
            leaves
                .map(|leaf| {
                    let y = leaf.direction.y;
                    let around = side / (1.0 - y * y).max(1e-4).sqrt();
                    let tent = [
                        size[0] > around && size[0] < WIDEST,
                        size[1] > side && size[1] < WIDEST,
                    ];
                    Member {
                        sums: leaf.sums,
                        direction: leaf.direction,
                        size: [size[0].max(around.min(TAU)), size[1].max(side)],
                        tent,
                    }
                })
                .collect()
        }));
        members
            .into_par_iter()
            .map(|m| Part::new(texels, &m))
            .collect()
    }

    /// The part of every texel; [`NONE`] for black ones.
    fn labels(&self, texels: &Texels) -> Vec<u32> {
        let (mut labels, cells) = cells_of_texels(texels, LEAVES, self.origin);
        let mut of_cell = vec![NONE; cells];
        for (index, run) in self.runs.iter().enumerate() {
            for leaf in &self.leaves[run.clone()] {
                of_cell[leaf.cell as usize] = (self.direct + index) as u32;
            }
        }
        for (label, &luminance) in labels.iter_mut().zip(&texels.luminance) {
            *label = match luminance > 0.0 {
                true => of_cell[*label as usize],
                false => NONE,
            };
        }
        if self.direct > 0 {
            for (&texel, &cell) in self.emissive.iter().zip(&self.cells) {
                labels[texel as usize] = cell;
            }
        }
        labels
    }
}

/// Texels of a larger extent (radians) are drawn from evenly: twice it would reach round the sphere.
const WIDEST: f64 = 1.0;

/// A texel or a leaf of a part.
struct Member {
    sums: Cluster,
    direction: DVec3,
    /// Extent along φ and θ, radians.
    size: [f64; 2],
    /// Whether light falls off linearly over twice the extent, as under bilinear lookup.
    tent: [bool; 2],
}

impl Member {
    /// A direction by `v` in [0, 1)².
    fn direction_at(&self, v: [f64; 2]) -> DVec3 {
        let offset = |axis: usize| {
            let centred = v[axis] - 0.5;
            let step = match self.tent[axis] {
                true => (1.0 - (1.0 - 2.0 * centred.abs()).sqrt()).copysign(centred),
                false => centred,
            };
            step * self.size[axis]
        };
        let d = self.direction;
        let theta = d.x.hypot(d.z).atan2(d.y);
        let (sin_phi, cos_phi) = (d.x.atan2(-d.z) + offset(0)).sin_cos();
        let cos = if self.tent[1] {
            (theta + offset(1)).clamp(0.0, PI).cos()
        } else {
            let edge = |side: f64| (theta + side * self.size[1]).clamp(0.0, PI).cos();
            edge(-0.5) + v[1] * (edge(0.5) - edge(-0.5))
        };
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        DVec3::new(sin_phi * sin, cos, -cos_phi * sin)
    }
}

impl Part {
    fn new(texels: &Texels, members: &[Member]) -> Self {
        let mut sums = Cluster::default();
        members.iter().for_each(|m| sums.merge(&m.sums));
        let axis = sums.direction(texels).unwrap_or(DVec3::Y);
        let mut reach_rad = 0.0f64;
        for member in members.iter().filter(|m| m.sums.energy > 0.0) {
            let sin = (1.0 - member.direction.y.powi(2)).max(0.0).sqrt();
            let around = (member.size[0] * sin).max(member.size[1]);
            reach_rad = reach_rad.max(angle_rad(axis, member.direction) + 0.75 * around);
        }
        let mut draws = vec![axis; DRAWS];
        if sums.energy > 0.0 {
            let (mut index, mut sum) = (0, members[0].sums.energy);
            for (d, draw) in draws.iter_mut().enumerate() {
                let target = (d as f64 + 0.5) / DRAWS as f64 * sums.energy;
                while sum <= target && index + 1 < members.len() {
                    index += 1;
                    sum += members[index].sums.energy;
                }
                // A lattice whose first coordinate does not follow the order of the members.
                let v = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2]
                    .map(|step| (0.5 + d as f64 * step).fract());
                *draw = members[index].direction_at(v);
            }
        }
        Self {
            sums,
            axis,
            reach_rad,
            draws,
        }
    }
}

/// Orders parts so that neighbours in the list are neighbours on the sphere.
fn k_d_order(items: &mut [u32], parts: &[Part]) {
    if items.len() < 2 {
        return;
    }
    let middle = halve(items, |item| parts[item as usize].axis);
    let (lower, upper) = items.split_at_mut(middle);
    k_d_order(lower, parts);
    k_d_order(upper, parts);
}

#[cfg(test)]
#[path = "texel_lights_tests.rs"]
mod tests;
