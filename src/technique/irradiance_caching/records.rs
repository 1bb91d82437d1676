//! The records: indirect irradiance, and the luminances it was gathered from.

use std::f32::consts::FRAC_1_PI;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{Vec3, Vec4};
use half::f16;
use rayon::prelude::*;

use super::change::{Change, edges};
use super::gather::{Gathered, Gatherer};
use super::panorama::Panoramas;
use super::reflected;
use crate::cache::{Extrapolation, Gradient, Weighted};
use crate::image::luminance;
use crate::technique::{CachedFunction, Seen, Site};
use crate::trace::{Caster, RayCounter};

/// The records of one job.
pub struct IrradianceRecords<'a> {
    gatherer: Gatherer<'a>,
    irradiance: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// One luminance a direction and record, for differences. Half floats: 8 KiB a record.
    luminances: Vec<f16>,
    non_finite: AtomicU64,
    /// Camera samples without a record on their side, which were gathered instead.
    misses: AtomicU64,
    /// For gradient interpolation only.
    directional: Option<Directional>,
}

/// What records of gradient interpolation know besides irradiance.
struct Directional {
    changes: Extrapolation<Change>,
    panoramas: Panoramas,
}

/// What a new record adds to these.
type Known = (Change, Vec<Vec4>);

/// Largest change by the position, of a record's own irradiance.
const LARGEST_CHANGE: f32 = 0.3;

impl<'a> IrradianceRecords<'a> {
    /// No records yet; with a `gradient` they will know how irradiance changes, and light by direction.
    pub fn new(gatherer: Gatherer<'a>, gradient: Option<Gradient>) -> Self {
        let side = gatherer.directions.len().isqrt();
        let diagonal = gatherer.shot.scene.diagonal;
        let panoramas = Panoramas::new(side, diagonal);
        Self {
            directional: gradient.map(|rule| Directional {
                changes: Extrapolation::new(rule, edges(panoramas.width())),
                panoramas,
            }),
            gatherer,
            irradiance: Vec::new(),
            normals: Vec::new(),
            luminances: Vec::new(),
            non_finite: AtomicU64::new(0),
            misses: AtomicU64::new(0),
        }
    }

    /// Weighted mean of what the records on the viewer's side of the surface say; `None` if there are
    /// none.
    fn interpolate(
        &self,
        site: &Site,
        near: Weighted,
        value: impl Fn(u32) -> Vec3,
    ) -> Option<Vec3> {
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        for (record, weight) in near.iter() {
            if self.normals[record as usize].dot(site.normal) > 0.0 {
                sum += value(record) * weight;
                total += weight;
            }
        }
        (total > 0.0).then(|| sum / total)
    }

    /// What a record says of the irradiance at a site.
    fn value(&self, record: u32, of: &Site) -> Vec3 {
        let value = self.irradiance[record as usize];
        let extrapolated = self.directional.as_ref().and_then(|known| {
            let (step, change) = known.changes.around(record, of.position, of.normal)?;
            let most = known.changes.rule.clamp.unwrap_or(LARGEST_CHANGE);
            Some(change.extrapolate(value, step, of.normal, most))
        });
        extrapolated.unwrap_or(value)
    }

    /// Light reflected to the viewer where records know it by direction: diffuse parts see the
    /// irradiance, each direction of gloss what the records see there.
    fn directional(
        &self,
        known: &Directional,
        seen: &Seen,
        irradiance: Vec3,
        near: Weighted,
    ) -> Vec3 {
        let at = self.gatherer.shot.surface(seen);
        let mut light = at.base_albedo() * irradiance * FRAC_1_PI;
        for (direction, weight) in at.reflections() {
            let radiance = self.interpolate(&seen.site, near, |record| {
                let step = seen.site.position - known.changes.position(record);
                let mean = self.irradiance[record as usize] * FRAC_1_PI;
                known.panoramas.radiance(record, step, direction, mean)
            });
            light += weight * radiance.unwrap_or_default();
        }
        seen.throughput * light
    }
}

