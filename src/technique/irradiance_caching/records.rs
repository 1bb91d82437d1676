//! The records: indirect irradiance, and the luminances it was gathered from.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use super::change::{Change, Hemisphere};
use super::gather::{Gathered, Gatherer};
use super::reflected;
use crate::cache::{Extrapolation, Gradient, Neighbour};
use crate::image::luminance;
use crate::technique::{CachedFunction, RecordSite, Seen, Site};
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
    gradient: Option<Extrapolation<Change>>,
}

/// Largest change by the position, of a record's own irradiance.
const LARGEST_CHANGE: f32 = 0.3;

impl<'a> IrradianceRecords<'a> {
    /// No records yet; with a `gradient` they will know how irradiance changes.
    pub fn new(gatherer: Gatherer<'a>, gradient: Option<Gradient>) -> Self {
        let side = gatherer.directions.len().isqrt();
        Self {
            gradient: gradient.map(|rule| Extrapolation::new(rule, Hemisphere::edges(side))),
            gatherer,
            irradiance: Vec::new(),
            normals: Vec::new(),
            luminances: Vec::new(),
            non_finite: AtomicU64::new(0),
            misses: AtomicU64::new(0),
        }
    }

    /// Weighted mean of the records on the viewer's side of the surface; `None` if there are none.
    fn interpolate(&self, site: &Site, (found, weights): (&[Neighbour], &[f32])) -> Option<Vec3> {
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        for (neighbour, weight) in found.iter().zip(weights) {
            let record = neighbour.record;
            if self.normals[record as usize].dot(site.normal) > 0.0 {
                sum += self.value(record, site) * *weight;
                total += weight;
            }
        }
        (total > 0.0).then(|| sum / total)
    }

    /// What a record says of the irradiance at a site.
    fn value(&self, record: u32, of: &Site) -> Vec3 {
        let value = self.irradiance[record as usize];
        let extrapolated = self.gradient.as_ref().and_then(|gradient| {
            let (step, change) = gradient.around(record, (of.position, of.normal))?;
            let most = gradient.rule.clamp.unwrap_or(LARGEST_CHANGE);
            Some(change.extrapolate(value, (step, of.normal), most))
        });
        extrapolated.unwrap_or(value)
    }
}

impl CachedFunction for IrradianceRecords<'_> {
    fn evaluate(&mut self, sites: &[RecordSite], counter: &RayCounter) {
        let gatherer = &self.gatherer;
        let directions = gatherer.directions.len();
        let first = self.irradiance.len();
        let end = first + sites.len();
        self.normals.extend(sites.iter().map(|s| s.site.normal));
        self.luminances.resize(end * directions, f16::ZERO);
        let side = directions.isqrt();
        let edges = self.gradient.as_ref().map(|gradient| &gradient.edges);
        let made: Vec<(Gathered, Change)> = self.luminances[first * directions..]
            .par_chunks_mut(directions)
            .zip(sites)
            .map(|(luminances, record)| {
                let caster = gatherer.frame.tracer.caster(counter);
                let mut hemisphere = edges.map(|_| Hemisphere::new(side));
                let item = [record.pixel, u32::MAX];
                let gathered = gatherer.gather(&caster, (&record.site, item), |i, light, t| {
                    let value = luminance(light.into()).min(f16::MAX.to_f32());
                    luminances[i] = f16::from_f32(value);
                    if let Some(hemisphere) = &mut hemisphere {
                        hemisphere.add((i, gatherer.directions[i]), light, t);
                    }
                });
                let change = edges.zip(hemisphere).map(|(edges, mut hemisphere)| {
                    hemisphere.change(edges, (&record.site, gatherer.frame.scene.diagonal))
                });
                (gathered, change.unwrap_or_default())
            })
            .collect();
        self.irradiance
            .extend(made.iter().map(|(g, _)| g.irradiance));
        let non_finite = made.iter().map(|(g, _)| g.non_finite).sum();
        self.non_finite.fetch_add(non_finite, Ordering::Relaxed);
        if let Some(gradient) = &mut self.gradient {
            for (RecordSite { site, .. }, (_, change)) in sites.iter().zip(made) {
                gradient.add((site.position, site.normal), change);
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

    fn importance(&self, caster: &Caster, of: &RecordSite) -> Vec3 {
        let frame = self.gatherer.frame;
        let seen = frame.look(caster, of.pixel, 0);
        seen.map_or(Vec3::ZERO, |seen| reflected(frame, &seen, Vec3::ONE))
    }

    /// The median of the records' harmonic mean distances; without any, a tenth of the diagonal.
    fn length(&self) -> f32 {
        let changes = self.gradient.iter().flat_map(|g| g.changes());
        let mut lengths: Vec<f32> = changes
            .map(|change| change.mean_distance)
            .filter(|length| length.is_finite() && *length > 0.0)
            .collect();
        if lengths.is_empty() {
            return 0.1 * self.gatherer.frame.scene.diagonal;
        }
        let middle = lengths.len() / 2;
        *lengths.select_nth_unstable_by(middle, f32::total_cmp).1
    }

    fn shade(&self, caster: &Caster, seen: &Seen, found: (&[Neighbour], &[f32])) -> [f32; 3] {
        let irradiance = self.interpolate(&seen.site, found).unwrap_or_else(|| {
            self.misses.fetch_add(1, Ordering::Relaxed);
            let item = [seen.pixel, seen.sample];
            let gathered = self
                .gatherer
                .gather(caster, (&seen.site, item), |_, _, _| ());
            self.non_finite
                .fetch_add(gathered.non_finite, Ordering::Relaxed);
            gathered.irradiance
        });
        reflected(self.gatherer.frame, seen, irradiance).into()
    }

    fn background(&self) -> [f32; 3] {
        [0.0; 3]
    }

    fn bytes(&self) -> usize {
        let extrapolation = self.gradient.as_ref().map_or(0, |g| g.bytes());
        self.irradiance.len() * 24 + self.luminances.len() * 2 + extrapolation
    }

    fn non_finite(&self) -> u64 {
        self.non_finite.load(Ordering::Relaxed)
    }

    fn found(&self) -> Vec<(&'static str, f64)> {
        vec![("misses", self.misses.load(Ordering::Relaxed) as f64)]
    }
}
