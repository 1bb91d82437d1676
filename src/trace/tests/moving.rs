//! A tracer of two trees answers as one tree over the same triangles does, before and after a move.

use glam::Vec3;

use super::brute::Brute;
use super::check_bundle;
use super::scenes::{Soup, all, bundles_for, rays_for};
use crate::trace::{Hit, Kernel, Ray, RayCounter, Tracer};

/// Every third triangle, none, all, and all but the first.
const CHOICES: [fn(usize) -> bool; 4] = [|i| i % 3 == 1, |_| false, |_| true, |i| i > 0];

fn flags(soup: &Soup, choice: fn(usize) -> bool) -> Vec<bool> {
    (0..soup.triangles.len()).map(choice).collect()
}

fn in_two(kernel: Kernel, soup: &Soup, choice: fn(usize) -> bool) -> Tracer {
    Tracer::with_moving_for(
        kernel,
        &soup.positions,
        &soup.triangles,
        &flags(soup, choice),
    )
}

/// Whether a ray may be decided otherwise by another tree: obvhs takes the first of equal hits, and of
/// slivers that are nearly parallel to the ray the box decides.
fn may_differ(brute: &Brute, ray: &Ray, kernel: Kernel, [one, two]: [Option<Hit>; 2]) -> bool {
    let tie = one
        .zip(two)
        .is_some_and(|(a, b)| (a.t - b.t).abs() <= 1e-5 * a.t.abs());
    kernel == Kernel::Portable && (tie || brute.certain(ray).is_none()) || brute.is_doubtful(ray)
}

fn check_alike(soup: &Soup, [one, two]: [&Tracer; 2]) {
    let brute = Brute::new(soup);
    let counters = [RayCounter::default(), RayCounter::default()];
    let casters = [one.caster(&counters[0]), two.caster(&counters[1])];
    for ray in rays_for(soup) {
        let hits = casters.each_ref().map(|caster| caster.closest(&ray));
        let blocked = casters.each_ref().map(|caster| caster.occluded(&ray));
        if hits[0] != hits[1] || blocked[0] != blocked[1] {
            let kernel = one.kernel();
            assert!(
                may_differ(&brute, &ray, kernel, hits),
                "{} {}: {ray:?}: {hits:?}, blocked {blocked:?}",
                soup.name,
                kernel.name()
            );
        }
    }
    drop(casters);
    assert_eq!(
        counters[0].read(),
        counters[1].read(),
        "one ray counts once"
    );
}

#[test]
fn two_trees_answer_as_one() {
    for soup in all() {
        for kernel in Kernel::ALL
            .into_iter()
            .filter(|kernel| kernel.is_available())
        {
            let one = Tracer::with_kernel(&soup.positions, &soup.triangles, kernel);
            for choice in CHOICES {
                check_alike(&soup, [&one, &in_two(kernel, &soup, choice)]);
            }
        }
    }
}

#[test]
fn bundles_of_two_trees_agree_with_single_rays() {
    for soup in all() {
        for kernel in Kernel::ALL
            .into_iter()
            .filter(|kernel| kernel.is_available())
        {
            let tracer = in_two(kernel, &soup, CHOICES[0]);
            for (origin, directions) in bundles_for(&soup) {
                for t_max in [f32::INFINITY, soup.scale * 0.5, 0.0] {
                    check_bundle(&tracer, origin, &directions, t_max, soup.name);
                }
            }
        }
    }
}

#[test]
fn a_moved_tracer_is_one_built_anew() {
    for mut soup in all() {
        let choice = CHOICES[0];
        let kernels = Kernel::ALL
            .into_iter()
            .filter(|kernel| kernel.is_available());
        let mut tracers: Vec<Tracer> = kernels.map(|k| in_two(k, &soup, choice)).collect();
        for step in [0.3, -1.1] {
            let offset = Vec3::new(step, 0.5 * step, -step) * soup.scale;
            for triangle in soup.triangles.iter().skip(1).step_by(3) {
                triangle
                    .iter()
                    .for_each(|&i| soup.positions[i as usize] += offset);
            }
            for tracer in &mut tracers {
                tracer.moved(&soup.positions);
                let anew = Tracer::with_kernel(&soup.positions, &soup.triangles, tracer.kernel());
                check_alike(&soup, [&anew, tracer]);
            }
        }
    }
}

/// Coincident triangles in either tree: the one with the smallest index, at any limit.
#[test]
fn ties_between_the_trees_go_to_the_smallest_index() {
    let corners = [Vec3::NEG_X, Vec3::X, Vec3::Y];
    let positions = corners.repeat(4);
    let triangles = [0, 3, 6, 9].map(|i| [i, i + 1, i + 2]);
    let ray = Ray::new(Vec3::new(0.1, 0.2, 2.0), -Vec3::Z);
    for kernel in [Kernel::wide(), Kernel::watertight()].into_iter().flatten() {
        for choice in 0..16u32 {
            let moving = [0, 1, 2, 3].map(|i| choice >> i & 1 == 1);
            let tracer = Tracer::with_moving_for(kernel, &positions, &triangles, &moving);
            let counter = RayCounter::default();
            let caster = tracer.caster(&counter);
            for t_max in [2.0, f32::INFINITY] {
                let hit = caster.closest(&Ray { t_max, ..ray });
                assert_eq!(hit.map(|h| (h.t, h.triangle)), Some((2.0, 0)), "{moving:?}");
                let mut hits = [None];
                caster.closest_bundle(ray.origin, &[ray.direction], t_max, &mut hits);
                assert_eq!(hits[0], hit, "{moving:?}");
            }
            assert!(!caster.occluded(&Ray { t_min: 2.0, ..ray }));
        }
    }
}
