//! Decomposition into emissive and other texels (Wu 2024): EnvDirects and EnvIndirects, the latter
//! shaded at half the resolution.

use super::directs::{Directs, Steps, directs};
use super::emissive::{Classification, Rule};
use super::indirects::{Weights, indirects};
use super::leaves::leaves;
use super::texels::Texels;
use super::{Environment, EnvironmentSampler, LightKind, LightSampler, LightSet};
use crate::entry::{About, Bias, ParameterError, parameters, words};
use crate::environment::SamplerEntry;

const FAILURES: &[&str] = &[
    "slender or numerous bright lights need more lights than a small budget has",
    "shadow edges of the lights remain visible, softened by interleaved sampling",
    "highlights of very glossy surfaces show single lights",
];

/// The registry's entry of the full method.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "decomposition",
        module: crate::entry::head_comment!("decomposition.rs"),
        aliases: &["ours"],
        summary: "lights on emissive texels, and others shaded at half the resolution",
        source: "Wu 2024, section 3",
        bias: Bias::Consistent,
        version: 3,
        failures: FAILURES,
        parameters: Parameters::PARAMETERS,
    },
    build: |table| build(table, 2),
};

/// The registry's entry without the reduced resolution, "Ours (w/o U)".
pub const FULL_RESOLUTION: SamplerEntry = SamplerEntry {
    about: About {
        id: "decomposition-full-resolution",
        module: crate::entry::head_comment!("decomposition.rs"),
        aliases: &["ours-without-upsampling"],
        summary: "the lights of the decomposition, all shaded at full resolution",
        source: "Wu 2024, section 4, Ours (w/o U)",
        bias: Bias::Consistent,
        version: 3,
        failures: FAILURES,
        parameters: Parameters::PARAMETERS,
    },
    build: |table| build(table, 1),
};

words! {
    /// Which lights are shaded.
    enum Part {
        Both = "both",
        Direct = "direct",
        Indirect = "indirect",
    }
}

parameters! {
    /// Parameters of both entries.
    #[derive(Clone, Debug)]
    struct Parameters {
        /// λ of eq. 1: factor on the average luminance.
        lambda: f64 = 3.0, AtLeast(0.0);
        /// γ of eq. 1: factor on the largest luminance.
        gamma: f64 = 0.001, AtLeast(0.0);
        /// Share of the map that L_b exceeds.
        quantile: f64 = 0.98, Within(0.0, 1.0);
        /// Quantile and average over texels instead of solid angle.
        count_texels: bool = false;
        /// Largest solid angle that counts in eq. 2; 0.01 in the metric's source, none without it.
        clamp_sr: Option<f64> = None, AtLeast(0.0), "sr";
        /// s: samples keep s·4π/K radians apart; 0 leaves the masking out.
        masking: f64 = 0.15, AtLeast(0.0);
        /// Whether samples are relaxed.
        k_means: bool = true;
        /// Emissive texels beyond this many masking angles become non-emissive; 0 keeps all.
        exclusion: f64 = 2.0, AtLeast(0.0);
        /// Leaves of the light tree, about.
        leaves: usize = 8192, Within(4.0, 4_194_304.0);
        /// w_V of eq. 3.
        variance_weight: f64 = 1.0, AtLeast(0.0);
        /// w_D of eq. 3; 0 with energy_weight = 0 is the original illumination cut.
        extent_weight: f64 = 5.0, AtLeast(0.0);
        /// w_E of eq. 3.
        energy_weight: f64 = 1.0, AtLeast(0.0);
        /// Lights that are shaded: both, direct or indirect ones; on surfaces the two add up to both.
        part: Part = Part::Both;
    }
}

fn build(table: &toml::Table, reduction: usize) -> Result<EnvironmentSampler, ParameterError> {
    Ok(EnvironmentSampler::Lights(Box::new(Decomposition {
        parameters: Parameters::read(table)?,
        reduction,
    })))
}

struct Decomposition {
    parameters: Parameters,
    reduction: usize,
}

impl Decomposition {
    fn classify(&self, texels: &Texels) -> Classification {
        let p = &self.parameters;
        let rule = Rule {
            average_factor: p.lambda,
            maximum_factor: p.gamma,
            quantile: p.quantile,
            count_texels: p.count_texels,
        };
        Classification::new(texels, &rule)
    }

