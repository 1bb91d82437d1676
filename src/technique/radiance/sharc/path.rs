//! Paths that end where the cache knows the light: followed vertex by vertex, then summed up from their end.

use glam::Vec3;

use super::key::{Grid, Place};
use super::table::{Cell, Sample, Table};
use crate::entry::words;
use crate::image::luminance;
use crate::sample::Rng;
use crate::shade::{Interaction, Leg, Lit, Lobes, Met, Vertex};
use crate::technique::Shot;
use crate::technique::radiance::layers::{GlossVertex, LayerVertex};
use crate::trace::Caster;

words! {
    /// Where camera paths may end on the cache.
    pub enum Query {
        /// Behind the first surface that scatters: a light sample and a scattered leg are taken on it.
        Secondary = "secondary",
        /// On the first surface with a diffuse base as well.
        Primary = "primary",
    }
}

/// Vertices from which on paths end at random, by their throughput.
const ROULETTE_FROM: u32 = 4;
/// Bounds of the chance to go on.
const CHANCES: [f32; 2] = [0.05, 0.95];
/// Luminance of a weight above which what arrives is limited (SHaRC's filter against fireflies).
const HEAVY: f32 = 2.0;

/// How paths end.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    pub query: Query,
    /// Samples that a cell must have.
    pub least_samples: f32,
    /// Whether paths that feed the cache may end on it.
    pub resampling: bool,
    /// Vertices of a feeding path that are stored.
    pub stored: u32,
    /// Whether rare bright samples are limited.
    pub limit: bool,
}

/// What following paths counted.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    pub lookups: u64,
    /// Lookups that found no cell with enough samples.
    pub misses: u64,
    /// Values that were not finite and were left out.
    pub non_finite: u64,
}

impl Tally {
    pub fn add(&mut self, other: &Self) {
        self.lookups += other.lookups;
        self.misses += other.misses;
        self.non_finite += other.non_finite;
    }
}

/// A vertex of a path, or the sky at its end.
#[derive(Clone, Copy, Debug)]
struct Step {
    /// Emission back along the leg.
    emission: Vec3,
    lit: Lit,
    /// Albedo of the base, and light on it without its colour where a cell knew it.
    albedo: Vec3,
    cached: Option<Vec3>,
    /// Of the leg that goes on: weight, and weight of the base without its colour.
    weight: Vec3,
    base: f32,
    /// The cell that what arrives here is stored in.
    stored_in: Option<Place>,
}

impl Step {
    fn shining(emission: Vec3) -> Self {
        Self {
            emission,
            lit: Lit {
                scattered: Vec3::ZERO,
                base: Vec3::ZERO,
            },
            albedo: Vec3::ZERO,
            cached: None,
            weight: Vec3::ZERO,
            base: 0.0,
            stored_in: None,
        }
    }

    /// What the vertex sends back by itself.
    fn source(&self) -> Vec3 {
        self.emission + self.lit.scattered + self.albedo * self.cached.unwrap_or(Vec3::ZERO)
    }
}

/// Whom a path is followed for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Purpose {
    /// The image.
    Show,
    /// The cache; it may end on a cell from this vertex on.
    Feed { resampled_from: u32 },
}

/// Follows paths in one shot.
pub struct Walk<'a> {
    pub shot: &'a Shot<'a>,
    pub grid: Grid,
    pub table: &'a Table,
    pub rule: Rule,
    pub tally: Tally,
    steps: Vec<Step>,
    /// What the camera sees first, without its light.
    first: LayerVertex,
}

impl<'a> Walk<'a> {
    pub fn new(shot: &'a Shot<'a>, grid: Grid, table: &'a Table, rule: Rule) -> Self {
        Self {
            shot,
            grid,
            table,
            rule,
            tally: Tally::default(),
            steps: Vec::new(),
            first: LayerVertex::default(),
        }
    }

