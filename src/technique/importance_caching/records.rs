//! Records: what every light sends to them, and how they choose lights for a camera sample.

use glam::Vec3;
use rayon::prelude::*;

use super::distributions::{Distributions, RecordMut, STORED};
use super::estimator::Rule;
use crate::cache::{Neighbour, RecordSearch, SearchRule, Weighted};
use crate::image::luminance;
use crate::sample::Rng;
use crate::shade::{Gathering, Neighbourhood, Receiver, VirtualLights};
use crate::technique::{CachedFunction, Lookup, Seen, Shot, Site};
use crate::trace::{Caster, RayCounter};

/// Keys the choice of lights at camera samples.
const STREAM: u64 = 0x696d_6361_6368;

/// The records of one job.
pub struct ImportanceRecords<'a> {
    shot: &'a Shot<'a>,
    pub(super) lights: VirtualLights<'a>,
    pub(super) table: Distributions,
    pub(super) settings: Settings,
    pub(super) positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

/// What records of a job have in common.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    pub rule: Rule,
    pub lookup: Lookup,
    /// See [`super::Parameters::bound_radius`].
    pub bound_radius: f32,
    /// Keys the choice of lights.
    pub seed: u64,
}

/// Buffers that a thread keeps between records: luminances of each light by distribution.
struct Scratch {
    values: [Vec<f32>; STORED],
    gathering: Gathering,
}

impl<'a> ImportanceRecords<'a> {
    pub fn new(shot: &'a Shot<'a>, lights: VirtualLights<'a>, settings: Settings) -> Self {
        Self {
            shot,
            table: Distributions::new(lights.len()),
            lights,
            settings,
            positions: Vec::new(),
            normals: Vec::new(),
        }
    }

    /// Radius of the ball that the bound of a record covers: a share of the distance of its M-th
    /// nearest record by position, and the diagonal where there is none.
    fn radii(&self, first: usize) -> Vec<f32> {
        let (positions, normals) = (&self.positions, &self.normals);
        let rule = SearchRule::spatial(self.settings.lookup.used + 1);
        let search = RecordSearch::new(positions, normals, rule);
        let radius = |_, found: &[Neighbour]| match found {
            [] | [_] => self.shot.scene.diagonal,
            [.., last] => last.distance * self.settings.bound_radius,
        };
        search.map(&positions[first..], &normals[first..], radius)
    }

    fn fill(
        &self,
        caster: &Caster,
        mut record: RecordMut,
        site: &Seen,
        radius: f32,
        scratch: &mut Scratch,
    ) {
        let to = receiver(self.shot, site);
        let [full, unoccluded, bounded] = &mut scratch.values;
        full.fill(0.0);
        unoccluded.fill(0.0);
        let mut visit = |light: usize, value: Vec3, visible: bool| {
            let value = luminance(value.into());
            unoccluded[light] = value;
            full[light] = if visible { value } else { 0.0 };
        };
        self.lights
            .each(caster, &to, &mut scratch.gathering, &mut visit);
        let turn = self.settings.lookup.max_angle_deg.to_radians();
        let near = Neighbourhood {
            radius,
            turn: [turn.cos(), turn.sin()],
        };
        for (light, value) in bounded.iter_mut().enumerate() {
            *value = luminance(self.lights.bounded(&to, light, &near).into());
        }
        for (kind, values) in scratch.values.iter().enumerate() {
            record.set(kind, values);
        }
    }
}

/// A camera sample as a receiver of light.
pub fn receiver<'a>(shot: &'a Shot, seen: &Seen) -> Receiver<'a> {
    Receiver::new(shot.surface(seen), shot.scene.diagonal)
}

impl CachedFunction for ImportanceRecords<'_> {
    fn evaluate(&mut self, sites: &[Seen], counter: &RayCounter) {
        let first = self.positions.len();
        self.positions.extend(sites.iter().map(|s| s.site.position));
        self.normals.extend(sites.iter().map(|s| s.site.normal));
        let radii = self.radii(first);
        // The table is filled in place while the rest of the records is read.
        let mut table = std::mem::replace(&mut self.table, Distributions::new(0));
        let lights = self.lights.len();
        let this = &*self;
        table
            .append(sites.len())
            .into_par_iter()
            .zip(sites.par_iter().zip(&radii))
            .with_min_len(4)
            .for_each_init(
                || {
                    let scratch = Scratch {
                        values: std::array::from_fn(|_| vec![0.0; lights]),
                        gathering: Gathering::default(),
                    };
                    (this.shot.tracer.caster(counter), scratch)
                },
                |(caster, scratch), (record, (site, &radius))| {
                    this.fill(caster, record, site, radius, scratch);
                },
            );
        self.table = table;
    }

    fn difference(&self, a: u32, b: u32) -> f32 {
        self.table.difference(a, b)
    }

    /// The light of all lights at the record itself, as luminance.
    fn predict(&self, record: u32, _: &Site) -> (Vec3, f32) {
        (Vec3::splat(self.table.total(record)), 1.0)
    }

    fn length(&self) -> f32 {
        self.shot.scene.diagonal
    }

    fn shade(&self, caster: &Caster, seen: &Seen, found: Weighted) -> Option<[f32; 3]> {
        let to = receiver(self.shot, seen);
        let mut sum = self.shot.paths.lights().emitted(&to.at);
        let mut near = [0u32; 32];
        let near = &mut near[..found.neighbours.len()];
        for (record, neighbour) in near.iter_mut().zip(found.neighbours) {
            *record = neighbour.record;
        }
        let (pixel, sample) = (u64::from(seen.pixel), u64::from(seen.sample));
        let mut rng = Rng::new(self.settings.seed, STREAM, pixel, sample);
        for choice in self.settings.rule.choose(&self.table, near, &mut rng) {
            if choice.factor == 0.0 {
                continue;
            }
            let light = choice.light as usize;
            let value = self.lights.unoccluded(&to, light);
            if value != Vec3::ZERO && !self.lights.occluded(caster, &to, light) {
                sum += value * choice.factor;
            }
        }
        Some((sum * seen.throughput).into())
    }

    /// Black: the environment is added afterwards, see [`super::exact::add_background`].
    fn background(&self) -> [f32; 3] {
        [0.0; 3]
    }
}
