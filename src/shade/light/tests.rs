use glam::{DMat4, DVec3};

use super::*;
use crate::scene::{Needs, SceneDescription, ShapeDescription, ShapeSource, View};

#[test]
fn lights_are_chosen_by_power_and_evenly() {
    let all = Total::of([1.0, 0.0, 3.0]);
    assert_eq!(
        [1.0, 0.0, 3.0].map(|power| all.chance(power)),
        [0.375, 0.0, 0.625]
    );
    assert_eq!(Total::of([3.0, 0.0]).chance(3.0), 1.0);
    assert_eq!(Total::of([]).chance(0.0), 0.0);
    assert_eq!(Total::of([f64::INFINITY, 1.0]).chance(1.0), 0.0);
    assert_eq!(pick(&[0.0, 1.0, 1.0, 2.0], 0.0), 1);
    assert_eq!(pick(&[0.0, 1.0, 1.0, 2.0], 0.5), 3);
    assert_eq!(usable([f32::NAN, 1.0, 1.0]), 0.0);
    assert_eq!(usable([-1.0, 1.0, 1.0]), 0.0);
}

#[test]
fn a_moon_does_not_starve_a_torch() {
    let sphere = |name: &str, centre: DVec3, radius: f64, emission: f32| {
        let mut shape = ShapeDescription::new(name, ShapeSource::Sphere { centre, radius });
        shape.emission = Some([emission; 3]);
        shape
    };
    let mut floor = ShapeDescription::new("floor", ShapeSource::Rectangle);
    floor.to_world = DMat4::from_scale(DVec3::splat(4.0));
    let eye = [DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y];
    let description = SceneDescription {
        views: vec![View::look_at("v", eye, 60.0, [8, 8])],
        shapes: vec![
            floor,
            sphere("moon", DVec3::new(40.0, 80.0, 48.0), 7.0, 10.0),
            sphere("torch", DVec3::new(1.0, 0.0, 1.0), 0.07, 100.0),
        ],
        ..SceneDescription::default()
    };
    let scene = Scene::build(&description, Needs::ALL).expect("a scene");
    let lights = Lights::new(&scene);
    let mut rng = Rng::new(1, 2, 3, 4);
    let count = 40_000;
    let (mut torch, mut area) = (0, 0.0);
    for _ in 0..count {
        let choice = rng.next_f64();
        let found = lights.choose(choice, &mut rng).expect("something shines");
        let LightPlace::Triangle(number, _) = found.place else {
            panic!("another light");
        };
        torch += u32::from(scene.triangle_shape[number as usize] == 2);
        area += 1.0 / (f64::from(found.density) * f64::from(count));
    }
    // Half of all choices are even over the two shapes.
    let share = f64::from(torch) / f64::from(count);
    assert!((share - 0.25).abs() < 0.01, "{share}");
    // What is chosen as often as its density says has the area of all lights on average.
    let triangles = &lights.triangles;
    let areas = triangles
        .iter()
        .map(|t| 0.5 * t.edges[0].cross(t.edges[1]).length());
    let all: f64 = areas.map(f64::from).sum();
    assert!((area / all - 1.0).abs() < 0.02, "{area} of {all}");
    // No other light is chosen.
    assert_eq!(lights.groups, [1.0, 0.0, 0.0, 0.0]);
    // The probabilities of all of them are one.
    let chances = triangles
        .iter()
        .map(|t| f64::from(t.pdf_area) * 0.5 * f64::from(t.edges[0].cross(t.edges[1]).length()));
    assert!((chances.sum::<f64>() - 1.0).abs() < 1e-4);
}