    /// What a camera path brings, as the vertex that the camera sees first.
    pub fn shown(&mut self, caster: &Caster, leg: Leg, rng: &mut Rng) -> LayerVertex {
        self.follow(caster, leg, rng, Purpose::Show);
        let Some(first) = self.steps.first() else {
            return LayerVertex::default();
        };
        let behind = arriving(&self.steps[1..]);
        let light = first.cached.unwrap_or(first.lit.base + first.base * behind);
        let mut shown = self.first;
        shown.emission = first.emission;
        if shown.albedo.is_some() {
            shown.base = light;
        }
        if let Some(gloss) = &mut shown.gloss {
            let own = first.lit.scattered - first.albedo * first.lit.base;
            let weight = first.weight - first.albedo * first.base;
            gloss.light = (own + weight * behind).max(Vec3::ZERO);
        }
        let albedo = shown.albedo.unwrap_or(Vec3::ONE);
        let gloss = shown.gloss.map_or(Vec3::ZERO, |gloss| gloss.light);
        if shown.base.is_finite() && (shown.emission + albedo * shown.base + gloss).is_finite() {
            return shown;
        }
        self.tally.non_finite += 1;
        LayerVertex::default()
    }

    /// Follows a path for the cache and adds what arrives at its first vertices to `samples`.
    pub fn feed(&mut self, caster: &Caster, leg: Leg, rng: &mut Rng, samples: &mut Vec<Sample>) {
        // SHaRC: one of the depths 1, 2 and 3, the outer ones half as often.
        let resampled_from = (1.0 + 2.0 * rng.next_f32()).round() as u32;
        self.follow(caster, leg, rng, Purpose::Feed { resampled_from });
        for (i, step) in self.steps.iter().enumerate() {
            let Some(place) = step.stored_in else {
                continue;
            };
            let light = self.light_on(step, &self.steps[i + 1..], self.table.get(place.key));
            if light.is_finite() {
                samples.push(Sample {
                    key: place.key,
                    light,
                });
            } else {
                self.tally.non_finite += 1;
            }
        }
    }

    /// Light on the base of a vertex without the base's colour, of all that lies behind.
    fn light_on(&self, step: &Step, behind: &[Step], before: Option<&Cell>) -> Vec3 {
        let mut light = step.lit.base;
        let mut weight = Vec3::splat(step.base);
        for next in behind {
            let arriving = weight * next.source();
            light += if self.rule.limit {
                limited(arriving, luminance(weight.into()), before)
            } else {
                arriving
            };
            weight *= next.weight;
        }
        light
    }

    /// Follows a path to its end, which leaves its `steps`.
    fn follow(&mut self, caster: &Caster, mut leg: Leg, rng: &mut Rng, purpose: Purpose) {
        self.steps.clear();
        self.first = LayerVertex::default();
        let last = self.shot.scene.max_depth;
        let shot = self.shot;
        let mut spread = Spread(0.0);
        let mut throughput = Vec3::ONE;
        let mut stored = 0;
        for depth in 1..=last {
            let vertex = match shot.paths.meet(caster, leg, rng) {
                Met::Sky { passed, sky } => {
                    if depth == 2 {
                        self.first.segment = shot.scene.diagonal;
                    }
                    self.steps.push(Step::shining(passed + sky));
                    return;
                }
                Met::Surface(vertex) => vertex,
            };
            if depth == 2 {
                self.first.segment = vertex.distance;
            }
            let at = &vertex.at;
            let mut step = Step::shining(vertex.emission);
            let place = self.place(at);
            if depth == 1 {
                self.first = first_seen(&vertex, place.is_some());
            }
            if depth == last {
                self.steps.push(step);
                return;
            }
            if let Some((place, albedo)) = place {
                step.albedo = albedo;
                if self.may_end(depth, &vertex, place, spread, purpose) {
                    step.cached = self.look(place);
                }
                if purpose != Purpose::Show && step.cached.is_none() && stored < self.rule.stored {
                    step.stored_in = Some(place);
                    stored += 1;
                }
            }
            let next = self.scatter(caster, at, depth, &mut step, rng);
            let Some(next) = next else {
                self.steps.push(step);
                return;
            };
            throughput *= step.weight;
            if step.stored_in.is_some() {
                // What is stored is to be known as well on dark surfaces as on bright ones.
                throughput = throughput.max(Vec3::splat(step.base));
            }
            let goes_on = throughput.max_element() > 0.0
                && (depth < ROULETTE_FROM || survives(&mut step, &mut throughput, rng));
            if !goes_on {
                (step.weight, step.base) = (Vec3::ZERO, 0.0);
            }
            self.steps.push(step);
            if !goes_on {
                return;
            }
            spread = spread.after(at, &next);
            leg = next;
        }
    }

