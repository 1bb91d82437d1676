//! The contenders `restir`, `restir-unbiased` and `rtxdi` of direct lighting: see [`crate::technique::restir`].
//!
//! The budget's samples are camera samples of a pixel and frame (or as many as `passes` says), each with reservoirs that go
//! from one to the next as from frame to frame.

use rayon::prelude::*;

use super::super::restir::{
    ABOUT_BIASED, ABOUT_RTXDI, ABOUT_UNBIASED, BIASED, Looks, PassNumber, Preset, RTXDI, Restir,
    Sight, Sources, Surface, UNBIASED,
};
use super::super::truth::Truth;
use super::super::{Contender, ContenderEntry, Rendered, Shot, Terms};
use crate::entry::ParameterError;
use crate::sample::Rng;
use crate::technique::radiance::viewer_key;
use crate::trace::RayCounter;

/// Keys what camera samples see.
const STREAM: u64 = 0x7265_7374_6c6f;

/// Biased, as in the paper.
pub(super) const RESTIR: ContenderEntry<Truth> = ContenderEntry {
    about: ABOUT_BIASED,
    start: |_, table, terms| start(table, &BIASED, terms),
};

/// Unbiased, as in the paper.
pub(super) const RESTIR_UNBIASED: ContenderEntry<Truth> = ContenderEntry {
    about: ABOUT_UNBIASED,
    start: |_, table, terms| start(table, &UNBIASED, terms),
};

/// With settings like the library's.
pub(super) const RTXDI_LIKE: ContenderEntry<Truth> = ContenderEntry {
    about: ABOUT_RTXDI,
    start: |_, table, terms| start(table, &RTXDI, terms),
};

fn start<'a>(
    table: &toml::Table,
    preset: &Preset,
    terms: Terms,
) -> Result<Box<dyn Contender + 'a>, ParameterError> {
    Ok(Box::new(Reservoirs {
        restir: Restir::new(table, preset, Sources::All, terms.seed)?,
        terms,
    }))
}

struct Reservoirs {
    restir: Restir,
    terms: Terms,
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
        let passes = self.restir.passes().unwrap_or(self.terms.budget as u32);
        let scene = CameraSamples {
            seed: self.terms.seed,
        };
        let render = |shot: &Shot| {
            let mut rendered = self.restir.frame(shot, passes, &scene);
            rendered.found.push(shot.camera_rays(passes));
            rendered
        };
        Ok(shots.iter().map(render).collect())
    }
}

/// A random place of each pixel.
struct CameraSamples {
    seed: u64,
}

impl Looks for CameraSamples {
    fn look(&self, shot: &Shot, pass: PassNumber, rendered: &mut Rendered) -> Vec<Sight> {
        let counter = RayCounter::default();
        let stream = STREAM ^ viewer_key(shot);
        let look = || {
            (0..shot.pixels() as u32)
                .into_par_iter()
                .with_min_len(64)
                .map_init(
                    || shot.tracer.caster(&counter),
                    |caster, pixel| {
                        let item = u64::from(pixel);
                        let mut rng = Rng::new(self.seed, stream, item, u64::from(pass.of_viewer));
                        let sight = super::sight::Sight::of(shot, caster, pixel, &mut rng);
                        let surface = |(hit, direction): (crate::trace::Hit, _)| {
                            Surface::new(shot, hit, direction, hit.t)
                        };
                        Sight {
                            seen: sight.seen,
                            factor: glam::Vec3::ONE,
                            surface: sight.surface.map(surface),
                        }
                    },
                )
                .collect()
        };
        let sights = rendered.stages.time("camera_samples", look);
        rendered.rays += counter.read();
        sights
    }
}
