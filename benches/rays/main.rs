//! Mrays per CPU-second of every kernel, side by side on the same rays.
//!
//! `cargo bench --bench rays [-- terrain | kitchen]` prints one table a scene: the portable kernel (obvhs' traversal), the
//! wide one with single rays and with bundles, and their ratios. Kernels take turns and the best of
//! seven rounds counts, so that other work on the machine disturbs all of them alike.

mod terrain;

use glam::Vec3;
use lightbench::sample::{Frame, Rng, equal_area_hemisphere};
use lightbench::scene::{Needs, find_scene};
use lightbench::trace::{Caster, Hit, Kernel, Ray, RayCounter, Tracer, offset_origin};

const ROUNDS: usize = 7;
const RECORDS: usize = 160;
const SIDE: usize = 32;

/// Triangles and a camera.
pub struct Scene {
    pub name: &'static str,
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    pub eye: Vec3,
    pub look_at: Vec3,
}

fn main() {
    let filter = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    let wanted = |name: &str| filter.as_ref().is_none_or(|f| f == name);
    if wanted("terrain") {
        report(&terrain::scene());
    }
    if wanted("kitchen") {
        match kitchen() {
            Some(scene) => report(&scene),
            None => println!("kitchen: skipped, not found through LIGHTBENCH_SCENES"),
        }
    }
}

/// The kitchen of the published test scenes, seen from its first view.
fn kitchen() -> Option<Scene> {
    let description = find_scene("kitchen").ok()?;
    let loaded = lightbench::scene::Scene::build(&description, Needs::default()).ok()?;
    let view = loaded.views.first()?;
    let eye = view.origin.as_vec3();
    Some(Scene {
        name: "kitchen",
        eye,
        look_at: eye + view.forward.as_vec3(),
        positions: loaded.positions,
        triangles: loaded.triangles,
    })
}

/// CPU time of this thread in seconds.
#[cfg(unix)]
fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Elapsed seconds, where CPU time is not at hand.
#[cfg(not(unix))]
fn cpu_seconds() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START
        .get_or_init(std::time::Instant::now)
        .elapsed()
        .as_secs_f64()
}

/// Seconds of CPU time, and the result.
fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = cpu_seconds();
    let result = work();
    (cpu_seconds() - start, result)
}

/// A set of rays with the ways to cast it.
struct Set {
    name: &'static str,
    work: Work,
}

enum Work {
    Closest(Vec<Ray>),
    Occluded(Vec<Ray>),
    RecordOccluded(Vec<Record>, f32),
    RecordClosest(Vec<Record>),
}

struct Record {
    origin: Vec3,
    directions: Vec<Vec3>,
}

impl Work {
    fn rays(&self) -> usize {
        match self {
            Self::Closest(rays) | Self::Occluded(rays) => rays.len(),
            Self::RecordOccluded(records, _) | Self::RecordClosest(records) => {
                records.len() * SIDE * SIDE
            }
        }
    }

    /// Casts everything and returns the number of hits.
    fn cast(&self, caster: &Caster, bundles: bool) -> usize {
        match self {
            Self::Closest(rays) => rays.iter().filter(|r| caster.closest(r).is_some()).count(),
            Self::Occluded(rays) => rays.iter().filter(|r| caster.occluded(r)).count(),
            Self::RecordOccluded(records, t_max) => records
                .iter()
                .map(|r| occluded_record(caster, r, *t_max, bundles))
                .sum(),
            Self::RecordClosest(records) => records
                .iter()
                .map(|r| closest_record(caster, r, bundles))
                .sum(),
        }
    }

    fn has_bundles(&self) -> bool {
        matches!(self, Self::RecordOccluded(..) | Self::RecordClosest(_))
    }
}

fn occluded_record(caster: &Caster, record: &Record, t_max: f32, bundles: bool) -> usize {
    if bundles {
        let mut bits = [0u64; SIDE * SIDE / 64];
        caster.occluded_bundle(record.origin, &record.directions, t_max, &mut bits);
        return bits.iter().map(|b| b.count_ones() as usize).sum();
    }
    let occluded = |&direction: &Vec3| {
        caster.occluded(&Ray {
            t_max,
            ..Ray::new(record.origin, direction)
        })
    };
    record.directions.iter().filter(|d| occluded(d)).count()
}

fn closest_record(caster: &Caster, record: &Record, bundles: bool) -> usize {
    if bundles {
        let mut hits: [Option<Hit>; SIDE * SIDE] = [None; SIDE * SIDE];
        caster.closest_bundle(record.origin, &record.directions, f32::INFINITY, &mut hits);
        return hits.iter().flatten().count();
    }
    let hit = |&d: &Vec3| caster.closest(&Ray::new(record.origin, d)).is_some();
    record.directions.iter().filter(|d| hit(d)).count()
}

fn report(scene: &Scene) {
    let build = |kernel| timed(|| Tracer::with_kernel(&scene.positions, &scene.triangles, kernel));
    let (portable_s, portable) = build(Kernel::Portable);
    let (wide_s, wide) = build(Kernel::Wide);
    let millions = scene.triangles.len() as f64 * 1e-6;
    println!("{}: {millions:.3} M triangles", scene.name);
    for (tracer, seconds) in [(&portable, portable_s), (&wide, wide_s)] {
        println!(
            "  {:14} build {:.2} s/M, {:.1} B/triangle",
            tracer.kernel().name(),
            seconds / millions,
            tracer.bytes() as f64 / scene.triangles.len() as f64,
        );
    }
    println!("  Mrays per CPU-second      portable   single (ratio)   bundle (ratio)   hits");
    let sets = ray_sets(scene, &wide);
    for set in &sets {
        row(set, &portable, &wide);
    }
    threads(&sets, &wide);
}

