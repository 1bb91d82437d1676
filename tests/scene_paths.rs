//! The camera paths of shipped scenes keep clear of what stands there.

use glam::Vec3;
use lightbench::scene::{Needs, Scene, find_scene_in, shipped_scenes};
use lightbench::trace::{Caster, Ray, RayCounter, Tracer};

/// Nearest hit over directions spread evenly over the sphere.
fn clearance(caster: &Caster, at: Vec3) -> f32 {
    const DIRECTIONS: u32 = 200;
    let turn = std::f32::consts::PI * (3.0 - 5f32.sqrt());
    let hits = (0..DIRECTIONS).filter_map(|i| {
        let y = 1.0 - 2.0 * (i as f32 + 0.5) / DIRECTIONS as f32;
        let (sin, cos) = (turn * i as f32).sin_cos();
        let across = (1.0 - y * y).sqrt();
        caster.closest(&Ray::new(at, Vec3::new(across * cos, y, across * sin)))
    });
    hits.map(|hit| hit.t).fold(f32::INFINITY, f32::min)
}

#[test]
fn paths_of_shipped_scenes_cross_nothing_and_keep_their_distance() {
    let mut with_paths = 0;
    for name in shipped_scenes() {
        let description = find_scene_in(name, &[]).unwrap_or_else(|e| panic!("{e}"));
        if description.paths.is_empty() {
            continue;
        }
        with_paths += 1;
        let scene = Scene::build(&description, Needs::GEOMETRY).unwrap_or_else(|e| panic!("{e}"));
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        let counter = RayCounter::default();
        let caster = tracer.caster(&counter);
        for path in &description.paths {
            let [from, to] = path.span_s();
            let places: Vec<Vec3> = (0..=150)
                .map(|i| from + (to - from) * f64::from(i) / 150.0)
                .map(|time_s| (path.view(time_s).origin - scene.origin).as_vec3())
                .collect();
            for pair in places.windows(2) {
                let place = format!(
                    "{name}, {}: {}",
                    path.name,
                    pair[1] + scene.origin.as_vec3()
                );
                let distance = clearance(&caster, pair[1]);
                assert!(distance > 0.2, "{place} is {distance} m from something");
                let step = pair[1] - pair[0];
                let ray = Ray {
                    t_max: step.length(),
                    ..Ray::new(pair[0], step.normalize_or(Vec3::X))
                };
                assert!(!caster.occluded(&ray), "{place}: something is in the way");
            }
        }
    }
    assert!(with_paths >= 3, "{with_paths} scenes have paths");
}
