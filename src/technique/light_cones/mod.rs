//! The contender `light-cones`: the direct light on surface points as a few cones in the texels of a cache on surfaces, which
//! all viewers share (Stadlbauer et al. 2024, "Surface Light Cones").
//!
//! Of each frame, the camera samples of all viewers ask for texels (`sight`). Every texel that is asked for is then updated
//! once (`gather`): `samples` lights are sampled from its surface point, or one where its light has been at rest, and the
//! cones that hold their light are widened, merged and, where a ray near their edge meets no light,
//! narrowed. Texels that begin while nothing changes take over the cones of the next coarser or finer texel there (`reuse`).
//! Images are made
//! without shadow rays (`shade`): directions of each cone are put into the material at the camera sample. What a
//! pixel sees without scattering (lamps, mirrors, glass, the sky) is traced.
//!
//! *Differs:* light is integrated over solid angle (the paper's sum says nothing of it); small cones without light are
//! not removed but fade; where cones are merged or widened, the widening is weighed by the light that it spreads, and the
//! narrowest cone around a sample takes it, so that the sun is not lost in the sky (`rules`); lights are chosen
//! by what they would add without shadows, times the share of their samples that reached the block of late (`hidden`), among
//! candidates of which each frame draws sets for all texels; an entry
//! counts its samples, and gets one ray once it counts those of `first_updates` updates, so that a turn of a cone, which
//! lowers the count, brings the rays back; so does a change of the scene (`motion`), and a texel that nobody asked for when
//! something changed begins anew when it is seen again. A turn is that of an axis over a whole update. Turns do not lower the
//! count alone: so do light that differs from that of the last updates (`surprise`), light from elsewhere (`news`) and cones
//! that are dark and met by none (`doubt`), the latter two while the scene changes; where a light is switched on or off, all
//! counts are 1. In texels of a shape that turns, cones turn with it (`orientation`). Texels whose centre another surface cuts
//! off are moved (`cut_off`), and one cone of a texel at rest is tested at its edge (`calm_tests`). Of diffuse surfaces cones
//! that lie above them are shaded in closed form, and with `filter = "bilinear"` four texels share the directions.

mod charts;
mod cut_off;
mod gather;
mod hidden;
mod memory;
mod options;
mod reuse;
mod shade;
mod shown;
mod sight;
mod stillness;
mod texels;

use self::charts::Found;
use self::gather::{Gathering, Tally};
use self::memory::Memory;
use self::options::{CutOff, Motion, Parameters, Reuse};
use self::shade::{Shaded, Shading};
use self::sight::Sight;
use self::stillness::Stillness;
use self::texels::Surfaces;
use crate::cache::cones::Storage;
use crate::cache::surface::{Asked, Blocks, Grid, Layout, Limits, Requests};
use crate::entry::{About, Bias};
use crate::shade::EvenLights;
use crate::technique::direct_lighting::selection::{Selecting, Selection};
use crate::technique::truth::Truth;
use crate::technique::{Contender, ContenderEntry, Rendered, Shot, Terms};
use crate::trace::RayCounter;

/// Entry in the technique's list.
pub const ENTRY: ContenderEntry<Truth> = ContenderEntry {
    about: About {
        id: "light-cones",
        module: crate::entry::head_comment!("mod.rs"),
        aliases: &["surface-light-cones", "slc"],
        summary: "direct light as a few cones in texels on surfaces that all viewers share, shaded without shadow rays",
        source: "Stadlbauer, Weinrauch, Tatzgern & Steinberger 2024; cache of Weinrauch et al. 2023",
        bias: Bias::Biased,
        version: 15,
        failures: &[
            "shadows finer than a texel are lost, and with filter = \"nearest\" texels are seen",
            "lights without a shape (points, spots, parallel light) are met by no test at a cone's edge: their cones stay narrow",
            "where more lights are strong than there are cones, far ones share a cone: highlights move and noise stays",
            "a smooth sky has no few directions: its cones cover the hemisphere",
            "light that moves or goes out trails behind by some frames: longest where a small part of it changes",
        ],
        parameters: Parameters::PARAMETERS,
    },
    start: |_, table, terms| {
        let parameters = Parameters::read(table)?;
        let usual = Parameters::default();
        let candidates = (parameters.candidates != usual.candidates).then_some("candidates");
        let hidden = (parameters.hidden != usual.hidden).then_some("hidden");
        parameters.selection.refuse_unused(candidates.or(hidden))?;
        Ok(Box::new(LightCones {
            parameters,
            terms,
            surfaces: None,
            remembered: None,
        }))
    },
};

struct LightCones {
    parameters: Parameters,
    terms: Terms,
    /// Made when the scene is first seen.
    surfaces: Option<Surfaces>,
    /// What an interrupted sequence had, until the scene is seen.
    remembered: Option<Vec<u8>>,
}

impl Contender for LightCones {
    fn remembers(&self) -> bool {
        true
    }

