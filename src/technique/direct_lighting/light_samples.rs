//! The contender `rt`: random samples of the lights at what each camera sample sees, a shadow ray each, without memory.
//!
//! Lights that the surface cannot scatter to the camera cost no ray. What light sampling cannot find, emitters and the
//! environment seen directly, in smooth mirrors and through masks, takes a ray of its own. With `selection = "product"`
//! candidates come from up to 1024 sets that each frame draws; a camera sample takes one of them at random.
//!
//! *Differs* from `paths`: directions are not sampled by the surface, so that there is no noise of choosing between both,
//! and highlights of large lights on smooth surfaces are noisier.

use glam::Vec3;

use super::super::truth::Truth;
use super::super::{
    Contender, ContenderEntry, Passes, Rendered, ShadingFunction, Shot, Terms, each_pixel,
};
use super::selection::{Samples, Selected, Selecting, Selection};
use super::sight::{Sight, surface};
use crate::entry::{About, Bias, parameters};
use crate::sample::Rng;
use crate::shade::{Arriving, EvenLights, Interaction, Sent, TilePart};
use crate::trace::{Caster, RayCounter};

/// Keys its random numbers.
const STREAM: u64 = 0x7274_6c69_6768;

/// Entry in the technique's list.
pub(super) const ENTRY: ContenderEntry<Truth> = ContenderEntry {
    about: About {
        id: "rt",
        module: crate::entry::head_comment!("light_samples.rs"),
        aliases: &["light-samples"],
        summary: "random samples of the lights, a shadow ray each, at what each camera sample sees",
        source: "Stadlbauer et al. 2023, section 4: ray-traced light sampling",
        bias: Bias::Unbiased,
        version: 5,
        failures: &[
            "noise falls with the square root of the rays only",
            "large lights in smooth surfaces are noisy: directions are not sampled by the surface",
        ],
        parameters: Parameters::PARAMETERS,
    },
    start: |_, table, terms| {
        let parameters = Parameters::read(table)?;
        let usual = Parameters::default();
        let set = (parameters.candidates != usual.candidates).then_some("candidates");
        parameters.selection.refuse_unused(set)?;
        Ok(Box::new(LightSamples { parameters, terms }))
    },
};

parameters! {
    #[derive(Clone, Copy, Debug)]
    struct Parameters {
        /// Light samples of each camera sample.
        rays: u32 = 16, Within(1.0, 65536.0);
        /// How their lights are chosen.
        selection: Selection = Selection::Uniform;
        /// Candidates of each sample, for selection = "product".
        candidates: u32 = 8, Within(1.0, 65536.0);
    }
}

struct LightSamples {
    parameters: Parameters,
    terms: Terms,
}

impl Contender for LightSamples {
    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        Ok(shots.iter().map(|shot| self.shot(shot)).collect())
    }
}

impl LightSamples {
    fn shot(&self, shot: &Shot) -> Rendered {
        let samples = self.terms.budget as u32;
        let mut rendered = Rendered::default();
        let counter = RayCounter::default();
        let mut selecting = Selecting {
            lights: shot.paths.lights(),
            even: EvenLights::new(shot.paths.lights()),
            selection: self.parameters.selection,
            candidates: self.parameters.candidates,
            presampled: Vec::new(),
        };
        if self.parameters.selection == Selection::Product {
            let keys = [self.terms.seed, u64::from(shot.frame)];
            let presample = || selecting.presample(self.parameters.rays, keys);
            rendered.stages.time("rendering", presample);
        }
        let lit = Lit {
            shot,
            selecting,
            count: self.parameters.rays,
            seed: self.terms.seed,
        };
        // Each frame takes other samples, or its noise would stick to the screen.
        let first = shot.frame.wrapping_mul(samples);
        let mut passes = Passes::starting_at(first, shot, &lit);
        rendered.stages.time("rendering", || {
            (0..samples).for_each(|_| passes.add(&counter));
        });
        rendered.image = passes.mean();
        rendered.non_finite = passes.non_finite;
        rendered.notes.extend(passes.note());
        rendered.rays = counter.read();
        rendered.found.push(shot.camera_rays(samples));
        rendered
    }
}

/// Camera samples lit by random samples of the lights.
struct Lit<'a> {
    shot: &'a Shot<'a>,
    selecting: Selecting<'a>,
    /// Light samples of each camera sample.
    count: u32,
    seed: u64,
}

impl ShadingFunction for Lit<'_> {
    fn pixels(&self, caster: &Caster, first_pixel: u32, sample: u32, out: &mut [[f32; 3]]) -> u64 {
        let shot = self.shot;
        let mut samples = Samples::default();
        each_pixel(first_pixel, out, |pixel| {
            let mut rng = Rng::new(self.seed, STREAM, u64::from(pixel), u64::from(sample));
            let sight = Sight::of(shot, caster, pixel, &mut rng);
            match sight.surface {
                Some((hit, direction)) => {
                    let at = surface(shot, hit, direction);
                    sight.seen + self.scattered(caster, &at, &mut rng, &mut samples)
                }
                None => sight.seen,
            }
        })
    }
}

impl Lit<'_> {
    /// Light that a surface scatters to the camera: the mean of all samples.
    fn scattered(
        &self,
        caster: &Caster,
        at: &Interaction,
        rng: &mut Rng,
        samples: &mut Samples,
    ) -> Vec3 {
        let adds = |_: &TilePart, sent: &Sent| sent.scattered(at);
        self.selecting.select(at, self.count, rng, adds, samples);
        let one = |light: Selected| {
            let Arriving {
                direction,
                irradiance,
                ..
            } = light.arriving;
            let scattered = at.evaluate(direction) * irradiance;
            if scattered == Vec3::ZERO
                || self.shot.paths.occluded(caster, &light.arriving.shadow_ray)
            {
                return Vec3::ZERO;
            }
            scattered / light.density
        };
        samples.selected.drain(..).map(one).sum::<Vec3>() / self.count as f32
    }
}
