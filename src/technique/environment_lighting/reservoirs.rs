//! The contenders `restir`, `restir-unbiased` and `rtxdi` of environment lighting: see [`crate::technique::restir`].
//!
//! Each sub-pixel sample has reservoirs, which go from one to the next as from frame to frame. Unless the number of
//! reservoirs is given, it is what the budget pays for: two shadow rays each, unbiased six, and one more
//! for each candidate that the surface draws.

use glam::Vec3;
use rayon::prelude::*;
use toml::Table;

use super::super::restir::{
    ABOUT_BIASED, ABOUT_RTXDI, ABOUT_UNBIASED, BIASED, Looks, Parameters, PassNumber, Preset,
    RTXDI, Restir, Sight, Sources, Surface, UNBIASED,
};
use super::super::{Contender, Rendered, Shot, Terms};
use super::illumination;
use super::illumination::Illumination;
use crate::entry::{About, ParameterError};
use crate::trace::RayCounter;

/// A variant as the technique lists it.
pub(super) struct Variant {
    pub about: &'static About,
    preset: Preset,
    /// Rays of a reservoir but for candidates of the surface: for its own sample, those of others and at the end.
    rays: usize,
}

/// All of them.
pub(super) static VARIANTS: &[Variant] = &[
    Variant {
        about: &ABOUT_BIASED,
        preset: BIASED,
        rays: 2,
    },
    Variant {
        about: &ABOUT_UNBIASED,
        preset: UNBIASED,
        rays: 6,
    },
    Variant {
        about: &ABOUT_RTXDI,
        preset: RTXDI,
        rays: 2,
    },
];

impl Variant {
    pub fn start<'a>(
        &self,
        table: &Table,
        terms: Terms,
    ) -> Result<Box<dyn Contender + 'a>, ParameterError> {
        let parameters = Parameters::read(table)?;
        let candidates = self.preset.surface_candidates(&parameters) as usize;
        let affordable = (terms.budget / (self.rays + candidates)).clamp(1, 64) as u32;
        let preset = self.preset.with_reservoirs(affordable);
        let restir = Restir::new(table, &preset, Sources::Environment, terms.seed)?;
        if restir.passes().is_some() {
            let message =
                "passes: environment lighting makes one for each camera sample: set `spp`";
            return Err(ParameterError::new("passes", message));
        }
        Ok(Box::new(Reservoirs { restir }))
    }
}

struct Reservoirs {
    restir: Restir,
}

impl Contender for Reservoirs {
    fn remembers(&self) -> bool {
        true
    }

    fn memory(&self) -> Result<Vec<u8>, String> {
        self.restir.memory()
    }

    fn recall(&mut self, memory: &[u8]) -> Result<(), String> {
        self.restir.recall(memory)
    }

    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        let render = |shot: &Shot| {
            let scene = SubPixelSamples {
                illumination: illumination(shot)?,
            };
            let mut rendered = self.restir.frame(shot, shot.spp, &scene);
            let reservoirs = self.restir.reservoirs() as f64;
            rendered.found.push(("reservoirs", reservoirs));
            Ok(rendered)
        };
        shots.iter().map(render).collect()
    }
}

/// What the sub-pixel samples see that all contenders share.
struct SubPixelSamples<'a> {
    illumination: Illumination<'a>,
}

impl Looks for SubPixelSamples<'_> {
    fn look(&self, shot: &Shot, pass: PassNumber, rendered: &mut Rendered) -> Vec<Sight> {
        let counter = RayCounter::default();
        let look = || {
            (0..shot.pixels() as u32)
                .into_par_iter()
                .with_min_len(64)
                .map_init(
                    || shot.tracer.caster(&counter),
                    |caster, pixel| match self.illumination.point(caster, pixel, pass.of_frame) {
                        Ok((_, seen)) => Sight {
                            seen: Vec3::ZERO,
                            factor: seen.throughput * self.illumination.scale,
                            surface: Some(Surface::new(shot, seen.hit, seen.direction, seen.depth)),
                        },
                        Err(radiance) => Sight {
                            seen: radiance,
                            factor: Vec3::ONE,
                            surface: None,
                        },
                    },
                )
                .collect()
        };
        let sights = rendered.stages.time("camera_samples", look);
        rendered.rays += counter.read();
        sights
    }
}
