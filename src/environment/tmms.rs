//! Tone-mapped mean shift (after Feng, Yang, Wan & Yu 2016): a reconstruction, since only what the
//! method does is established, not its tone curve, bandwidths and rules.

use super::blocks::Blocks;
use super::mean_shift::{Bandwidth, Segmentation};
use super::strata::Strata;
use super::texels::{Cluster, Texels};
use super::{Environment, EnvironmentSampler, LightSampler, LightSet};
use crate::entry::{About, Bias, parameters};
use crate::environment::SamplerEntry;
use glam::DVec3;
use rayon::prelude::*;

/// The registry's entry.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "tmms",
        module: crate::entry::head_comment!("tmms.rs"),
        aliases: &["tmms-r"],
        summary: "mean-shift strata of the tone-mapped map, split and merged to equal importance",
        source: "Feng et al. 2016 (reconstruction: curve, bandwidths and rules are ours)",
        bias: Bias::Consistent,
        version: 2,
        failures: &[
            "strata that hold a bright source and much else put their light beside the source",
            "a constant map has one mode, so that only splitting divides it",
        ],
        parameters: Parameters::PARAMETERS,
    },
    build: |table| {
        Ok(EnvironmentSampler::Lights(Box::new(Tmms(
            Parameters::read(table)?,
        ))))
    },
};

parameters! {
    #[derive(Clone, Copy, Debug)]
    struct Parameters {
        /// Bandwidth of the mean shift in direction.
        angle_rad: f64 = 0.15, AboveUpTo(0.0, 3.0), "rad";
        /// Bandwidth of the mean shift in tone-mapped luminance.
        tone: f64 = 0.1, AboveUpTo(0.0, 3.0);
    }
}

/// Most blocks that are shifted: the cost grows with their square.
const MOST_BLOCKS: usize = 192 * 96;

struct Tmms(Parameters);

impl LightSampler for Tmms {
    fn lights(&self, map: &Environment, count: usize, _seed: u64) -> LightSet {
        let texels = Texels::new(map);
        let blocks = Blocks::new(&texels, MOST_BLOCKS);
        if count == 0 || blocks.total().energy <= 0.0 {
            return LightSet::default();
        }
        let tones = tones(&blocks);
        let directions = block_directions(&texels, &blocks);
        let bandwidth = Bandwidth {
            angle_rad: self.0.angle_rad,
            tone: self.0.tone,
        };
        let labels = Segmentation::new(&blocks, &directions, &tones, bandwidth).labels();
        let modes = labels.iter().max().map_or(0, |&l| l + 1);
        let labels = Strata::new(&texels, &blocks, &labels).balanced(count);
        let lit: Vec<u32> = blocks
            .sums
            .iter()
            .zip(&labels)
            .filter(|(sums, _)| sums.energy > 0.0)
            .map(|(_, &label)| label)
            .collect();
        let cells = labels.iter().max().map_or(0, |&l| l as usize + 1);
        let mut set = blocks.light_set(&texels, cells, &lit);
        set.found.push(("modes", f64::from(modes)));
        set.turned(map.to_world())
    }
}

/// Reinhard's global curve about the geometric mean of the luminance.
fn tones(blocks: &Blocks) -> Vec<f64> {
    let pairs = || blocks.sums.iter().zip(&blocks.solid_angles_sr);
    let luminance = |(sums, angle): (&Cluster, &f64)| sums.energy / angle;
    let total: f64 = blocks.solid_angles_sr.iter().sum();
    let scale = blocks.total().energy / total;
    let mean_log = pairs()
        .map(|pair| (luminance(pair) / scale + 1e-6).ln() * pair.1)
        .sum::<f64>()
        / total;
    let middle = scale * mean_log.exp();
    let lit = blocks.sums.par_iter().zip(&blocks.solid_angles_sr);
    lit.map(|pair| luminance(pair) / (luminance(pair) + middle))
        .collect()
}

/// Centres of the blocks: the means of their texels' directions, the same along a row but for φ.
fn block_directions(texels: &Texels, blocks: &Blocks) -> Vec<DVec3> {
    let (side, columns, rows) = (blocks.side, blocks.width, blocks.height);
    (0..columns * rows)
        .into_par_iter()
        .map(|i| {
            let centre = |block: usize, length: usize| {
                let end = ((block + 1) * side).min(length);
                0.5 * (block * side + end) as f64 / length as f64
            };
            let phi = std::f64::consts::TAU * centre(i % columns, texels.width());
            let theta = std::f64::consts::PI * centre(i / columns, texels.height());
            DVec3::new(
                phi.sin() * theta.sin(),
                theta.cos(),
                -phi.cos() * theta.sin(),
            )
        })
        .collect()
}
