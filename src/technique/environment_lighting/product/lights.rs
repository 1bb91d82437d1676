//! The lights of a map as arrays for the loops at every shading point, in three levels: eight
//! neighbouring lights are a chunk, and eight chunks are the lanes of a chunk of the next level, as if
//! each were a light.

use glam::Vec3;

use crate::environment::{BLOCK, TexelLights};
use crate::image::luminance;

/// Lights that the loops work on at once.
pub(super) const LANES: usize = 8;
/// One number of eight neighbouring lights.
pub(super) type Lane = [f32; LANES];

/// Levels of chunks.
pub(super) const LEVELS: usize = 3;

/// Lights, eight at a time.
pub(super) struct LightArrays {
    /// Chunks by level, those of the lights first: lane i of chunk n stands for chunk 8 n + i of the
    /// level below.
    pub levels: [Vec<Chunk>; LEVELS],
    /// The first chunk of the uppermost level whose lights are not emissive.
    pub indirect: usize,
}

/// Eight lights.
#[derive(Clone, Copy)]
pub(super) struct Chunk {
    pub direction: [Lane; 3],
    /// Exposed power, by channel.
    pub power: [Lane; 3],
    /// Mean cosine of the texels towards the light's direction.
    pub moment: Lane,
    /// Half the width over which the cosine of the texels spreads, by their variance.
    pub spread: Soft,
    /// The same by the farthest texel: no texel is above a surface when this is not.
    pub reach: Soft,
    /// Added to the squared roughness of facets, for the spread of the half vector.
    pub widening: Lane,
}

/// Half-widths e, and 1 / (4 e).
#[derive(Clone, Copy)]
pub(super) struct Soft {
    half: Lane,
    inverse: Lane,
}

/// The larger number; maps to one instruction.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller number; maps to one instruction.
#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

impl Soft {
    fn new(half: Lane) -> Self {
        let half = half.map(|e| e.clamp(1e-4, 1.0));
        Self {
            half,
            inverse: half.map(|e| 0.25 / e),
        }
    }

    /// The means of max(0, cosine) when cosines spread evenly over ± e about `cos`.
    #[inline(always)]
    pub fn positive(&self, cos: &Lane) -> Lane {
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            let e = self.half[i];
            let within = smaller(larger(cos[i] + e, 0.0), e + e);
            out[i] = within * within * self.inverse[i] + larger(cos[i] - e, 0.0);
        }
        out
    }

    /// The same for one lane.
    fn positive_at(&self, lane: usize, cos: f32) -> f32 {
        let e = self.half[lane];
        let within = smaller(larger(cos + e, 0.0), e + e);
        within * within * self.inverse[lane] + larger(cos - e, 0.0)
    }
}

/// A light of either level.
#[derive(Clone, Copy, Default)]
struct One {
    direction: Vec3,
    power: Vec3,
    moment: f32,
    reach_rad: f32,
}

impl One {
    /// The light that stands for several.
    fn of(lights: &[Self]) -> Self {
        let (mut power, mut moment, mut energy) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for light in lights {
            let y = luminance(light.power.into());
            power += light.power;
            moment += light.direction * (y * light.moment);
            energy += y;
        }
        if energy <= 0.0 {
            return Self {
                direction: Vec3::Y,
                ..Self::default()
            };
        }
        let direction = moment.normalize_or(Vec3::Y);
        let reach = |l: &Self| direction.angle_between(l.direction) + l.reach_rad;
        Self {
            direction,
            power,
            moment: (moment.length() / energy).min(1.0),
            reach_rad: lights
                .iter()
                .filter(|l| l.power != Vec3::ZERO)
                .map(reach)
                .fold(0.0, f32::max)
                .min(std::f32::consts::FRAC_PI_2),
        }
    }
}

impl Chunk {
    /// Mean positive cosine of one light's texels with a normal.
    pub fn cosine(&self, lane: usize, normal: Vec3) -> f32 {
        let direction = Vec3::from([0, 1, 2].map(|a| self.direction[a][lane]));
        self.spread.positive_at(lane, normal.dot(direction)) * self.moment[lane]
    }

    fn new(lights: &[One]) -> Self {
        let lane = |number: &dyn Fn(&One) -> f32| std::array::from_fn(|i| number(&lights[i]));
        // Variance of the direction, all axes.
        let variance = |l: &One| (1.0 - l.moment * l.moment).max(0.0);
        Self {
            direction: [0, 1, 2].map(|a| lane(&|l| l.direction[a])),
            power: [0, 1, 2].map(|c| lane(&|l| l.power[c])),
            moment: lane(&|l| l.moment),
            spread: Soft::new(lane(&|l| (1.5 * variance(l)).sqrt())),
            reach: Soft::new(lane(&|l| l.reach_rad.sin())),
            widening: lane(&|l| 0.25 * variance(l)),
        }
    }
}

impl LightArrays {
    /// `scale` is the exposure.
    pub fn new(lights: &TexelLights, scale: f32) -> Self {
        let ones: Vec<One> = (0..lights.len())
            .map(|i| One {
                direction: Vec3::from([0, 1, 2].map(|a| lights.direction[a][i])),
                power: Vec3::from([0, 1, 2].map(|c| lights.power[c][i])) * scale,
                moment: lights.moment[i],
                reach_rad: lights.reach_rad[i],
            })
            .collect();
        let middle: Vec<One> = ones.chunks_exact(LANES).map(One::of).collect();
        let upper: Vec<One> = middle.chunks_exact(LANES).map(One::of).collect();
        let chunks = |ones: &[One]| ones.chunks_exact(LANES).map(Chunk::new).collect();
        Self {
            levels: [chunks(&ones), chunks(&middle), chunks(&upper)],
            indirect: lights.groups[1].start / BLOCK,
        }
    }

    /// 0 for a chunk of emissive lights, 1 for one of the others.
    pub fn group(&self, level: usize, chunk: usize) -> usize {
        usize::from(chunk >= self.indirect * LANES.pow((LEVELS - 1 - level) as u32))
    }
}
