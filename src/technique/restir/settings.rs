//! Parameters of ReSTIR, and the settings of its papers that they default to.

use super::receiver::Tolerances;
use super::reservoir::Reservoir;
use crate::entry::{Bias, ParameterError, parameters, words};

words! {
    /// How the samples of several reservoirs weigh in one.
    pub enum Weights {
        /// 1/M, M being all samples: biased where one of the surfaces could not have drawn the sample.
        Count = "count",
        /// 1/Z, Z being the samples of surfaces that could have drawn the sample.
        Support = "support",
        /// As the balance heuristic, by the target at the surface that drew the sample among all of them.
        Balance = "balance",
    }
}

parameters! {
    /// What is not given is as the method's paper has it.
    #[derive(Clone, Copy, Debug)]
    pub struct Parameters {
        /// M: candidates of a reservoir, drawn by power; without it 32, rtxdi 10.
        candidates: Option<u32> = None, Within(1.0, 65536.0);
        /// Candidates besides, drawn by the surface, a ray each; without it none.
        surface_candidates: Option<u32> = None, Within(0.0, 64.0);
        /// Whether candidates are those of a set that is drawn once a pass, with many others, and serves many pixels; without it
        /// only rtxdi's are.
        presampled: Option<bool> = None;
        /// Passes of a frame over all pixels, each with a camera sample of its own, from reservoirs to reservoirs; without it as
        /// many as the budget says in direct lighting. Environment lighting has one for each of its camera samples.
        passes: Option<u32> = None, Within(1.0, 4096.0);
        /// N: reservoirs of a pixel, each with a sample that is shaded; without it 4, restir-unbiased and rtxdi 1.
        reservoirs: Option<u32> = None, Within(1.0, 64.0);
        /// Whether a candidate in shadow is dropped before it is reused.
        visibility_reuse: bool = true;
        /// Samples that the reservoir of the frame before counts at most, in those of this frame; 0: it is not reused.
        history: u32 = 20, Within(0.0, 65536.0);
        /// k: neighbours of a round; without it 5, restir-unbiased 3, rtxdi 1. 0: none is reused.
        neighbours: Option<u32> = None, Within(0.0, 64.0);
        /// Neighbours of pixels whose own samples count less than `history`, as where the frame before did not show them; without
        /// it as many as of others, rtxdi 8.
        neighbours_without_history: Option<u32> = None, Within(0.0, 64.0);
        /// Samples that neighbours count at least, in those of this frame, or they are not reused; without it 0, rtxdi 3.
        least_history: Option<u32> = None, Within(0.0, 65536.0);
        /// n: rounds in which neighbours are reused; without it 2, restir-unbiased and rtxdi 1.
        rounds: Option<u32> = None, Within(0.0, 16.0);
        /// Distance within which neighbours are looked for; without it 30, rtxdi 32, on an image 1080 pixels high and in
        /// proportion on others, at least 3.
        radius: Option<f32> = None, Within(1.0, 65536.0), "pixels";
        /// Largest angle between the normals of surfaces that share samples; without it 25, rtxdi 60.
        angle_deg: Option<f32> = None, Within(0.0, 180.0), "degrees";
        /// Largest difference of their distances from the camera, relative.
        depth: f32 = 0.1, Within(0.0, 1e6);
        /// How samples of other surfaces weigh; without it "count", restir-unbiased and rtxdi "balance".
        weights: Option<Weights> = None;
        /// Whether weights other than "count" cast shadow rays from those surfaces; without it only restir-unbiased does.
        shadowed: Option<bool> = None;
        /// Strength of the filter that gives up reservoirs far brighter than those around them; 0: there is none. Without it
        /// rtxdi has 0.2, the others 0.
        boiling: Option<f32> = None, Within(0.0, 1.0);
    }
}

/// Settings that a method's paper has.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    candidates: u32,
    surface_candidates: u32,
    presampled: bool,
    reservoirs: u32,
    neighbours: u32,
    neighbours_without_history: u32,
    least_history: u32,
    rounds: u32,
    /// Pixels of an image 1080 pixels high.
    radius: f32,
    angle_deg: f32,
    weights: Weights,
    shadowed: bool,
    boiling: f32,
    bias: Bias,
}

impl Preset {
    /// Candidates of a reservoir that the surface draws.
    pub fn surface_candidates(&self, given: &Parameters) -> u32 {
        given.surface_candidates.unwrap_or(self.surface_candidates)
    }

    /// With another number of reservoirs.
    pub fn with_reservoirs(self, reservoirs: u32) -> Self {
        Self { reservoirs, ..self }
    }
}

/// Bitterli et al. 2020, section 6, biased.
pub const BIASED: Preset = Preset {
    candidates: 32,
    surface_candidates: 0,
    presampled: false,
    reservoirs: 4,
    neighbours: 5,
    neighbours_without_history: 5,
    least_history: 0,
    rounds: 2,
    radius: 30.0,
    angle_deg: 25.0,
    weights: Weights::Count,
    shadowed: false,
    boiling: 0.0,
    bias: Bias::Biased,
};

/// Bitterli et al. 2020, section 6, unbiased.
pub const UNBIASED: Preset = Preset {
    reservoirs: 1,
    neighbours: 3,
    neighbours_without_history: 3,
    rounds: 1,
    weights: Weights::Balance,
    shadowed: true,
    bias: Bias::Unbiased,
    ..BIASED
};

