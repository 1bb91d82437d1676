//! Records found by position: a grid for each order of magnitude of their radius.

use std::collections::HashMap;

use glam::{IVec3, Vec3};

use super::record::Record;
use crate::entry::words;
use crate::technique::Site;

words! {
    /// How far a record may be used.
    pub enum Metric {
        /// Ward et al. 1988: distance over the harmonic mean distance, plus a term of the normals.
        Ward = "ward",
        /// Tabellion & Lamorlette 2004: the larger of both, falling linearly to 0.
        Tabellion = "tabellion",
    }
}

/// A record with its validity radius.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    pub record: Record,
    /// R: validity distance, scene units.
    pub radius: f32,
    /// Bounds of R, scene units.
    pub limits: [f32; 2],
    /// The shading point it lies at.
    pub point: u32,
}

/// The records of one allowed error.
pub struct Store {
    pub placed: Vec<Placed>,
    metric: Metric,
    /// The allowed error `a`.
    error: f32,
    cells: HashMap<(i32, IVec3), Vec<u32>>,
    levels: Vec<i32>,
}

impl Store {
    pub fn new(metric: Metric, error: f32) -> Self {
        Self {
            placed: Vec::new(),
            metric,
            error,
            cells: HashMap::new(),
            levels: Vec::new(),
        }
    }

    /// The interpolated irradiance at a site; `None` where no record may be used.
    pub fn interpolate(&self, site: &Site) -> Option<Vec3> {
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        self.near(site.position, |placed| {
            let weight = self.weight(placed, site);
            if weight > 0.0 {
                sum += placed.record.extrapolate(site) * weight;
                total += weight;
            }
        });
        (total > 0.0).then(|| sum / total)
    }

    /// Whether any record may be used at a site.
    pub fn covers(&self, site: &Site) -> bool {
        let mut found = false;
        self.near(site.position, |placed| {
            found |= self.weight(placed, site) > 0.0;
        });
        found
    }

    /// Adds a record after limiting its radius by its neighbours' and theirs by it (Křivánek et al.
    /// 2006): radii may differ by no more than the distance between the records.
    pub fn insert(&mut self, mut placed: Placed) {
        let at = placed.record.site.position;
        let mut near = Vec::new();
        self.near_indices(at, |i| near.push(i));
        for &i in &near {
            let other = &self.placed[i as usize];
            let distance = other.record.site.position.distance(at);
            placed.radius = placed.radius.min(other.radius + distance);
        }
        placed.radius = placed.radius.clamp(placed.limits[0], placed.limits[1]);
        for &i in &near {
            let other = &mut self.placed[i as usize];
            let distance = other.record.site.position.distance(at);
            let limited = other.radius.min(placed.radius + distance);
            other.radius = limited.clamp(other.limits[0], other.limits[1]);
        }
        let index = self.placed.len() as u32;
        self.placed.push(placed);
        // A radius only shrinks from here on, so that the cells stay sufficient.
        let reach = placed.radius * self.error;
        let level = reach.max(f32::MIN_POSITIVE).log2().ceil() as i32 + 1;
        if let Err(place) = self.levels.binary_search(&level) {
            self.levels.insert(place, level);
        }
        let (low, high) = (cell(at - reach, level), cell(at + reach, level));
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    let key = (level, IVec3::new(x, y, z));
                    self.cells.entry(key).or_default().push(index);
                }
            }
        }
    }

    /// The weight of a record at a site; 0 where it may not be used: beyond the allowed error, in
    /// front of the record, or on a surface that faces away.
    fn weight(&self, placed: &Placed, site: &Site) -> f32 {
        let own = &placed.record.site;
        let delta = site.position - own.position;
        let cosine = site.normal.dot(own.normal);
        let in_front = delta.dot(site.normal + own.normal) * 0.5;
        if cosine <= 0.0 || in_front < -0.01 * placed.radius {
            return 0.0;
        }
        let turned = (1.0 - cosine).max(0.0).sqrt();
        match self.metric {
            Metric::Ward => {
                let error = delta.length() / placed.radius + turned;
                if error < self.error {
                    // Exactly at the record the limit keeps the weight finite.
                    1.0 / error.max(1e-6)
                } else {
                    0.0
                }
            }
            Metric::Tabellion => {
                /// √(1 − cos 10°)
                const WIDEST: f32 = 0.123_257;
                let far = delta.length() / (0.5 * placed.radius * self.error);
                (1.0 - far.max(turned / WIDEST)).max(0.0)
            }
        }
    }

    fn near(&self, position: Vec3, mut visit: impl FnMut(&Placed)) {
        self.near_indices(position, |i| visit(&self.placed[i as usize]));
    }

    fn near_indices(&self, position: Vec3, mut visit: impl FnMut(u32)) {
        for &level in &self.levels {
            let records = self.cells.get(&(level, cell(position, level)));
            records.into_iter().flatten().for_each(|&i| visit(i));
        }
    }
}

/// The cell of side 2^level around a position.
fn cell(position: Vec3, level: i32) -> IVec3 {
    (position * 2f32.powi(-level)).floor().as_ivec3()
}

impl Record {
    /// Irradiance at a site near the record, by its gradients; at least 0.
    pub fn extrapolate(&self, site: &Site) -> Vec3 {
        let turn = self.site.normal.cross(site.normal);
        let step = site.position - self.site.position;
        let change = self.rotation.transpose() * turn + self.translation.transpose() * step;
        (self.irradiance + change).max(Vec3::ZERO)
    }

    /// Validity distance before clamping: the mean distance (Ward) or the least one (Tabellion),
    /// limited where the gradient says that irradiance would change by more than itself.
    pub fn validity(&self, metric: Metric) -> f32 {
        let distance = match metric {
            Metric::Ward => self.mean_distance,
            Metric::Tabellion => self.least_distance,
        };
        (0..3).fold(distance, |least, c| {
            let slope = self.translation.col(c).length();
            if slope > 0.0 {
                least.min(self.irradiance[c] / slope)
            } else {
                least
            }
        })
    }
}
