//! ReSTIR (Bitterli et al. 2020): each pixel resamples candidates of its own, of the frame before and of neighbours, and
//! casts shadow rays for the few samples that are left.
//!
//! What is reused is a *place on a light* ([`crate::shade::LightPlace`]): the lights of all kinds and the environment are
//! treated alike, and reuse needs no Jacobian, because densities of places do not depend on the surface (near a triangle, a
//! place is a direction to it, and its density still that of the area). The target is the luminance of what the place would add
//! without shadows. A pass goes over the pixels of a shot stage by stage (`pass`); each viewer has its own reservoirs
//! (`history`); `settings` has the variants.
//!
//! **Motion.** A surface is looked for where its point was one frame earlier. The surface that was there then is carried
//! along with what moves, and what it could have drawn is asked of it in the present scene: exact while nothing moves.
//!
//! *Differs* from the paper: the radius of neighbours follows the height of the image; places of the camera samples in
//! their pixels are random, as those of the truth; lights are chosen by power with half of it spread evenly over all of
//! them, a shape that emits being one. *Differs* from the RTXDI library: 10 candidates of all lights for 8 + 1 + 1 of kinds,
//! presampled as whole sets (the library picks from larger tiles); none drawn by the surface unless `surface_candidates` says so,
//! because the library's one costs a ray and gains next to nothing (`light-cones/rivals`); a surface that the frame before shows elsewhere
//! is not looked for around that place, and neighbours may have another material; neighbours without history do not count at all,
//! where the library counts their samples and leaves out their light; no permutation of pixels, no reuse of the last shadow ray.

mod boiling;
mod candidates;
mod combine;
mod history;
mod pass;
mod receiver;
mod reservoir;
mod settings;

pub use pass::Sources;
pub use receiver::Surface;
pub use settings::{BIASED, Parameters, Preset, RTXDI, UNBIASED};

use glam::Vec3;

use self::history::History;
use self::pass::{Pass, Tally};
use self::settings::Settings;
use super::{Rendered, Shot};
use crate::entry::{About, Bias, ParameterError};

/// As lists show the biased variant.
pub const ABOUT_BIASED: About = About {
    id: "restir",
    module: crate::entry::head_comment!("mod.rs"),
    aliases: &[],
    summary: "light samples resampled over pixels and frames, biased: 32 candidates, 5 neighbours in 2 rounds",
    source: "Bitterli et al. 2020, algorithms 3 to 5",
    bias: Bias::Biased,
    version: 3,
    failures: &[
        "light through half-transparent masks is too dark: each surface that reuses a sample draws its shadow anew",
        "too dark where neighbours or the frame before saw what the surface does not",
        "errors of neighbours are alike, which shows as blotches and flickers",
        "highlights of large lights in smooth surfaces are noisy: candidates know the lights alone",
        "reflections in mirrors are not found again in the frame before",
    ],
    parameters: Parameters::PARAMETERS,
};

/// As lists show the unbiased variant.
pub const ABOUT_UNBIASED: About = About {
    id: "restir-unbiased",
    module: crate::entry::head_comment!("mod.rs"),
    aliases: &[],
    summary: "light samples resampled over pixels and frames, unbiased: 32 candidates, 3 neighbours, weights with shadow rays",
    source: "Bitterli et al. 2020, algorithm 6 with weights of multiple importance sampling",
    bias: Bias::Unbiased,
    version: 3,
    failures: &[
        "light through half-transparent masks is too dark: each surface that reuses a sample draws its shadow anew",
        "unbiased while nothing moves: what a surface could have drawn in the frame before is asked in the present scene",
        "errors of neighbours are alike, which shows as blotches and flickers",
        "samples that few surfaces could have drawn are rare and bright",
    ],
    parameters: Parameters::PARAMETERS,
};

/// As lists show the variant of the library.
pub const ABOUT_RTXDI: About = About {
    id: "rtxdi",
    module: crate::entry::head_comment!("mod.rs"),
    aliases: &["restir-rtxdi"],
    summary: "light samples resampled over pixels and frames, with settings like the RTXDI library's defaults",
    source: "Bitterli et al. 2020; defaults of NVIDIA's RTXDI library, ReSTIRDI.cpp",
    bias: Bias::Biased,
    version: 5,
    failures: &[
        "light through half-transparent masks is too dark: each surface that reuses a sample draws its shadow anew",
        "weights do not see shadows: biased at their edges",
        "one sample a pixel: noisy under few large lights",
        "highlights of large lights in smooth surfaces are noisy: candidates know the lights alone",
        "the filter against boiling makes what few pixels find darker",
    ],
    parameters: Parameters::PARAMETERS,
};

/// ReSTIR at work: its settings, and what it remembers of each viewer.
pub struct Restir {
    settings: Settings,
    sources: Sources,
    seed: u64,
    /// By the viewers' numbers.
    histories: Vec<Option<History>>,
}

impl Restir {
    /// Nothing seen yet.
    ///
    /// # Errors
    /// Unknown and unfit parameters.
    pub fn new(
        table: &toml::Table,
        preset: &Preset,
        sources: Sources,
        seed: u64,
    ) -> Result<Self, ParameterError> {
        Ok(Self {
            settings: Settings::new(&Parameters::read(table)?, preset)?,
            sources,
            seed,
            histories: Vec::new(),
        })
    }

