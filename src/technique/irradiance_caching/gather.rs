//! Indirect irradiance at one point: path-traced radiance over the hemisphere.

use glam::{DVec3, Vec3};

use crate::sample::{Frame as LocalFrame, Rng};
use crate::shade::Depths;
use crate::technique::{Frame, Site};
use crate::trace::{Caster, Ray, offset_origin};

/// Keys the paths of records.
const STREAM: u64 = 0x6972_7261_6469;

/// Traces the gathering rays of records.
pub struct Gatherer<'a> {
    pub frame: &'a Frame<'a>,
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
        (site, item): (&Site, [u32; 2]),
        mut sample: impl FnMut(usize, Vec3, f32),
    ) -> Gathered {
        let local = LocalFrame::from_normal(site.normal);
        let item = u64::from(item[0]) << 32 | u64::from(item[1]);
        let mut sum = DVec3::ZERO;
        let mut non_finite = 0;
        for (i, direction) in self.directions.iter().enumerate() {
            let mut rng = Rng::new(self.seed, STREAM, item, i as u64);
            let ray = leaving_ray(self.frame, site, local.to_world(*direction));
            let paths = &self.frame.paths;
            let (radiance, distance) = paths.gather(caster, ray, &mut rng, self.depths);
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

/// A ray that leaves a site on the side it points to, as a path's does.
pub fn leaving_ray(frame: &Frame, site: &Site, direction: Vec3) -> Ray {
    let side = if direction.dot(site.geometric_normal) < 0.0 {
        -site.geometric_normal
    } else {
        site.geometric_normal
    };
    let origin = offset_origin(site.position, side, frame.scene.diagonal);
    Ray::new(origin, direction)
}