fn row(set: &Set, portable: &Tracer, wide: &Tracer) {
    let counter = RayCounter::default();
    let contenders = [(portable, false), (wide, false), (wide, true)];
    let count = if set.work.has_bundles() { 3 } else { 2 };
    let mut best = [f64::INFINITY; 3];
    let mut hits = [0; 3];
    for _ in 0..ROUNDS {
        for (k, (tracer, bundles)) in contenders.iter().enumerate().take(count) {
            let caster = tracer.caster(&counter);
            let (seconds, found) = timed(|| set.work.cast(&caster, *bundles));
            best[k] = best[k].min(seconds);
            hits[k] = found;
        }
    }
    let rate = best.map(|seconds| set.work.rays() as f64 * 1e-6 / seconds);
    print!("  {:24} {:9.2}", set.name, rate[0]);
    for rate_k in &rate[1..count] {
        print!("   {rate_k:6.2} ({:5.2})", rate_k / rate[0]);
    }
    println!(
        "{:pad$}   {:?}",
        "",
        &hits[..count],
        pad = if count == 2 { 17 } else { 0 }
    );
}

/// How two threads scale on each record set: twice the CPU time of one thread alone over that of one
/// of two. Other work on the machine costs elapsed time but little CPU time.
fn threads(sets: &[Set], wide: &Tracer) {
    for set in sets.iter().filter(|s| s.work.has_bundles()) {
        let counter = RayCounter::default();
        let run = || timed(|| set.work.cast(&wide.caster(&counter), true)).0;
        let slowest = |threads: usize| {
            std::thread::scope(|scope| {
                let workers: Vec<_> = (0..threads).map(|_| scope.spawn(run)).collect();
                workers
                    .into_iter()
                    .map(|w| w.join().unwrap_or(f64::INFINITY))
                    .fold(0.0, f64::max)
            })
        };
        let best = |threads| {
            (0..ROUNDS)
                .map(|_| slowest(threads))
                .fold(f64::INFINITY, f64::min)
        };
        println!(
            "  2 threads, {:24} {:.2} x",
            set.name,
            2.0 * best(1) / best(2)
        );
    }
}

fn ray_sets(scene: &Scene, tracer: &Tracer) -> Vec<Set> {
    let (low, high) = scene
        .positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| {
            (low.min(p), high.max(p))
        });
    let diagonal = (high - low).length();
    let primary = primary_rays(scene);
    let points = surface_points(scene, tracer, &primary, diagonal);
    let mut rng = Rng::new(1, 2, 3, 4);
    let scattered: Vec<Ray> = points
        .iter()
        .map(|(origin, frame)| {
            let cell = rng.below(SIDE * SIDE);
            Ray::new(*origin, frame.to_world(equal_area_hemisphere(SIDE)[cell]))
        })
        .collect();
    let limited = scattered
        .iter()
        .map(|ray| Ray {
            t_max: 0.1 * diagonal,
            ..*ray
        })
        .collect();
    let grid = equal_area_hemisphere(SIDE);
    let records = || -> Vec<Record> {
        let step = (points.len() / RECORDS).max(1);
        let record = |(origin, frame): &(Vec3, Frame)| Record {
            origin: *origin,
            directions: grid.iter().map(|&d| frame.to_world(d)).collect(),
        };
        points.iter().step_by(step).map(record).collect()
    };
    let set = |name, work| Set { name, work };
    vec![
        set("primary", Work::Closest(primary)),
        set("occlusion", Work::Occluded(scattered.clone())),
        set("occlusion, 0.1 D", Work::Occluded(limited)),
        set("bounce closest", Work::Closest(scattered)),
        set("record any", Work::RecordOccluded(records(), f32::INFINITY)),
        set(
            "record any, 0.1 D",
            Work::RecordOccluded(records(), 0.1 * diagonal),
        ),
        set("record closest", Work::RecordClosest(records())),
    ]
}

fn primary_rays(scene: &Scene) -> Vec<Ray> {
    let (width, height) = (400, 300);
    let frame = Frame::from_normal((scene.look_at - scene.eye).normalize());
    let ray = |i: usize| {
        let x = (i % width) as f32 / width as f32 - 0.5;
        let y = (i / width) as f32 / width as f32 - 0.375;
        Ray::new(scene.eye, frame.to_world(Vec3::new(x, y, 0.8).normalize()))
    };
    (0..width * height).map(ray).collect()
}

/// The points that primary rays find, moved off their surface, with a frame on the camera's side.
fn surface_points(
    scene: &Scene,
    tracer: &Tracer,
    primary: &[Ray],
    diagonal: f32,
) -> Vec<(Vec3, Frame)> {
    let counter = RayCounter::default();
    let caster = tracer.caster(&counter);
    let point = |ray: &Ray| {
        let hit = caster.closest(ray)?;
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
    primary.iter().filter_map(point).collect()
}