    /// Samples a light at a vertex and chooses the leg that goes on. Where a cell knew the light on the base only the
    /// gloss is left, which is followed with its chance, and always where the camera sees it.
    fn scatter(
        &self,
        caster: &Caster,
        at: &Interaction,
        depth: u32,
        step: &mut Step,
        rng: &mut Rng,
    ) -> Option<Leg> {
        let (mut lobes, mut share, mut is_delta) = (Lobes::All, 1.0, at.bsdf.is_delta());
        if step.cached.is_some() {
            (lobes, is_delta) = (Lobes::Gloss, at.bsdf.gloss_is_delta());
            let chance = at.gloss_chance();
            if depth > 1 {
                share = chance;
            }
            if chance == 0.0 || rng.next_f32() >= share {
                return None;
            }
        }
        let paths = &self.shot.paths;
        if !is_delta && let Some(lit) = paths.lit(caster, at, lobes, rng) {
            step.lit.scattered = lit.scattered / share;
            step.lit.base = lit.base;
        }
        let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        let scattered = paths.scattered(at, lobes, u)?;
        step.weight = scattered.weight / share;
        step.base = scattered.base;
        Some(scattered.leg)
    }

    /// The cell of a vertex and the albedo of its diffuse base, if it has one that is not black.
    fn place(&self, at: &Interaction) -> Option<(Place, Vec3)> {
        let albedo = at.bsdf.has_base().then(|| at.base_albedo());
        let albedo = albedo.filter(|albedo| albedo.max_element() > 0.0)?;
        let place = self.grid.place(at.position, at.facing_normal())?;
        Some((place, albedo))
    }

    /// Whether a path may end on the cell of a vertex.
    fn may_end(
        &self,
        depth: u32,
        vertex: &Vertex,
        place: Place,
        spread: Spread,
        purpose: Purpose,
    ) -> bool {
        let reaches = vertex.distance > place.side && spread.covers(vertex.distance, place.side);
        match purpose {
            Purpose::Feed { resampled_from } => {
                self.rule.resampling && depth > resampled_from && reaches
            }
            Purpose::Show if self.rule.query == Query::Primary && self.only_gloss_before() => true,
            Purpose::Show => depth > 1 && reaches,
        }
    }

    /// Whether the path has passed mirrors, glass and metals only.
    fn only_gloss_before(&self) -> bool {
        self.steps.iter().all(|step| step.albedo == Vec3::ZERO)
    }

    fn look(&mut self, place: Place) -> Option<Vec3> {
        self.tally.lookups += 1;
        let cell = self.table.get(place.key);
        let known = cell.filter(|cell| cell.samples >= self.rule.least_samples);
        self.tally.misses += u64::from(known.is_none());
        known.map(|cell| cell.mean)
    }
}

/// What the camera sees first, without its light.
fn first_seen(vertex: &Vertex, has_cell: bool) -> LayerVertex {
    let at = &vertex.at;
    LayerVertex {
        normal: at.facing_normal(),
        path_length: vertex.distance,
        albedo: has_cell.then(|| at.base_albedo()),
        gloss: (!has_cell || at.gloss_chance() > 0.0).then(|| GlossVertex {
            mirror: at.bsdf.is_delta(),
            ..GlossVertex::default()
        }),
        ..LayerVertex::default()
    }
}