/// Defaults of the RTXDI library: 8 local, 1 infinite and 1 environment candidate, of which this is the sum. Its samples count 1
/// in all before reuse, and those of at most 2 are not spread to neighbours.
pub const RTXDI: Preset = Preset {
    candidates: 10,
    presampled: true,
    reservoirs: 1,
    neighbours: 1,
    neighbours_without_history: 8,
    least_history: 3,
    rounds: 1,
    radius: 32.0,
    angle_deg: 60.0,
    weights: Weights::Balance,
    boiling: 0.2,
    ..BIASED
};

/// Everything decided.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    pub candidates: u32,
    pub surface_candidates: u32,
    pub presampled: bool,
    pub passes: Option<u32>,
    pub reservoirs: usize,
    pub visibility_reuse: bool,
    pub history: u32,
    pub neighbours: u32,
    pub neighbours_without_history: u32,
    pub least_history: u32,
    pub rounds: u32,
    radius: Radius,
    pub tolerances: Tolerances,
    pub weights: Weights,
    pub shadowed: bool,
    pub boiling: f32,
}

/// How far neighbours are.
#[derive(Clone, Copy, Debug)]
enum Radius {
    Pixels(f32),
    /// On an image [`HEIGHT`] pixels high.
    InProportion(f32),
}

/// Height in pixels of the images that papers give radii for.
const HEIGHT: f32 = 1080.0;
/// Radius in pixels that small images get at least.
const LEAST_RADIUS: f32 = 3.0;

impl Settings {
    /// What the parameters say, over a preset.
    ///
    /// # Errors
    /// Settings that would bias a method that calls itself unbiased.
    pub fn new(given: &Parameters, preset: &Preset) -> Result<Self, ParameterError> {
        let neighbours = given.neighbours.unwrap_or(preset.neighbours);
        let usual_without_history = match given.neighbours {
            Some(neighbours) => neighbours,
            None => preset.neighbours_without_history,
        };
        let angle_deg = given.angle_deg.unwrap_or(preset.angle_deg);
        let settings = Self {
            candidates: given.candidates.unwrap_or(preset.candidates),
            surface_candidates: preset.surface_candidates(given),
            presampled: given.presampled.unwrap_or(preset.presampled),
            passes: given.passes,
            reservoirs: given.reservoirs.unwrap_or(preset.reservoirs) as usize,
            visibility_reuse: given.visibility_reuse,
            history: given.history,
            neighbours,
            neighbours_without_history: given
                .neighbours_without_history
                .unwrap_or(usual_without_history),
            least_history: given.least_history.unwrap_or(preset.least_history),
            rounds: given.rounds.unwrap_or(preset.rounds),
            radius: match given.radius {
                Some(pixels) => Radius::Pixels(pixels),
                None => Radius::InProportion(preset.radius),
            },
            tolerances: Tolerances {
                cosine: angle_deg.to_radians().cos(),
                depth: given.depth,
            },
            weights: given.weights.unwrap_or(preset.weights),
            shadowed: given.shadowed.unwrap_or(preset.shadowed),
            boiling: given.boiling.unwrap_or(preset.boiling),
        };
        settings.keep(preset.bias)?;
        Ok(settings)
    }

    fn keep(&self, bias: Bias) -> Result<(), ParameterError> {
        let wrong = |key, message: &str| Err(ParameterError::new(key, message));
        if bias != Bias::Unbiased {
            return Ok(());
        }
        if self.weights == Weights::Count {
            return wrong(
                "weights",
                "weights = \"count\" is biased: use the method `restir`",
            );
        }
        if !self.shadowed {
            return wrong(
                "shadowed",
                "shadowed = false is biased: use the method `restir` with these weights",
            );
        }
        if !self.visibility_reuse {
            return wrong(
                "visibility_reuse",
                "visibility_reuse = false is biased where weights see shadows: use the method `restir`",
            );
        }
        if self.boiling > 0.0 {
            let boiling = self.boiling;
            let message = format!("boiling = {boiling} is biased: use the method `restir`");
            return wrong("boiling", &message);
        }
        Ok(())
    }

    /// M before reuse.
    pub fn all_candidates(&self) -> u32 {
        self.candidates + self.surface_candidates
    }

    /// How many neighbours a surface asks whose own samples, with those of the frame before, are these.
    pub fn neighbours_of(&self, own: &Reservoir) -> u32 {
        let whole = self.history.saturating_mul(self.all_candidates());
        match whole > 0 && own.count >= whole {
            true => self.neighbours,
            false => self.neighbours_without_history,
        }
    }

    /// Whether neighbours may have a reservoir.
    pub fn is_shared(&self, reservoir: &Reservoir) -> bool {
        reservoir.count >= self.least_history.saturating_mul(self.all_candidates())
    }

    /// Whether weights other than the count see shadows: reservoirs then never hold what their surface does not see.
    pub fn sees_shadows(&self) -> bool {
        self.shadowed && self.weights != Weights::Count
    }

    /// Distance in pixels within which neighbours are looked for on an image of this height.
    pub fn radius(&self, height: usize) -> f32 {
        match self.radius {
            Radius::Pixels(pixels) => pixels,
            Radius::InProportion(radius) => (radius * height as f32 / HEIGHT).max(LEAST_RADIUS),
        }
    }
}
