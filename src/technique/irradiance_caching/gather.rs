//! Indirect irradiance at one point: path-traced radiance over the hemisphere.

use glam::{DVec3, Vec3};

use crate::sample::{Frame as LocalFrame, Rng};
use crate::shade::Depths;
use crate::technique::{Shot, Site};
use crate::trace::{Caster, Hit, Ray, offset_origin};

/// Keys the paths of records.
const STREAM: u64 = 0x6972_7261_6469;

/// Traces the gathering rays of records.
pub struct Gatherer<'a> {
    pub shot: &'a Shot<'a>,
    /// Equal-area grid over the hemisphere about +z.
    pub directions: &'a [Vec3],
    /// Paths from the record's surface on.
    pub depths: Depths,
    pub seed: u64,
}

/// What one record gathered.
pub struct Gathered {
    /// `(2π/S) Σ L cos θ`, linear RGB.
    pub irradiance: Vec3,
    /// Radiances that were not finite and count as 0.
    pub non_finite: u64,
}

impl Gatherer<'_> {
    /// Gathers at a site. `item` keys the paths (pixel and sample); `sample` is told the index of
    /// each direction, its radiance and the distance that its ray travelled (infinite if nothing is hit).
    pub fn gather(
        &self,
        caster: &Caster,
        site: &Site,
        item: [u32; 2],
        mut sample: impl FnMut(usize, Vec3, f32),
    ) -> Gathered {
        let local = LocalFrame::from_normal(site.normal);
        let directions: Vec<Vec3> = self.directions.iter().map(|d| local.to_world(*d)).collect();
        let rays = cast(self.shot, caster, site, &directions);
        let item = u64::from(item[0]) << 32 | u64::from(item[1]);
        let mut sum = DVec3::ZERO;
        let mut non_finite = 0;
        for (i, ((ray, hit), direction)) in rays.into_iter().zip(self.directions).enumerate() {
            let mut rng = Rng::new(self.seed, STREAM, item, i as u64);
            let distance = travelled(&hit);
            let paths = &self.shot.paths;
            let radiance = paths.follow(caster, ray, hit, &mut rng, self.depths);
            if radiance.is_finite() {
                sum += radiance.as_dvec3() * f64::from(direction.z);
                sample(i, radiance, distance);
            } else {
                non_finite += 1;
                sample(i, Vec3::ZERO, distance);
            }
        }
        let scale = std::f64::consts::TAU / self.directions.len() as f64;
        Gathered {
            irradiance: (sum * scale).as_vec3(),
            non_finite,
        }
    }
}

/// Rays that leave a site in the given directions, each on the side it points to as a path's does, and what they meet
/// first. Those of a side share their origin and are cast together.
pub fn cast(
    shot: &Shot,
    caster: &Caster,
    site: &Site,
    directions: &[Vec3],
) -> Vec<(Ray, Option<Hit>)> {
    let is_behind = |direction: &Vec3| direction.dot(site.geometric_normal) < 0.0;
    let mut cast = vec![(Ray::new(Vec3::ZERO, Vec3::ZERO), None); directions.len()];
    for behind in [false, true] {
        let side = if behind {
            -site.geometric_normal
        } else {
            site.geometric_normal
        };
        let origin = offset_origin(site.position, side, shot.scene.diagonal);
        let (places, ways): (Vec<usize>, Vec<Vec3>) = directions
            .iter()
            .enumerate()
            .filter(|(_, direction)| is_behind(direction) == behind)
            .unzip();
        let mut hits = vec![None; ways.len()];
        caster.closest_bundle(origin, &ways, f32::INFINITY, &mut hits);
        for ((place, way), hit) in places.into_iter().zip(ways).zip(hits) {
            cast[place] = (Ray::new(origin, way), hit);
        }
    }
    cast
}

/// The distance that a ray travelled, infinite if it met nothing.
pub fn travelled(hit: &Option<Hit>) -> f32 {
    hit.map_or(f32::INFINITY, |hit| hit.t)
}
