//! Every kernel against every triangle, on friendly and on hard scenes.

mod brute;
mod interface;
mod moving;
mod scenes;
mod watertight;

use glam::Vec3;

use super::{Hit, Instructions, Kernel, Ray, RayCounter, Tracer};
use brute::Brute;
use scenes::{Soup, all, rays_for};

/// The wide kernels do exactly the arithmetic of the brute force, so hits agree to the last bit.
/// A triangle's computed distance may be wrong by more than its box is thick when the ray is nearly
/// parallel to a sliver: such hits are the only ones that may be decided otherwise, and they are
/// recognised in f64.
#[test]
fn wide_rays_agree_with_brute_force_to_the_last_bit() {
    for kernel in [Instructions::Avx512, Instructions::Avx2].map(Kernel::Wide) {
        if kernel.is_available() {
            check_against_brute_force(kernel);
        } else {
            println!("skipped: this processor cannot run {}", kernel.name());
        }
    }
}

fn check_against_brute_force(kernel: Kernel) {
    let mut doubtful = 0;
    let mut total = 0;
    for soup in all() {
        let tracer = Tracer::with_kernel(&soup.positions, &soup.triangles, kernel);
        assert_eq!(tracer.kernel(), kernel);
        let counter = RayCounter::default();
        let caster = tracer.caster(&counter);
        let brute = Brute::new(&soup);
        for ray in rays_for(&soup) {
            total += 1;
            let (closest, expected) = (caster.closest(&ray), brute.closest(&ray));
            let blocked = caster.occluded(&ray);
            if closest != expected || blocked != brute.occluded(&ray) {
                assert!(
                    brute.is_doubtful(&ray),
                    "{}: {ray:?}: {closest:?}, expected {expected:?}; blocked {blocked}",
                    soup.name
                );
                doubtful += 1;
            }
        }
    }
    println!("{}: {doubtful} of {total} rays doubtful", kernel.name());
    assert!(doubtful * 2000 < total, "{doubtful} of {total}");
}

/// How many lanes a processor has changes no answer.
#[test]
fn registers_of_any_width_answer_alike() {
    let kernels = [Instructions::Avx512, Instructions::Avx2].map(Kernel::Wide);
    if let Some(kernel) = kernels.iter().find(|kernel| !kernel.is_available()) {
        println!("skipped: this processor cannot run {}", kernel.name());
        return;
    }
    for soup in all() {
        let counter = RayCounter::default();
        let tracers = kernels.map(|k| Tracer::with_kernel(&soup.positions, &soup.triangles, k));
        let [wide, narrow] = tracers.each_ref().map(|tracer| tracer.caster(&counter));
        for ray in rays_for(&soup) {
            assert_eq!(
                wide.closest(&ray),
                narrow.closest(&ray),
                "{} {ray:?}",
                soup.name
            );
            assert_eq!(
                wide.occluded(&ray),
                narrow.occluded(&ray),
                "{} {ray:?}",
                soup.name
            );
        }
    }
}

/// An independent f64 test of every triangle; rays that it finds close to an edge, to a limit or to a
/// tie are left out.
#[test]
fn every_kernel_agrees_with_double_precision() {
    for soup in all() {
        let brute = Brute::new(&soup);
        let rays = rays_for(&soup);
        for kernel in Kernel::ALL {
            let tracer = Tracer::with_kernel(&soup.positions, &soup.triangles, kernel);
            let counter = RayCounter::default();
            let caster = tracer.caster(&counter);
            let mut certain = 0;
            for ray in &rays {
                let Some(expected) = brute.certain(ray) else {
                    continue;
                };
                certain += 1;
                let hit = caster.closest(ray);
                let note = || format!("{} {kernel:?} {ray:?} {hit:?} {expected:?}", soup.name);
                assert_eq!(hit.map(|h| h.triangle), expected.map(|e| e.0), "{}", note());
                assert_eq!(caster.occluded(ray), expected.is_some(), "{}", note());
                if let (Some(hit), Some((_, t))) = (hit, expected) {
                    assert!((f64::from(hit.t) - t).abs() <= 1e-3 * t, "{}", note());
                    assert!(hit.u >= -1e-5 && hit.v >= -1e-5 && hit.u + hit.v <= 1.0 + 1e-5);
                }
            }
            let needed = if soup.is_hard || cfg!(miri) {
                0
            } else {
                rays.len() / 12
            };
            assert!(certain >= needed, "{}: only {certain} certain", soup.name);
        }
    }
}

/// Bundles of every size and shape, wide cones and mixed directions included.
#[test]
fn bundles_agree_with_single_rays_to_the_last_bit() {
    for soup in all() {
        for kernel in Kernel::ALL {
            let tracer = Tracer::with_kernel(&soup.positions, &soup.triangles, kernel);
            for (origin, directions) in scenes::bundles_for(&soup) {
                for t_max in [f32::INFINITY, soup.scale * 0.5, 0.0] {
                    check_bundle(&tracer, origin, &directions, t_max, soup.name);
                }
            }
        }
    }
}

fn check_bundle(tracer: &Tracer, origin: Vec3, directions: &[Vec3], t_max: f32, name: &str) {
    let counter = RayCounter::default();
    let caster = tracer.caster(&counter);
    let mut bits = vec![u64::MAX; directions.len().div_ceil(64)];
    caster.occluded_bundle(origin, directions, t_max, &mut bits);
    let stale = Hit {
        t: 1.0,
        u: 0.0,
        v: 0.0,
        triangle: 7,
    };
    let mut hits = vec![Some(stale); directions.len()];
    caster.closest_bundle(origin, directions, t_max, &mut hits);
    for (i, &direction) in directions.iter().enumerate() {
        let ray = Ray {
            t_max,
            ..Ray::new(origin, direction)
        };
        let blocked = bits[i / 64] >> (i % 64) & 1 == 1;
        assert_eq!(blocked, caster.occluded(&ray), "{name} {i} {ray:?}");
        assert_eq!(hits[i], caster.closest(&ray), "{name} {i} {ray:?}");
    }
    let used = directions.len() % 64;
    let beyond = bits.last().filter(|_| used > 0).map_or(0, |b| b >> used);
    assert_eq!(beyond, 0, "bits beyond the last direction");
    drop(caster);
    let expected = 2 * directions.len() as u64;
    assert_eq!(
        (counter.read().shadow, counter.read().closest),
        (expected, expected)
    );
}

#[test]
fn threads_do_not_change_answers() {
    let soup: Soup = all().swap_remove(0);
    let tracer = Tracer::new(&soup.positions, &soup.triangles);
    let rays = rays_for(&soup);
    let cast = |rays: &[Ray]| -> Vec<Option<Hit>> {
        let counter = RayCounter::default();
        let caster = tracer.caster(&counter);
        rays.iter().map(|ray| caster.closest(ray)).collect()
    };
    let whole = cast(&rays);
    let (front, back) = rays.split_at(rays.len() / 3);
    let (front, back) = rayon::join(|| cast(front), || cast(back));
    assert_eq!(whole, [front, back].concat());
}
