//! Decomposition into emissive and other texels (Wu 2024): EnvDirects and EnvIndirects, the latter
//! shaded at half the resolution.

use serde::{Deserialize, Serialize};

use super::directs::{Directs, Steps, directs};
use super::emissive::{Classification, Rule};
use super::indirects::{Weights, indirects};
use super::leaves::leaves;
use super::texels::Texels;
use super::{Environment, EnvironmentSampler, LightKind, LightSampler, LightSet};
use crate::entry::{About, Bias, Parameter, ParameterError};
use crate::environment::SamplerEntry;

const fn parameter(
    [key, default]: [&'static str; 2],
    [unit, meaning]: [&'static str; 2],
) -> Parameter {
    Parameter {
        key,
        default,
        unit,
        meaning,
    }
}

const PARAMETERS: &[Parameter] = &[
    parameter(
        ["lambda", "3"],
        ["", "λ of eq. 1: factor on the average luminance"],
    ),
    parameter(
        ["gamma", "0.001"],
        ["", "γ of eq. 1: factor on the largest luminance"],
    ),
    parameter(
        ["quantile", "0.98"],
        ["", "share of the map that L_b exceeds"],
    ),
    parameter(
        ["count_texels", "false"],
        [
            "",
            "quantile and average over texels instead of solid angle",
        ],
    ),
    parameter(
        ["clamp_sr", "none"],
        [
            "sr",
            "largest solid angle that counts in eq. 2; 0.01 in the metric's source",
        ],
    ),
    parameter(
        ["masking", "0.15"],
        [
            "",
            "s: samples keep s·4π/K radians apart; 0 leaves the masking out",
        ],
    ),
    parameter(["k_means", "true"], ["", "whether samples are relaxed"]),
    parameter(
        ["exclusion", "2"],
        [
            "",
            "emissive texels beyond this many masking angles become non-emissive; 0 keeps all",
        ],
    ),
    parameter(["leaves", "8192"], ["", "leaves of the light tree, about"]),
    parameter(["variance_weight", "1"], ["", "w_V of eq. 3"]),
    parameter(
        ["extent_weight", "5"],
        [
            "",
            "w_D of eq. 3; 0 with energy_weight = 0 is the original illumination cut",
        ],
    ),
    parameter(["energy_weight", "1"], ["", "w_E of eq. 3"]),
    parameter(
        ["part", "both"],
        [
            "",
            "lights that are shaded: both, direct or indirect ones; on surfaces the two add up to both",
        ],
    ),
];

const FAILURES: &[&str] = &[
    "slender or numerous bright lights need more lights than a small budget has",
    "shadow edges of the lights remain visible, softened by interleaved sampling",
    "highlights of very glossy surfaces show single lights",
];

/// The registry's entry of the full method.
pub const ENTRY: SamplerEntry = SamplerEntry {
    about: About {
        id: "decomposition",
        module: include_str!("decomposition.rs"),
        aliases: &["ours"],
        summary: "lights on emissive texels, and others shaded at half the resolution",
        source: "Wu 2024, section 3",
        bias: Bias::Consistent,
        version: 1,
        failures: FAILURES,
        parameters: PARAMETERS,
    },
    build: |table| build(table, 2),
};

/// The registry's entry without the reduced resolution, "Ours (w/o U)".
pub const FULL_RESOLUTION: SamplerEntry = SamplerEntry {
    about: About {
        id: "decomposition-full-resolution",
        module: include_str!("decomposition.rs"),
        aliases: &["ours-without-upsampling"],
        summary: "the lights of the decomposition, all shaded at full resolution",
        source: "Wu 2024, section 4, Ours (w/o U)",
        bias: Bias::Consistent,
        version: 1,
        failures: FAILURES,
        parameters: PARAMETERS,
    },
    build: |table| build(table, 1),
};

/// Parameters of both entries.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
struct Parameters {
    lambda: f64,
    gamma: f64,
    quantile: f64,
    count_texels: bool,
    clamp_sr: Option<f64>,
    masking: f64,
    k_means: bool,
    exclusion: f64,
    leaves: usize,
    variance_weight: f64,
    extent_weight: f64,
    energy_weight: f64,
    part: Part,
}

/// Which lights are shaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Part {
    #[default]
    Both,
    Direct,
    Indirect,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            lambda: 3.0,
            gamma: 0.001,
            quantile: 0.98,
            count_texels: false,
            clamp_sr: None,
            masking: 0.15,
            k_means: true,
            exclusion: 2.0,
            leaves: 8192,
            variance_weight: 1.0,
            extent_weight: 5.0,
            energy_weight: 1.0,
            part: Part::Both,
        }
    }
}

impl Parameters {
    fn validate(&self) -> Result<(), ParameterError> {
        let error = |key: &str, expected: &str| {
            Err(ParameterError {
                key: Some(key.into()),
                message: format!("{key}: expected {expected}"),
            })
        };
        let weights = [
            ("lambda", self.lambda),
            ("gamma", self.gamma),
            ("clamp_sr", self.clamp_sr.unwrap_or(1.0)),
            ("masking", self.masking),
            ("exclusion", self.exclusion),
            ("variance_weight", self.variance_weight),
            ("extent_weight", self.extent_weight),
            ("energy_weight", self.energy_weight),
        ];
        if let Some((key, _)) = weights.iter().find(|(_, w)| !w.is_finite() || *w < 0.0) {
            return error(key, "a number that is not negative");
        }
        if !(0.0..=1.0).contains(&self.quantile) {
            return error("quantile", "a share from 0 to 1");
        }
        if !(4..=1 << 22).contains(&self.leaves) {
            return error("leaves", "4 to 4194304");
        }
        Ok(())
    }
}

fn build(table: &toml::Table, reduction: usize) -> Result<EnvironmentSampler, ParameterError> {
    let parameters: Parameters = crate::entry::parameters(table)?;
    parameters.validate()?;
    Ok(EnvironmentSampler::Lights(Box::new(Decomposition {
        parameters,
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
            (wanted, seed),
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
        let rest = leaves(&texels, p.leaves, (&masked, classes.origin));
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

/// *differs:* masking angles and exclusion are radians of the printed s·4π/K; excluded texels leave
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
        (rays, indirect_cost): (usize, f64),
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