    fn memory(&self) -> Result<Vec<u8>, String> {
        match &self.surfaces {
            Some(surfaces) => Memory::of(surfaces).bytes(),
            None => Ok(self.remembered.clone().unwrap_or_default()),
        }
    }

    fn recall(&mut self, memory: &[u8]) -> Result<(), String> {
        self.remembered = (!memory.is_empty()).then(|| memory.to_vec());
        self.surfaces = None;
        Ok(())
    }

    fn frame(&mut self, shots: &[Shot]) -> Result<Vec<Rendered>, String> {
        let mut images: Vec<Rendered> = shots.iter().map(|_| Rendered::default()).collect();
        let (Some(first), Some(rendered)) = (shots.first(), images.first_mut()) else {
            return Ok(images);
        };
        let mut surfaces = match self.surfaces.take() {
            Some(surfaces) => surfaces,
            None => self.started(first, rendered)?,
        };
        rendered
            .stages
            .time("blocks", || surfaces.stillness.next(first.scene));
        let mut sights: Vec<Sight> = shots
            .iter()
            .zip(&mut images)
            .map(|(shot, rendered)| self.look(&surfaces, shot, rendered))
            .collect();
        let of_viewers = sights.iter().map(|sight| sight.requests.texels()).sum();
        let asked = sights.iter_mut().map(|s| std::mem::take(&mut s.requests));
        let merged = || Requests::merged(asked.collect());
        let requests = images[0].stages.time("blocks", merged);
        let seen: Vec<(&Shot, &Sight)> = shots.iter().zip(&sights).collect();
        let updated = self.update(&mut surfaces, &requests, &seen, &mut images[0]);
        for ((shot, sight), rendered) in shots.iter().zip(&sights).zip(&mut images) {
            self.show(&surfaces, shot, sight, rendered);
            updated.report(&surfaces, of_viewers, rendered);
        }
        // What viewers share is held once.
        images[0].bytes_cache = surfaces.blocks.allocated_bytes() + surfaces.charts.bytes();
        self.surfaces = Some(surfaces);
        Ok(images)
    }
}

impl LightCones {
    fn storage(&self) -> Storage {
        let cones = self.parameters.rules.cones;
        match self.parameters.compressed {
            true => Storage::Compressed { cones },
            false => Storage::Full { cones },
        }
    }

    /// The charts of a scene with no texel yet, or with those of earlier frames.
    fn started(&mut self, shot: &Shot, rendered: &mut Rendered) -> Result<Surfaces, String> {
        let limits = Limits {
            blocks: self.parameters.most_blocks,
            frames: self.parameters.keep_frames,
        };
        let layout = Layout {
            texel: self.storage().words(),
            block: hidden::WORDS,
        };
        let blocks = Blocks::new(limits, layout);
        let scene = shot.scene;
        if let Some(memory) = self.remembered.take() {
            let restored = || Memory::read(&memory)?.restored(blocks, scene);
            return rendered.stages.time("charts", restored);
        }
        let Found {
            charts, seconds, ..
        } = Found::of(scene);
        rendered.stages.add("charts", seconds);
        Ok(Surfaces {
            charts,
            grid: Grid {
                finest: scene.diagonal / self.parameters.finest,
            },
            blocks,
            stillness: Stillness::default(),
        })
    }

    /// What a viewer sees, and the texels that it asks for.
    fn look(&self, surfaces: &Surfaces, shot: &Shot, rendered: &mut Rendered) -> Sight {
        let counter = RayCounter::default();
        let sight = rendered.stages.time("visibility", || {
            Sight::new(shot, surfaces, &self.parameters, self.terms.seed, &counter)
        });
        rendered.rays += counter.read();
        sight
    }

    /// Maps and updates every texel that is asked for.
    fn update(
        &self,
        surfaces: &mut Surfaces,
        requests: &Requests,
        seen: &[(&Shot, &Sight)],
        rendered: &mut Rendered,
    ) -> Updated {
        let (shot, _) = seen[0];
        let gathering = Gathering {
            shot,
            parameters: &self.parameters,
            storage: self.storage(),
            selecting: rendered.stages.time("update", || self.selecting(shot)),
            samples: self.terms.budget as u32,
            seed: self.terms.seed,
            restless: self.parameters.motion == Motion::Scene
                && surfaces.stillness.frames < self.parameters.first_updates,
            switched: self.parameters.motion == Motion::Scene && surfaces.stillness.switched,
        };
        let asked = rendered.stages.time("blocks", || {
            let Surfaces {
                charts,
                grid,
                blocks,
                stillness,
            } = &mut *surfaces;
            let asked = blocks.begin(requests, charts, grid);
            if self.parameters.motion == Motion::Scene && stillness.frames == 0 {
                blocks.miss();
            }
            // While things change, and some frames after, entries are watched: they are not far from what they should be.
            // What returns soon after a change is watched for long enough, what returns later begins anew.
            let rests = !gathering.restless;
            if rests || 2 * stillness.frames <= self.parameters.first_updates {
                blocks.catch_up(rests);
            }
            asked
        });
        let counter = RayCounter::default();
        let moved = match self.parameters.cut_off {
            CutOff::Kept => 0,
            CutOff::Moved => rendered.stages.time("blocks", || {
                cut_off::uncover(surfaces, seen, &self.parameters, &counter)
            }),
        };
        let reuses = match self.parameters.reuse {
            Reuse::Never => false,
            Reuse::AtRest => !gathering.restless,
            Reuse::Always => true,
        };
        let reused = match reuses {
            true => rendered.stages.time("reuse", || gathering.reuse(surfaces)),
            false => 0,
        };
        let tally = rendered.stages.time("update", || {
            gathering.update(&mut surfaces.blocks, &counter)
        });
        rendered.rays += counter.read();
        rendered.non_finite += tally.non_finite;
        Updated {
            texels: requests.texels(),
            blocks: requests.blocks().len() as u64,
            asked,
            moved,
            reused,
            tally,
        }
    }

