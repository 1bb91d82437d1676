//! The lights of a map as arrays for the loops at every shading point.

use crate::environment::{LANES, TexelLights};

/// One number of eight neighbouring lights.
pub(super) type Lane = [f32; LANES];

/// Lights, eight at a time.
pub(super) struct LightArrays {
    pub chunks: Vec<Chunk>,
    /// The first chunk of the lights that are not emissive.
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
    pub half: Lane,
    pub inverse: Lane,
}

impl Soft {
    fn new(half: Lane) -> Self {
        let half = half.map(|e| e.clamp(1e-4, 1.0));
        Self {
            half,
            inverse: half.map(|e| 0.25 / e),
        }
    }

    /// The mean of max(0, cosine) when cosines spread evenly over ± e about `cos`.
    #[inline(always)]
    pub fn positive(&self, i: usize, cos: f32) -> f32 {
        let e = self.half[i];
        let within = (cos + e).clamp(0.0, 2.0 * e);
        within * within * self.inverse[i] + (cos - e).max(0.0)
    }
}

impl LightArrays {
    /// `scale` is the exposure.
    pub fn new(lights: &TexelLights, scale: f32) -> Self {
        let lane =
            |values: &[f32], c: usize| -> Lane { std::array::from_fn(|i| values[c * LANES + i]) };
        let chunks = (0..lights.len() / LANES)
            .map(|c| {
                let moment = lane(&lights.moment, c);
                // Variance of the direction, all axes.
                let variance = moment.map(|m| (1.0 - m * m).max(0.0));
                Chunk {
                    direction: [0, 1, 2].map(|a| lane(&lights.direction[a], c)),
                    power: [0, 1, 2].map(|a| lane(&lights.power[a], c).map(|p| p * scale)),
                    moment,
                    spread: Soft::new(variance.map(|v| (1.5 * v).sqrt())),
                    reach: Soft::new(lane(&lights.reach, c)),
                    widening: variance.map(|v| 0.25 * v),
                }
            })
            .collect();
        Self {
            chunks,
            indirect: lights.groups[1].start / LANES,
        }
    }
}
