//! Updating texels: light samples from their surface points, and rays near the edges of their cones.

use glam::Vec3;

use super::hidden::Hidden;
use super::options::{CalmTests, HiddenLights, Parameters};
use super::texels::{frame_of, hit_of};
use crate::cache::cones::{Cone, EdgeTest, Entry, MOST_CONES, Storage, Update, Weighting};
use crate::cache::surface::{BLOCK_TEXELS, Block, Blocks};
use crate::image::luminance;
use crate::sample::{Frame, Rng};
use crate::shade::{Interaction, LIGHT_GROUPS, Sent, TilePart};
use crate::technique::Shot;
use crate::technique::direct_lighting::selection::{Samples, Selected, Selecting};
use crate::trace::{Caster, Hit, RayCounter};

/// The updates of a frame.
pub(super) struct Gathering<'a> {
    /// Any of the frame: lights and surfaces are the same for all viewers.
    pub shot: &'a Shot<'a>,
    pub parameters: &'a Parameters,
    pub storage: Storage,
    pub selecting: Selecting<'a>,
    /// Light samples of an entry that is not at rest.
    pub samples: u32,
    pub seed: u64,
    /// Whether something of the scene has changed of late.
    pub restless: bool,
    /// Whether a light was just switched: what is remembered then counts as one sample.
    pub switched: bool,
}

/// What updates took and met.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub texels: u64,
    /// Texels at rest.
    pub calm: u64,
    pub cones: u64,
    /// Light samples, with those that cast no ray.
    pub samples: u64,
    /// Rays near the edges of cones.
    pub tests: u64,
    /// Values that were not finite and count as no light.
    pub non_finite: u64,
    /// Entries with more light than is kept.
    pub too_bright: u64,
}

impl Tally {
    fn add(&mut self, other: &Self) {
        self.texels += other.texels;
        self.calm += other.calm;
        self.cones += other.cones;
        self.samples += other.samples;
        self.tests += other.tests;
        self.non_finite += other.non_finite;
        self.too_bright += other.too_bright;
    }
}

/// What a thread works with.
struct Workplace<'a> {
    caster: Caster<'a>,
    samples: Samples,
}

/// Keys the random numbers of updates.
const STREAM: u64 = 0x636f_6e65_7570;