    /// Passes of a frame, where the settings say so.
    pub fn passes(&self) -> Option<u32> {
        self.settings.passes
    }

    /// Reservoirs of a pixel.
    pub fn reservoirs(&self) -> usize {
        self.settings.reservoirs
    }

    /// What it remembers, so that a sequence can go on from there.
    ///
    /// # Errors
    /// A sentence.
    pub fn memory(&self) -> Result<Vec<u8>, String> {
        postcard::to_allocvec(&self.histories).map_err(|error| error.to_string())
    }

    /// Remembers what [`Restir::memory`] gave; nothing where that is empty.
    ///
    /// # Errors
    /// A sentence, where it is not what these settings gave.
    pub fn recall(&mut self, memory: &[u8]) -> Result<(), String> {
        if memory.is_empty() {
            return Ok(());
        }
        let histories: Vec<Option<History>> =
            postcard::from_bytes(memory).map_err(|error| error.to_string())?;
        let fits = |history: &History| {
            let [width, height] = history.size;
            let pixels = width * height;
            history.surfaces.len() == pixels
                && history.reservoirs.len() == pixels * self.settings.reservoirs
        };
        if !histories.iter().flatten().all(fits) {
            return Err("what is remembered has other numbers of pixels or reservoirs".into());
        }
        self.histories = histories;
        Ok(())
    }

    /// All passes of a frame: `look` says what the pixels show in the pass of this number, their surfaces and what is made
    /// of the light that these scatter, added up in the image.
    pub fn frame(&mut self, shot: &Shot, passes: u32, scene: &dyn Looks) -> Rendered {
        let mut rendered = Rendered::default();
        let mut tally = Tally::default();
        let mut sums = vec![[0.0f64; 3]; shot.pixels()];
        for pass in 0..passes {
            let pass = PassNumber {
                of_frame: pass,
                of_viewer: shot.frame.wrapping_mul(passes).wrapping_add(pass),
            };
            let sights = scene.look(shot, pass, &mut rendered);
            let light = self.pass(shot, &sights, pass, &mut rendered, &mut tally);
            for ((sum, sight), light) in sums.iter_mut().zip(&sights).zip(light) {
                let value = sight.seen + sight.factor * light;
                if value.is_finite() {
                    (0..3).for_each(|c| sum[c] += f64::from(value[c]));
                } else {
                    rendered.non_finite += 1;
                }
            }
        }
        rendered.image = crate::image::Image {
            width: shot.width,
            height: shot.height,
            pixels: sums
                .iter()
                .map(|sum| sum.map(|s| (s / f64::from(passes.max(1))) as f32))
                .collect(),
        };
        rendered.lookups = tally.lookups;
        rendered.non_finite += tally.non_finite;
        let of_pixels = shot.pixels() as f64 * f64::from(passes.max(1));
        rendered.found.extend([
            ("reprojected", tally.found as f64 / of_pixels),
            ("rejected_reservoirs", tally.rejected as f64),
        ]);
        if self.settings.boiling > 0.0 {
            rendered
                .found
                .push(("boiling_reservoirs", tally.boiling as f64));
        }
        let history = self.histories.get(usize::from(shot.viewer));
        rendered.bytes_cache = history
            .and_then(Option::as_ref)
            .map_or(0, |history| history.bytes());
        rendered
    }

    fn pass(
        &mut self,
        shot: &Shot,
        sights: &[Sight],
        pass: PassNumber,
        rendered: &mut Rendered,
        tally: &mut Tally,
    ) -> Vec<Vec3> {
        let viewer = usize::from(shot.viewer);
        if self.histories.len() <= viewer {
            self.histories.resize_with(viewer + 1, || None);
        }
        let before = self.histories[viewer].take();
        let surfaces: Vec<Option<Surface>> = sights.iter().map(|sight| sight.surface).collect();
        let (light, reservoirs) = Pass {
            shot,
            settings: &self.settings,
            sources: self.sources,
            seed: self.seed,
            number: u64::from(pass.of_viewer),
            surfaces: &surfaces,
            before: before.as_ref(),
            moved: pass.of_frame == 0,
        }
        .run(rendered, tally);
        self.histories[viewer] = Some(History {
            view: shot.view.clone(),
            size: [shot.width, shot.height],
            surfaces,
            reservoirs,
        });
        light
    }
}

/// Which pass it is.
#[derive(Clone, Copy, Debug)]
pub struct PassNumber {
    /// Among those of its frame.
    pub of_frame: u32,
    /// Among all of the viewer.
    pub of_viewer: u32,
}

/// What a pixel shows in a pass.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// Radiance that needs no samples of lights.
    pub seen: Vec3,
    /// What the light of the surface is multiplied by.
    pub factor: Vec3,
    pub surface: Option<Surface>,
}

/// What a technique shows ReSTIR of its scenes.
pub trait Looks {
    /// What all pixels show in a pass, row-major. Time, rays and what is not finite go to `rendered`.
    fn look(&self, shot: &Shot, pass: PassNumber, rendered: &mut Rendered) -> Vec<Sight>;
}
