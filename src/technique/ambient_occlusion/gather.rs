//! The rays of one record or reference sample.

use glam::Vec3;

use crate::sample::{Frame as LocalFrame, HemisphereEdges, is_set};
use crate::technique::Site;
use crate::trace::{Caster, Hit, offset_origin};

/// Traces the rays of one record or reference sample.
pub struct Gatherer<'a> {
    /// Equal-area grid over the hemisphere about +z, row by row.
    pub directions: &'a [Vec3],
    /// Maximum length of occlusion rays, scene units.
    pub distance: f32,
    pub diagonal: f32,
}

/// Buffers that a thread keeps between records.
pub struct Scratch {
    world: Vec<Vec3>,
    /// A bit for each direction.
    pub occluded: Vec<u64>,
    /// Blocked directions beside open ones, and what their rays hit.
    outline: Vec<u32>,
    outline_world: Vec<Vec3>,
    hits: Vec<Option<Hit>>,
    /// The same directions with 1/t.
    measured: Vec<(u32, f32)>,
}

impl Scratch {
    pub fn new(directions: usize) -> Self {
        Self {
            world: vec![Vec3::ZERO; directions],
            occluded: vec![0; directions.div_ceil(64)],
            outline: Vec::new(),
            outline_world: Vec::new(),
            hits: Vec::new(),
            measured: Vec::new(),
        }
    }
}

/// How ambient occlusion changes around a record, world space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// `(2/S) Σ V ω`: its cosine with a normal is the value that a turned surface sees.
    pub bent: Vec3,
    /// By translation, per scene unit.
    pub gradient: Vec3,
    /// How far the record is to be believed, 0 to 1: `1 / (1 + d Σ 1/t / S)` with t the distances of
    /// what lies at the edges of openings and d the length of the rays.
    pub trust: f32,
}

