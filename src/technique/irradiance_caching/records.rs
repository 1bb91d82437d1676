//! The records: indirect irradiance, and the luminances it was gathered from.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use super::gather::Gatherer;
use super::reflected;
use crate::cache::Neighbour;
use crate::technique::{CachedFunction, RecordSite, Seen};
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
}

impl<'a> IrradianceRecords<'a> {
    pub fn new(gatherer: Gatherer<'a>) -> Self {
        Self {
            gatherer,
            irradiance: Vec::new(),
            normals: Vec::new(),
            luminances: Vec::new(),
            non_finite: AtomicU64::new(0),
            misses: AtomicU64::new(0),
        }
    }

    /// Weighted mean of the records on the viewer's side of the surface; `None` if there are none.
    fn interpolate(&self, normal: Vec3, (found, weights): (&[Neighbour], &[f32])) -> Option<Vec3> {
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        for (neighbour, weight) in found.iter().zip(weights) {
            let record = neighbour.record as usize;
            if self.normals[record].dot(normal) > 0.0 {
                sum += self.irradiance[record] * *weight;
                total += weight;
            }
        }
        (total > 0.0).then(|| sum / total)
    }
}

impl CachedFunction for IrradianceRecords<'_> {
    fn evaluate(&mut self, sites: &[RecordSite], counter: &RayCounter) {
        let gatherer = &self.gatherer;
        let directions = gatherer.directions.len();
        let first = self.irradiance.len();
        let end = first + sites.len();
        self.normals.extend(sites.iter().map(|s| s.site.normal));
        self.irradiance.resize(end, Vec3::ZERO);
        self.luminances.resize(end * directions, f16::ZERO);
        let non_finite: u64 = self.irradiance[first..]
            .par_iter_mut()
            .zip(self.luminances[first * directions..].par_chunks_mut(directions))
            .zip(sites)
            .map(|((irradiance, luminances), record)| {
                let caster = gatherer.frame.tracer.caster(counter);
                let item = [record.pixel, u32::MAX];
                let keep = |i: usize, value: f32| {
                    luminances[i] = f16::from_f32(value.min(f16::MAX.to_f32()));
                };
                let gathered = gatherer.gather(&caster, (&record.site, item), keep);
                *irradiance = gathered.irradiance;
                gathered.non_finite
            })
            .sum();
        self.non_finite.fetch_add(non_finite, Ordering::Relaxed);
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

    fn shade(&self, caster: &Caster, seen: &Seen, found: (&[Neighbour], &[f32])) -> [f32; 3] {
        let irradiance = self
            .interpolate(seen.site.normal, found)
            .unwrap_or_else(|| {
                self.misses.fetch_add(1, Ordering::Relaxed);
                let item = [seen.pixel, seen.sample];
                let gathered = self.gatherer.gather(caster, (&seen.site, item), |_, _| ());
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
        self.irradiance.len() * 24 + self.luminances.len() * 2
    }

    fn non_finite(&self) -> u64 {
        self.non_finite.load(Ordering::Relaxed)
    }

    fn found(&self) -> Vec<(&'static str, f64)> {
        vec![("misses", self.misses.load(Ordering::Relaxed) as f64)]
    }
}