    /// How lights are chosen in a frame; candidates are drawn once for all texels.
    fn selecting<'s>(&self, shot: &'s Shot) -> Selecting<'s> {
        let lights = shot.paths.lights();
        let mut selecting = Selecting {
            lights,
            even: EvenLights::new(lights),
            selection: self.parameters.selection,
            candidates: self.parameters.candidates,
            presampled: Vec::new(),
        };
        let samples = self.terms.budget as u32;
        let calm = self.parameters.calm_samples.min(samples);
        if self.parameters.selection == Selection::Product {
            let keys = [self.terms.seed, u64::from(shot.frame)];
            selecting.presample(samples, keys);
            if calm < samples {
                selecting.presample(calm, keys);
            }
        }
        selecting
    }

    /// Makes an image of the texels.
    fn show(&self, surfaces: &Surfaces, shot: &Shot, sight: &Sight, rendered: &mut Rendered) {
        let counter = RayCounter::default();
        let shading = Shading {
            shot,
            surfaces,
            parameters: &self.parameters,
            storage: self.storage(),
            samples: self.terms.budget as u32,
            seed: self.terms.seed,
        };
        let Shaded { image, tally } = rendered
            .stages
            .time("shading", || shading.image(sight, &counter));
        rendered.rays += counter.read();
        rendered.image = image;
        rendered.lookups += tally.lookups;
        rendered.non_finite += tally.non_finite;
        let samples = (shot.pixels() as u64 * u64::from(shot.spp)).max(1) as f64;
        rendered.found.extend([
            shot.camera_rays(shot.spp),
            ("uncached", tally.uncached as f64 / samples),
            ("other_texel_sizes", sight.other_sizes as f64 / samples),
        ]);
    }
}

/// What became of the texels of a frame, of all viewers together.
struct Updated {
    /// Texels that were asked for, and their blocks.
    texels: u64,
    blocks: u64,
    asked: Asked,
    /// Texels that were moved to where a camera sees their surface.
    moved: u64,
    /// Texels that began with the cones of another level.
    reused: u64,
    tally: Tally,
}

impl Updated {
    /// Says it of an image; `of_viewers` texels were asked for by all viewers, those of several counted for each.
    fn report(&self, surfaces: &Surfaces, of_viewers: u64, rendered: &mut Rendered) {
        let share = |part: u64, whole: u64| part as f64 / whole.max(1) as f64;
        let blocks = &surfaces.blocks;
        let tally = &self.tally;
        rendered.found.extend([
            ("islands", surfaces.charts.len() as f64),
            ("blocks", blocks.len() as f64),
            ("new_blocks", self.asked.new as f64),
            ("evicted", self.asked.evicted as f64),
            ("refused_blocks", self.asked.refused as f64),
            ("texels", self.texels as f64),
            ("shared_texels", share(of_viewers - self.texels, of_viewers)),
            ("block_fill", share(self.texels, 64 * self.blocks)),
            ("moved_texels", self.moved as f64),
            ("reused_texels", self.reused as f64),
            ("calm_texels", share(tally.calm, tally.texels)),
            ("cones", share(tally.cones, tally.texels)),
            ("light_samples", tally.samples as f64),
            ("edge_tests", tally.tests as f64),
            ("active_bytes", blocks.active_bytes() as f64),
            ("allocated_bytes", blocks.allocated_bytes() as f64),
        ]);
        if tally.too_bright > 0 {
            rendered.notes.push(
                "light of texels is brighter than compressed entries hold (131,064): what is above that is lost, and \
                 `compressed = false` keeps it"
                    .into(),
            );
        }
        if self.asked.refused > 0 {
            rendered.notes.push(
                "blocks of texels found no room: most_blocks is too small, and what they should show is lit by light \
                 samples of its own"
                    .into(),
            );
        }
    }
}
