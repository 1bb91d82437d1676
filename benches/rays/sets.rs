//! Sets of rays and the ways to cast them.

use glam::Vec3;
use lightbench::sample::{Frame, Rng, equal_area_hemisphere};
use lightbench::trace::{Caster, Hit, Ray, RayCounter, Tracer, offset_origin};

use super::Scene;

/// Side of the direction grid of a record.
const SIDE: usize = 32;
const RECORDS: usize = 160;
/// Most directions of one bundle.
const MOST: usize = SIDE * SIDE;

/// Rays of one kind.
pub struct Set {
    pub name: &'static str,
    pub work: Work,
}

pub enum Work {
    Closest(Vec<Ray>),
    Occluded(Vec<Ray>),
    BundlesClosest(Vec<Bundle>),
    BundlesOccluded(Vec<Bundle>, f32),
}

/// Rays of one origin.
pub struct Bundle {
    pub origin: Vec3,
    pub directions: Vec<Vec3>,
}

impl Work {
    pub fn rays(&self) -> usize {
        match self {
            Self::Closest(rays) | Self::Occluded(rays) => rays.len(),
            Self::BundlesClosest(bundles) | Self::BundlesOccluded(bundles, _) => {
                bundles.iter().map(|b| b.directions.len()).sum()
            }
        }
    }

    pub fn has_bundles(&self) -> bool {
        matches!(self, Self::BundlesClosest(_) | Self::BundlesOccluded(..))
    }

    pub fn is_any_hit(&self) -> bool {
        matches!(self, Self::Occluded(_) | Self::BundlesOccluded(..))
    }

    /// Casts everything, with or without bundle queries, and returns the number of hits.
    pub fn cast(&self, caster: &Caster, bundled: bool) -> usize {
        match self {
            Self::Closest(rays) => rays.iter().filter(|r| caster.closest(r).is_some()).count(),
            Self::Occluded(rays) => rays.iter().filter(|r| caster.occluded(r)).count(),
            Self::BundlesClosest(bundles) if bundled => {
                let mut hits: [Option<Hit>; MOST] = [None; MOST];
                let cast = |b: &Bundle| {
                    let hits = &mut hits[..b.directions.len()];
                    caster.closest_bundle(b.origin, &b.directions, f32::INFINITY, hits);
                    hits.iter().flatten().count()
                };
                bundles.iter().map(cast).sum()
            }
            Self::BundlesOccluded(bundles, t_max) if bundled => {
                let mut bits = [0u64; MOST / 64];
                let cast = |b: &Bundle| {
                    caster.occluded_bundle(b.origin, &b.directions, *t_max, &mut bits);
                    bits.iter().map(|b| b.count_ones() as usize).sum::<usize>()
                };
                bundles.iter().map(cast).sum()
            }
            Self::BundlesClosest(bundles) => rays_of(bundles, f32::INFINITY)
                .filter(|r| caster.closest(r).is_some())
                .count(),
            Self::BundlesOccluded(bundles, t_max) => rays_of(bundles, *t_max)
                .filter(|r| caster.occluded(r))
                .count(),
        }
    }

    /// All rays one by one.
    pub fn singles(&self) -> Vec<Ray> {
        match self {
            Self::Closest(rays) | Self::Occluded(rays) => rays.clone(),
            Self::BundlesClosest(bundles) => rays_of(bundles, f32::INFINITY).collect(),
            Self::BundlesOccluded(bundles, t_max) => rays_of(bundles, *t_max).collect(),
        }
    }
}

fn rays_of(bundles: &[Bundle], t_max: f32) -> impl Iterator<Item = Ray> {
    bundles.iter().flat_map(move |b| {
        b.directions.iter().map(move |&direction| Ray {
            t_max,
            ..Ray::new(b.origin, direction)
        })
    })
}

/// Camera rays in tiles of 8×8; from the surfaces they find, one ray each in a random direction, and
/// the whole hemispheres of some.
pub fn ray_sets(scene: &Scene, tracer: &Tracer) -> Vec<Set> {
    let (low, high) = scene
        .positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| {
            (low.min(p), high.max(p))
        });
    let diagonal = (high - low).length();
    let near = 0.1 * diagonal;
    let primary = primary_tiles(scene);
    let points = surface_points(scene, tracer, &primary, diagonal);
    let grid = equal_area_hemisphere(SIDE);
    let mut rng = Rng::new(1, 2, 3, 4);
    let scattered: Vec<Ray> = points
        .iter()
        .map(|(origin, frame)| Ray::new(*origin, frame.to_world(grid[rng.below(MOST)])))
        .collect();
    let limited = |ray: &Ray| Ray {
        t_max: near,
        ..*ray
    };
    let records = || -> Vec<Bundle> {
        let step = (points.len() / RECORDS).max(1);
        let record = |(origin, frame): &(Vec3, Frame)| Bundle {
            origin: *origin,
            directions: grid.iter().map(|&d| frame.to_world(d)).collect(),
        };
        points.iter().step_by(step).map(record).collect()
    };
    let set = |name, work| Set { name, work };
    vec![
        set("camera, closest", Work::BundlesClosest(primary)),
        set("bounce, closest", Work::Closest(scattered.clone())),
        set(
            "bounce, any, 0.1 D",
            Work::Occluded(scattered.iter().map(limited).collect()),
        ),
        set("bounce, any", Work::Occluded(scattered)),
        set("record, closest", Work::BundlesClosest(records())),
        set("record, any, 0.1 D", Work::BundlesOccluded(records(), near)),
        set(
            "record, any",
            Work::BundlesOccluded(records(), f32::INFINITY),
        ),
    ]
}

fn primary_tiles(scene: &Scene) -> Vec<Bundle> {
    const TILE: usize = 8;
    let (width, height) = (400, 304);
    let frame = Frame::from_normal((scene.look_at - scene.eye).normalize());
    let direction = |x: usize, y: usize| {
        let x = x as f32 / width as f32 - 0.5;
        let y = y as f32 / width as f32 - 0.375;
        frame.to_world(Vec3::new(x, y, 0.8).normalize())
    };
    let across = width / TILE;
    let tile = |tile: usize| {
        let (x, y) = (tile % across * TILE, tile / across * TILE);
        let pixel = |k: usize| direction(x + k % TILE, y + k / TILE);
        Bundle {
            origin: scene.eye,
            directions: (0..TILE * TILE).map(pixel).collect(),
        }
    };
    (0..across * height / TILE).map(tile).collect()
}

/// The points that camera rays find, moved off their surface, with a frame on the camera's side.
fn surface_points(
    scene: &Scene,
    tracer: &Tracer,
    primary: &[Bundle],
    diagonal: f32,
) -> Vec<(Vec3, Frame)> {
    let counter = RayCounter::default();
    let caster = tracer.caster(&counter);
    let point = |ray: Ray| {
        let hit = caster.closest(&ray)?;
        let [a, b, c] = scene.triangles[hit.triangle as usize].map(|i| scene.positions[i as usize]);
        let normal = (b - a).cross(c - a).try_normalize()?;
        let normal = if normal.dot(ray.direction) > 0.0 {
            -normal
        } else {
            normal
        };
        let origin = offset_origin(ray.origin + hit.t * ray.direction, normal, diagonal);
        Some((origin, Frame::from_normal(normal)))
    };
    rays_of(primary, f32::INFINITY).filter_map(point).collect()
}