impl Gatherer<'_> {
    /// Ambient occlusion at a site; leaves the occlusion bits in `scratch`.
    pub fn gather(&self, caster: &Caster, site: &Site, scratch: &mut Scratch) -> f32 {
        let origin = self.aim(site, &mut scratch.world);
        caster.occluded_bundle(origin, &scratch.world, self.distance, &mut scratch.occluded);
        let mut open = 0.0;
        for (i, local) in self.directions.iter().enumerate() {
            if !is_set(&scratch.occluded, i) {
                open += local.z;
            }
        }
        (open * 2.0 / self.directions.len() as f32).min(1.0)
    }

    /// As [`Gatherer::gather`], and how the value changes around the site. Only what lies at the edge
    /// of an opening moves across it, so closest hits are asked for in those directions alone.
    pub fn gather_change(
        &self,
        caster: &Caster,
        site: &Site,
        edges: &HemisphereEdges,
        scratch: &mut Scratch,
    ) -> (f32, Change) {
        let count = self.directions.len();
        let origin = self.aim(site, &mut scratch.world);
        caster.occluded_bundle(origin, &scratch.world, self.distance, &mut scratch.occluded);
        let mut bent = Vec3::ZERO;
        for (i, local) in self.directions.iter().enumerate() {
            let open = !is_set(&scratch.occluded, i);
            bent += *local * f32::from(u8::from(open));
        }
        let bent = bent * (2.0 / count as f32);
        self.measure_outline(caster, origin, edges, scratch);
        let nearness: f32 = scratch.measured.iter().map(|(_, nearness)| nearness).sum();
        let gradient = edges.gradient_of_outline(&scratch.occluded, &scratch.measured);
        let shot = LocalFrame::from_normal(site.normal);
        let change = Change {
            bent: shot.to_world(bent),
            gradient: shot.to_world(gradient * std::f32::consts::FRAC_1_PI),
            trust: 1.0 / (1.0 + self.distance * nearness / count as f32),
        };
        (bent.z.min(1.0), change)
    }

    /// Leaves in `scratch.measured` how near the blocked directions are that lie beside open ones.
    fn measure_outline(
        &self,
        caster: &Caster,
        origin: Vec3,
        edges: &HemisphereEdges,
        scratch: &mut Scratch,
    ) {
        edges.outline(&scratch.occluded, &mut scratch.outline);
        let directions = scratch.outline.iter().map(|&i| scratch.world[i as usize]);
        scratch.outline_world.clear();
        scratch.outline_world.extend(directions);
        scratch.hits.resize(scratch.outline.len(), None);
        let hits = &mut scratch.hits;
        caster.closest_bundle(origin, &scratch.outline_world, self.distance, hits);
        // A hit nearer than this is as near: distances are divided by.
        let least = self.diagonal * 1e-6;
        let nearness = |hit: &Option<Hit>| hit.map_or(0.0, |hit| 1.0 / hit.t.max(least));
        let measured = scratch.outline.iter().copied();
        scratch.measured.clear();
        scratch
            .measured
            .extend(measured.zip(scratch.hits.iter().map(nearness)));
    }

    /// World-space directions of a site's rays, and their origin.
    fn aim(&self, site: &Site, world: &mut [Vec3]) -> Vec3 {
        let shot = LocalFrame::from_normal(site.normal);
        for (world, &local) in world.iter_mut().zip(self.directions) {
            *world = shot.to_world(local);
        }
        offset_origin(site.position, site.geometric_normal, self.diagonal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::equal_area_hemisphere;
    use crate::trace::{RayCounter, Tracer};

    const SIDE: usize = 64;

    /// A floor at z = 0 and a wall of height 0.6 over it at x = 1.
    fn wall() -> Tracer {
        let positions = [
            Vec3::new(-9.0, -9.0, 0.0),
            Vec3::new(9.0, -9.0, 0.0),
            Vec3::new(9.0, 9.0, 0.0),
            Vec3::new(-9.0, 9.0, 0.0),
            Vec3::new(1.0, -9.0, 0.0),
            Vec3::new(1.0, 9.0, 0.0),
            Vec3::new(1.0, 9.0, 0.6),
            Vec3::new(1.0, -9.0, 0.6),
        ];
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        Tracer::new(&positions, &triangles)
    }

    fn at(x: f32, normal: Vec3) -> Site {
        Site {
            position: Vec3::new(x, 0.1, 0.0),
            normal: normal.normalize(),
            geometric_normal: Vec3::Z,
        }
    }

    #[test]
    fn the_outline_of_what_is_blocked_tells_how_the_value_changes() {
        let (tracer, counter) = (wall(), RayCounter::default());
        let caster = tracer.caster(&counter);
        let directions = equal_area_hemisphere(SIDE);
        let gatherer = Gatherer {
            directions: &directions,
            distance: 20.0,
            diagonal: 18.0,
        };
        let edges = HemisphereEdges::new(SIDE);
        let mut scratch = Scratch::new(directions.len());
        let site = at(0.3, Vec3::Z);
        let value = gatherer.gather(&caster, &site, &mut scratch);
        let bits = scratch.occluded.clone();
        let (same, change) = gatherer.gather_change(&caster, &site, &edges, &mut scratch);
        assert!((value - same).abs() < 1e-6 && bits == scratch.occluded);
        assert!((change.bent.dot(site.normal) - value).abs() < 1e-5);

        let mut value_at = |site: Site| gatherer.gather(&caster, &site, &mut scratch);
        let step = 0.1;
        let ahead = value_at(at(0.3 + step, Vec3::Z));
        let behind = value_at(at(0.3 - step, Vec3::Z));
        let slope = (ahead - behind) / (2.0 * step);
        assert!(
            (change.gradient.x - slope).abs() < 0.15 * slope.abs(),
            "{change:?} instead of {slope}"
        );
        // Turned towards the wall. Its lower hemisphere is the floor, which a record does not see.
        let turned = Vec3::new(0.1, 0.0, 1.0).normalize();
        let expected = value_at(at(0.3, turned)) - value;
        let said = change.bent.dot(turned) - value;
        assert!(
            (said - expected).abs() < 0.03,
            "{said} instead of {expected}"
        );
    }
}