impl CachedFunction for IrradianceRecords<'_> {
    fn evaluate(&mut self, sites: &[Seen], counter: &RayCounter) {
        let gatherer = &self.gatherer;
        let directions = gatherer.directions.len();
        let first = self.irradiance.len();
        let end = first + sites.len();
        self.normals.extend(sites.iter().map(|s| s.site.normal));
        // Room for these and no more: rounds are few, and what is kept is charged.
        self.luminances.reserve_exact(sites.len() * directions);
        self.luminances.resize(end * directions, f16::ZERO);
        let directional = self.directional.as_ref();
        let made: Vec<(Gathered, Option<Known>)> = self.luminances[first * directions..]
            .par_chunks_mut(directions)
            .zip(sites)
            .map(|(luminances, record)| {
                let caster = gatherer.shot.tracer.caster(counter);
                let mut seen = Vec::new();
                let item = [record.pixel, u32::MAX];
                let gathered = gatherer.gather(&caster, &record.site, item, |i, light, t| {
                    let value = luminance(light.into()).min(f16::MAX.to_f32());
                    luminances[i] = f16::from_f32(value);
                    if directional.is_some() {
                        seen.push((light, t));
                    }
                });
                let known = directional.map(|known| {
                    let (panoramas, edges) = (&known.panoramas, &known.changes.edges);
                    let blocks = panoramas.pool(&seen);
                    let change = Change::new(
                        gatherer.directions,
                        &seen,
                        &blocks,
                        panoramas.width(),
                        edges,
                        record.site.normal,
                    );
                    (change, blocks)
                });
                (gathered, known)
            })
            .collect();
        self.irradiance
            .extend(made.iter().map(|(g, _)| g.irradiance));
        let non_finite = made.iter().map(|(g, _)| g.non_finite).sum();
        self.non_finite.fetch_add(non_finite, Ordering::Relaxed);
        if let Some(known) = &mut self.directional {
            known.changes.make_room(sites.len());
            known.panoramas.make_room(sites.len());
            for (Seen { site, .. }, (_, made)) in sites.iter().zip(made) {
                let (change, blocks) = made.expect("made of every record");
                known.changes.add(site.position, site.normal, change);
                known.panoramas.add(site.normal, &blocks);
            }
        }
    }

    fn difference(&self, a: u32, b: u32) -> f32 {
        let directions = self.gatherer.directions.len();
        let samples = |i: u32| &self.luminances[i as usize * directions..][..directions];
        samples(a)
            .iter()
            .zip(samples(b))
            .map(|(x, y)| (x.to_f32() - y.to_f32()).abs())
            .sum()
    }

    fn predict(&self, record: u32, of: &Site) -> (Vec3, f32) {
        (self.value(record, of), 1.0)
    }

    fn importance(&self, of: &Seen) -> Vec3 {
        reflected(self.gatherer.shot, of, Vec3::ONE)
    }

    /// The median of the records' harmonic mean distances; without any, a tenth of the diagonal.
    fn length(&self) -> f32 {
        let known = self.directional.iter();
        let changes = known.flat_map(|known| known.changes.changes());
        let mut lengths: Vec<f32> = changes
            .map(|change| change.mean_distance)
            .filter(|length| length.is_finite() && *length > 0.0)
            .collect();
        if lengths.is_empty() {
            return 0.1 * self.gatherer.shot.scene.diagonal;
        }
        let middle = lengths.len() / 2;
        *lengths.select_nth_unstable_by(middle, f32::total_cmp).1
    }

    fn shade(&self, _: &Caster, seen: &Seen, near: Weighted) -> Option<[f32; 3]> {
        let value = |record| self.value(record, &seen.site);
        let irradiance = self.interpolate(&seen.site, near, value)?;
        let light = match &self.directional {
            Some(known) => self.directional(known, seen, irradiance, near),
            None => reflected(self.gatherer.shot, seen, irradiance),
        };
        Some(light.into())
    }

    /// A record of the sample's own.
    fn shade_missed(&self, caster: &Caster, seen: &Seen) -> [f32; 3] {
        self.misses.fetch_add(1, Ordering::Relaxed);
        let item = [seen.pixel, seen.sample];
        let gathered = self.gatherer.gather(caster, &seen.site, item, |_, _, _| ());
        let non_finite = gathered.non_finite;
        self.non_finite.fetch_add(non_finite, Ordering::Relaxed);
        reflected(self.gatherer.shot, seen, gathered.irradiance).into()
    }

    fn background(&self) -> [f32; 3] {
        [0.0; 3]
    }

    fn non_finite(&self) -> u64 {
        self.non_finite.load(Ordering::Relaxed)
    }

    fn found(&self) -> Vec<(&'static str, f64)> {
        vec![("misses", self.misses.load(Ordering::Relaxed) as f64)]
    }
}