/// Radiance that arrives along the leg to the first of these vertices.
fn arriving(steps: &[Step]) -> Vec3 {
    let back = |behind: Vec3, step: &Step| step.source() + step.weight * behind;
    steps.iter().rev().fold(Vec3::ZERO, back)
}

/// Ends a path at random, or makes up for those that end.
fn survives(step: &mut Step, throughput: &mut Vec3, rng: &mut Rng) -> bool {
    let chance = throughput.max_element().clamp(CHANCES[0], CHANCES[1]);
    step.weight /= chance;
    step.base /= chance;
    *throughput /= chance;
    rng.next_f32() < chance
}

/// SHaRC's filter: what arrives with a heavy weight is limited to 5 to 10 times what the cell held before, the more its
/// samples the more; with few samples it is divided by the root of the weight.
fn limited(arriving: Vec3, weight: f32, before: Option<&Cell>) -> Vec3 {
    if weight.is_nan() || weight <= HEAVY {
        return arriving;
    }
    let held = before.map_or(0.0, |cell| luminance(cell.mean.into()));
    match before {
        Some(cell) if cell.samples > 2.0 && held > 0.0 => {
            let confidence = ((cell.samples - 2.0) / 10.0).min(1.0);
            let most = held * (5.0 + 5.0 * confidence);
            let brought = luminance(arriving.into());
            if brought > most {
                arriving * (most / brought)
            } else {
                arriving
            }
        }
        _ => arriving / weight.sqrt(),
    }
}

/// How far directions have spread along a path: the sum of the roughness of its vertices, 1 for diffuse ones.
#[derive(Clone, Copy, Debug)]
struct Spread(f32);

impl Spread {
    /// After a vertex: as rough as the part that sends more in the direction of the leg.
    fn after(self, at: &Interaction, leg: &Leg) -> Self {
        let direction = leg.ray.direction;
        let gloss = luminance(at.evaluate_gloss(direction).into());
        let base = luminance(at.base_albedo().into()) * at.base_share(direction);
        let alpha = if leg.delta {
            0.0
        } else if base > gloss {
            1.0
        } else {
            at.bsdf.gloss_alpha()
        };
        Self(self.0 + alpha)
    }

    /// Whether a lobe spreads over a cell of this side after a leg (SHaRC: `2 t √(½ a² / (1 − a²))`).
    fn covers(self, distance: f32, side: f32) -> bool {
        let squared = self.0 * self.0;
        squared >= 1.0 || 2.0 * distance * (0.5 * squared / (1.0 - squared)).sqrt() > side
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_spread_with_roughness_and_distance() {
        assert!(
            Spread(1.0).covers(0.0, 1.0) && Spread(1.5).covers(0.0, 1.0),
            "diffuse"
        );
        assert!(!Spread(0.0).covers(1e6, 1e-6), "a mirror does not spread");
        // 2 · 10 · √(0.5 · 0.25 / 0.75) = 8.16
        assert!(Spread(0.5).covers(10.0, 8.1) && !Spread(0.5).covers(10.0, 8.2));
    }

    #[test]
    fn heavy_samples_are_limited_by_what_the_cell_held() {
        let bright = Vec3::splat(100.0);
        let cell = |samples| Cell::new(Vec3::ONE, samples);
        let after = |weight, cell: Option<Cell>| limited(bright, weight, cell.as_ref()).x;
        assert_eq!(after(2.0, Some(cell(50.0))), 100.0, "a light weight");
        assert!((after(4.0, Some(cell(50.0))) - 10.0).abs() < 1e-4);
        assert!((after(4.0, Some(cell(7.0))) - 7.5).abs() < 1e-4);
        assert_eq!(after(4.0, Some(cell(2.0))), 50.0, "few samples");
        assert_eq!(after(4.0, None), 50.0);
        let black = Cell::new(Vec3::ZERO, 50.0);
        assert_eq!(
            after(4.0, Some(black)),
            50.0,
            "a black cell can become bright"
        );
    }
}