impl Gathering<'_> {
    /// Updates every texel that this frame asks for.
    pub fn update(&self, blocks: &mut Blocks, counter: &RayCounter) -> Tally {
        let tallies = blocks.work(
            || Workplace {
                caster: self.shot.tracer.caster(counter),
                samples: Samples::default(),
            },
            |workplace, block| self.update_block(workplace, block),
        );
        let mut all = Tally::default();
        tallies.iter().for_each(|tally| all.add(tally));
        all
    }

    fn update_block(&self, workplace: &mut Workplace, block: Block) -> Tally {
        let mut tally = Tally::default();
        let back = block.key.surface().back;
        let size = self.storage.words();
        let (texels, hidden) = block.words.split_at_mut(BLOCK_TEXELS * size);
        let mut hidden = Hidden::of(hidden);
        for index in (0..BLOCK_TEXELS).filter(|index| block.asked >> index & 1 == 1) {
            let point = block.points[index];
            if !point.is_somewhere() {
                continue;
            }
            let words = &mut texels[index * size..][..size];
            let number = u64::from(self.shot.frame) << 6 | index as u64;
            let mut rng = Rng::new(self.seed, STREAM, block.key.bits(), number);
            let hit = hit_of(point);
            let at = self.shot.paths.surfaces().bare(&hit, Vec3::NEG_Z);
            let normal = match back {
                true => -at.geometric_normal,
                false => at.geometric_normal,
            };
            let orientation = self.parameters.orientation;
            let texel = Receiver {
                frame: frame_of(self.shot.scene, point.triangle, normal, orientation),
                at,
                normal,
            };
            let entry = self.storage.read(words);
            let entry = self.updated(workplace, &texel, entry, &mut hidden, &mut rng, &mut tally);
            tally.too_bright += u64::from(self.storage.is_too_bright(&entry));
            self.storage.write(&entry, words);
        }
        tally
    }

    /// Whether the light of an entry is at rest.
    fn is_calm(&self, entry: &Entry) -> bool {
        let rules = &self.parameters.rules;
        let first = self.parameters.first_updates;
        let enough = match rules.weighting {
            Weighting::Samples => first * self.samples,
            Weighting::Updates => first,
        };
        !self.restless && entry.count >= (enough as f32).min(rules.most_count)
    }

    /// An entry after an update.
    fn updated(
        &self,
        workplace: &mut Workplace,
        texel: &Receiver,
        mut entry: Entry,
        hidden: &mut Hidden,
        rng: &mut Rng,
        tally: &mut Tally,
    ) -> Entry {
        let calm = self.is_calm(&entry);
        if self.switched {
            entry.count = entry.count.min(1.0);
        }
        let samples = match calm {
            true => self.parameters.calm_samples.min(self.samples),
            false => self.samples,
        };
        let mut update = Update::of(entry, &self.parameters.rules, samples);
        if self.restless {
            update.listen();
        }
        let cosine = |direction: Vec3| direction.dot(texel.normal).max(0.0);
        let remembers = self.parameters.hidden == HiddenLights::Remembered;
        let chances = match remembers {
            true => hidden.chances(),
            false => [1.0; LIGHT_GROUPS],
        };
        let adds = |part: &TilePart, sent: &Sent| part.received(sent, texel.normal, &chances);
        let Workplace {
            caster,
            samples: lit,
        } = workplace;
        self.selecting.select(&texel.at, samples, rng, adds, lit);
        for Selected {
            arriving,
            group,
            density,
        } in lit.selected.drain(..)
        {
            if cosine(arriving.direction) == 0.0 || arriving.irradiance == Vec3::ZERO {
                continue;
            }
            let light = arriving.irradiance / density;
            if !light.is_finite() {
                tally.non_finite += 1;
                continue;
            }
            let arrives = !self.shot.paths.occluded(caster, &arriving.shadow_ray);
            if remembers {
                hidden.remember(group, arrives);
            }
            if arrives {
                let direction = texel.frame.to_local(arriving.direction);
                update.add(direction, light / samples as f32);
            }
        }
        if !calm {
            update.watch();
        }
        update.take_news();
        update.average();
        self.test(caster, texel, &mut update, rng, calm, tally);
        let entry = update.finish();
        tally.texels += 1;
        tally.calm += u64::from(calm);
        tally.cones += entry.cones().len() as u64;
        tally.samples += u64::from(samples);
        entry
    }

    /// Tests the edges of cones and shrinks those without light.
    fn test(
        &self,
        caster: &Caster,
        texel: &Receiver,
        update: &mut Update,
        rng: &mut Rng,
        calm: bool,
        tally: &mut Tally,
    ) {
        let mut dark = [EdgeTest::default(); MOST_CONES];
        let mut found = 0;
        let count = update.cones().len();
        let only = match (calm, self.parameters.calm_tests) {
            (false, _) | (true, CalmTests::Each) => None,
            (true, CalmTests::One) => Some(rng.below(count)),
            (true, CalmTests::Off) => return,
        };
        for cone in 0..count {
            let test = update.edge_of(cone, rng.next_f32());
            if only.is_some_and(|only| only != cone) {
                continue;
            }
            let direction = texel.frame.to_world(test.direction);
            let is_lit = direction.dot(texel.normal) > 0.0 && {
                tally.tests += 1;
                self.is_lit(caster, &texel.at, direction, &update.cones()[cone])
            };
            if !is_lit {
                dark[found] = test;
                found += 1;
            }
        }
        if self.restless {
            update.doubt(&dark[..found]);
        }
        update.shrink(&dark[..found]);
    }

    /// Whether a light is seen in a direction.
    fn is_lit(&self, caster: &Caster, at: &Interaction, direction: Vec3, cone: &Cone) -> bool {
        let lights = self.shot.paths.lights();
        let Some(hit) = self
            .shot
            .paths
            .stopped_at(caster, &lights.spawn(at, direction))
        else {
            let mean = luminance(cone.light.into()) / cone.solid_angle();
            let sky = luminance(lights.environment(direction).into());
            return sky > 0.0 && sky >= self.parameters.bright_sky * mean;
        };
        self.shines(&hit)
            && lights.emitted(&self.shot.paths.surfaces().bare(&hit, direction)) != Vec3::ZERO
    }

    /// Whether the shape of a hit emits.
    fn shines(&self, hit: &Hit) -> bool {
        let scene = self.shot.scene;
        let shape = scene.triangle_shape[hit.triangle as usize];
        scene.shapes[shape as usize].emission.is_some()
    }
}

/// A texel that receives light.
struct Receiver<'a> {
    at: Interaction<'a>,
    /// On the texel's side.
    normal: Vec3,
    /// What directions of cones are told in.
    frame: Frame,
}
