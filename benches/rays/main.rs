//! Mrays per CPU-second of every kernel, side by side on the same rays, as Markdown tables.
//!
//! `cargo bench --bench rays [-- terrain | kitchen | moving] [--quick] [--avx2] [--export DIR]` prints one table a scene: the
//! portable kernel (obvhs' traversal), the wide one with single rays and with bundles, its watertight
//! variant, and their ratios to the first. Kernels take turns and the best of seven rounds counts, so that other work on the
//! machine disturbs all of them alike. `--quick` leaves out the scaling to two threads; `--avx2` measures these kernels where the processor has
//! better ones too; `--export` also writes triangles, rays and rates as
//! raw files ([`export`]), which `scripts/embree-compare.py` uses. `moving` measures what a frame costs in which 1 % of
//! the terrain's triangles move ([`moving`]).

mod export;
mod moving;
mod sets;
mod terrain;

use glam::Vec3;
use lightbench::scene::{Needs, find_scene};
use lightbench::trace::{Instructions, Kernel, RayCounter, Tracer};

use sets::{Set, ray_sets};

const ROUNDS: usize = 7;

/// Triangles and a camera.
pub struct Scene {
    /// Heads its table.
    pub name: &'static str,
    /// Corners, scene units.
    pub positions: Vec<Vec3>,
    /// Indices of the corners.
    pub triangles: Vec<[u32; 3]>,
    /// Where camera rays start.
    pub eye: Vec3,
    /// What is in the middle of the image.
    pub look_at: Vec3,
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let mut filter = None;
    let mut directory = None;
    let mut is_quick = false;
    let mut kernels = [
        Kernel::Portable,
        Kernel::wide().unwrap_or(Kernel::Portable),
        Kernel::watertight().unwrap_or(Kernel::Portable),
    ];
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--export" => directory = arguments.next(),
            "--quick" => is_quick = true,
            "--avx2" => {
                kernels[1] = Kernel::Wide(Instructions::Avx2);
                kernels[2] = Kernel::Watertight(Instructions::Avx2);
            }
            name if !name.starts_with('-') => filter = Some(argument),
            _ => {}
        }
    }
    let wanted = |name: &str| filter.as_ref().is_none_or(|f| f == name);
    let scenes = [
        wanted("terrain").then(terrain::scene),
        wanted("kitchen").then(kitchen).flatten(),
    ];
    for scene in scenes.iter().flatten() {
        let rows = report(scene, kernels, is_quick);
        if let Some(directory) = &directory
            && let Err(error) = export::write(directory.as_ref(), scene, &rows)
        {
            eprintln!("{directory}: {error}");
            std::process::exit(1);
        }
    }
    if wanted("moving") {
        moving::report(&terrain::scene());
    }
    if wanted("kitchen") && scenes[1].is_none() {
        println!("kitchen: skipped, not found through LIGHTBENCH_SCENES");
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
    seconds(rustix::time::ClockId::ThreadCPUTime)
}

/// CPU time of all threads in seconds.
#[cfg(unix)]
fn all_cpu_seconds() -> f64 {
    seconds(rustix::time::ClockId::ProcessCPUTime)
}

#[cfg(unix)]
fn seconds(clock: rustix::time::ClockId) -> f64 {
    let time = rustix::time::clock_gettime(clock);
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

#[cfg(not(unix))]
fn all_cpu_seconds() -> f64 {
    cpu_seconds()
}

/// Seconds of this thread's CPU time, and the result.
fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = cpu_seconds();
    let result = work();
    (cpu_seconds() - start, result)
}

/// The contenders of a set: index of the tracer and whether rays of one origin are cast together.
const CONTENDERS: [(usize, bool); 5] = [(0, false), (1, false), (1, true), (2, false), (2, true)];

/// What was measured on one set, by contender.
pub struct Row {
    set: Set,
    /// Mrays per CPU-second; NaN where a contender does not apply.
    rate: [f64; 5],
    hits: [Option<usize>; 5],
}

fn report(scene: &Scene, kernels: [Kernel; 3], is_quick: bool) -> Vec<Row> {
    let millions = scene.triangles.len() as f64 * 1e-6;
    println!("{}: {millions:.3} M triangles\n", scene.name);
    let build = |kernel| {
        let start = all_cpu_seconds();
        let tracer = Tracer::with_kernel(&scene.positions, &scene.triangles, kernel);
        let seconds = all_cpu_seconds() - start;
        println!(
            "- {}: built in {:.2} CPU-seconds per million triangles, {:.1} bytes a triangle",
            tracer.kernel().name(),
            seconds / millions,
            tracer.bytes() as f64 / scene.triangles.len() as f64,
        );
        tracer
    };
    let tracers = kernels.map(build);
    println!(
        "\n| Mrays per CPU-second (× obvhs) | obvhs | single | bundle | watertight single | \
         watertight bundle | 2 threads | hits |\n|---|--:|--:|--:|--:|--:|--:|--:|"
    );
    let measured = |set| {
        let row = measure(set, &tracers);
        print_row(&row, (!is_quick).then(|| threads(&row.set, &tracers[1])));
        row
    };
    let sets = ray_sets(scene, &tracers[1]);
    let rows = sets.into_iter().map(measured).collect();
    println!();
    rows
}

fn measure(set: Set, tracers: &[Tracer]) -> Row {
    let counter = RayCounter::default();
    let mut best = [f64::NAN; 5];
    let mut hits = [None; 5];
    for _ in 0..ROUNDS {
        for (k, (tracer, bundled)) in CONTENDERS.into_iter().enumerate() {
            if bundled && !set.work.has_bundles() {
                continue;
            }
            let caster = tracers[tracer].caster(&counter);
            let (seconds, found) = timed(|| set.work.cast(&caster, bundled));
            best[k] = best[k].min(seconds);
            hits[k] = Some(found);
        }
    }
    let rate = best.map(|seconds| set.work.rays() as f64 * 1e-6 / seconds);
    Row { set, rate, hits }
}

/// Hit counts are one number, or all of them where they differ.
fn print_row(row: &Row, two_threads: Option<f64>) {
    let obvhs = row.rate[0];
    print!("| {} | {obvhs:.2} ", row.set.name);
    for rate in &row.rate[1..] {
        if rate.is_nan() {
            print!("| – ");
        } else {
            print!("| {rate:.2} ({:.2} ×) ", rate / obvhs);
        }
    }
    let scaling = two_threads.map_or("–".into(), |s| format!("{s:.2} ×"));
    let mut hits: Vec<usize> = row.hits.into_iter().flatten().collect();
    hits.dedup();
    let hits: Vec<String> = hits.iter().map(ToString::to_string).collect();
    println!("| {scaling} | {} |", hits.join(", "));
}

/// How two threads scale: twice the CPU time of one thread alone over that of the slower of two. Other work on the
/// machine costs elapsed time but little CPU time.
fn threads(set: &Set, wide: &Tracer) -> f64 {
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
    2.0 * best(1) / best(2)
}