    /// s · 4π / K radians, as printed.
    fn steps(&self, count: usize) -> Steps {
        let p = &self.parameters;
        let angle_rad = |s: f64| s * 4.0 * std::f64::consts::PI / count as f64;
        let apart_rad = if p.masking > 0.0 { p.masking } else { 0.15 };
        Steps {
            masking_rad: angle_rad(p.masking),
            k_means: p.k_means,
            exclusion_rad: match p.exclusion {
                0.0 => std::f64::consts::PI,
                factor => factor * angle_rad(apart_rad),
            },
        }
    }
}

/// How many lights.
#[derive(Clone, Copy)]
struct Count {
    /// K, which is split between both kinds.
    split: usize,
    /// Indirect lights for each that is left of K after the direct ones.
    indirect_factor: f64,
}

impl Decomposition {
    fn light_set(&self, map: &Environment, count: Count, seed: u64) -> LightSet {
        if count.split == 0 {
            return LightSet::default();
        }
        let p = &self.parameters;
        let texels = Texels::new(map);
        let classes = self.classify(&texels);
        let wanted = classes.split(count.split, p.clamp_sr);
        let Directs {
            mut lights,
            kept,
            rounds,
            ..
        } = directs(
            &texels,
            &classes.emissive,
            wanted,
            seed,
            &self.steps(count.split),
        );
        let found = lights.len();
        let mut masked = vec![false; texels.luminance.len()];
        let pairs = classes.emissive.iter().zip(&kept);
        let emissive: Vec<u32> = pairs
            .filter_map(|(texel, kept)| kept.then_some(*texel))
            .collect();
        for &texel in &emissive {
            masked[texel as usize] = true;
        }
        let rest = leaves(&texels, p.leaves, &masked, classes.origin);
        let weights = Weights {
            variance: p.variance_weight,
            extent: p.extent_weight,
            energy: p.energy_weight,
        };
        let left = (count.split - found) as f64 * count.indirect_factor;
        lights.extend(indirects(&texels, rest, left as usize, weights));
        let mut set = LightSet {
            found: vec![
                ("threshold", classes.threshold),
                ("direct_lights", found as f64),
                ("indirect_lights", (lights.len() - found) as f64),
                ("emissive_texels", classes.emissive.len() as f64),
                ("k_means_rounds", rounds as f64),
            ],
            lights,
            emissive,
            notes: Vec::new(),
        };
        if found < wanted {
            set.notes.push(format!(
                "{found} of {wanted} lights found room on emissive texels; the others went to EnvIndirects"
            ));
        }
        set.turned(map.to_world())
    }
}

/// *differs:* masking angles and exclusion are radians of the printed s·4π/K; only texels that exclusion would leave pull
/// a light while it is relaxed, because the mean of lamps farther apart lies between them, where exclusion leaves it
/// none, and a light that loses all its texels goes to the brightest that no other has; excluded texels leave
/// before powers and centroids are taken, and their light, as that of emissive texels for which no
/// sample was left, goes to EnvIndirects; masked texels do not count in a node's extent. What shading
/// at half the resolution saves of K full-resolution lights is spent on more EnvIndirects.
impl LightSampler for Decomposition {
    fn lights(&self, map: &Environment, count: usize, seed: u64) -> LightSet {
        let count = Count {
            split: count,
            indirect_factor: 1.0,
        };
        self.light_set(map, count, seed)
    }

    fn reduction(&self) -> usize {
        self.reduction
    }

    fn shades(&self, kind: LightKind) -> bool {
        match self.parameters.part {
            Part::Both => true,
            Part::Direct => kind == LightKind::Direct,
            Part::Indirect => kind == LightKind::Indirect,
        }
    }

    fn lights_within(
        &self,
        map: &Environment,
        rays: usize,
        indirect_cost: f64,
        seed: u64,
    ) -> LightSet {
        let count = Count {
            split: rays,
            indirect_factor: match self.reduction {
                1 => 1.0,
                _ => 1.0 / indirect_cost.clamp(1e-3, 1.0),
            },
        };
        self.light_set(map, count, seed)
    }
}
