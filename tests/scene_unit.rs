//! Scenes whose unit nobody declares: their placement and their pictures do not depend on it.

use std::collections::HashSet;

use glam::{DMat4, DVec3};
use lightbench::cache::ShadingPoints;
use lightbench::placement::first_stage;
use lightbench::scene::{
    ASSUMED_DIAGONAL_M, Needs, Scene, SceneDescription, ShapeDescription, ShapeSource, View,
};
use lightbench::technique::{Film, Shot, shading_points};
use lightbench::trace::{RayCounter, Tracer};
use lightbench::world::Moment;

/// A room of 6 × 3 × 8 m with boxes near and far.
fn room(metres_per_unit: Option<f64>) -> SceneDescription {
    let cube = |name: &str, half: DVec3, centre: DVec3| ShapeDescription {
        to_world: DMat4::from_translation(centre) * DMat4::from_scale(half),
        ..ShapeDescription::new(name, ShapeSource::Cube)
    };
    let mut shapes = vec![cube("room", DVec3::new(3.0, 1.5, 4.0), DVec3::ZERO)];
    for i in 0..6 {
        let centre = DVec3::new(f64::from(i) - 2.5, -1.2, 2.5 - f64::from(i));
        shapes.push(cube("box", DVec3::splat(0.3), centre));
    }
    let eye = [
        DVec3::new(0.5, 0.3, 3.7),
        DVec3::new(-0.3, -0.4, -3.0),
        DVec3::Y,
    ];
    SceneDescription {
        name: "room".into(),
        metres_per_unit,
        exposure: 1.0,
        max_depth: 4,
        views: vec![View::look_at("main", eye, 70.0, [160, 90])],
        shapes,
        materials: vec![lightbench::scene::Material::diffuse("grey", [0.5; 3])],
        ..SceneDescription::default()
    }
}

fn seen(scene: &Scene) -> ShadingPoints {
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let film = Film {
        width: 160,
        height: 90,
        spp: 1,
    };
    let shot = Shot::new(Moment::still(scene, &tracer), &scene.views[0], film);
    shading_points(&shot, &RayCounter::default())
}

/// VGC's records of the room after a change of unit, its α and its notes.
fn placed(description: SceneDescription, scale: f64) -> (HashSet<u32>, f64, Vec<String>) {
    let scaled = description.transformed(scale, 0.0, DVec3::ZERO);
    let scene = Scene::build(&scaled, Needs::ALL).unwrap_or_else(|e| panic!("{e}"));
    let points = seen(&scene);
    let entry = first_stage("VGC").expect("listed");
    let stage = (entry.build)(&toml::Table::new()).expect("defaults");
    let placement = stage.place(&points, 300, 5);
    let pixels = placement
        .sites
        .iter()
        .map(|&i| points.pixel[i as usize])
        .collect();
    let alpha = placement
        .found
        .iter()
        .find(|(key, _)| *key == "alpha")
        .expect("alpha")
        .1;
    (pixels, alpha, placement.notes)
}

#[test]
fn the_unit_of_a_scene_without_one_does_not_matter() {
    let (expected, alpha, _) = placed(room(None), 1.0);
    assert!(alpha > 1.5, "{alpha}");
    for scale in [1e-3, 0.1, 10.0, 1e3] {
        let (again, its_alpha, _) = placed(room(None), scale);
        assert!(
            (its_alpha - alpha).abs() < 1e-4,
            "{scale}: {its_alpha}, expected {alpha}"
        );
        let kept = again.intersection(&expected).count();
        assert!(kept >= 290, "{scale}: {kept} of 300 records");
    }
}

/// A room of the assumed size gets what it would get if it were declared in metres.
#[test]
fn a_room_of_the_assumed_size_is_as_if_declared() {
    let diagonal = DVec3::new(6.0, 3.0, 8.0).length();
    let to_assumed = ASSUMED_DIAGONAL_M / diagonal;
    let (assumed, alpha, notes) = placed(room(None), to_assumed);
    let in_metres = room(None).transformed(to_assumed, 0.0, DVec3::ZERO);
    let in_metres = SceneDescription {
        metres_per_unit: Some(1.0),
        ..in_metres
    };
    let (declared, its_alpha, none) = placed(in_metres, 1.0);
    assert!((alpha - its_alpha).abs() < 1e-5);
    assert!(assumed.intersection(&declared).count() >= 297);
    assert!(none.is_empty(), "{none:?}");
    assert!(
        notes[0].contains("no metres_per_unit") && notes[0].contains("2.000 per diagonal"),
        "{notes:?}"
    );
}

#[test]
fn an_assumed_unit_is_told_and_a_declared_one_is_kept() {
    let build =
        |description| Scene::build(&description, Needs::GEOMETRY).unwrap_or_else(|e| panic!("{e}"));
    let told = |scene: &Scene| {
        scene
            .report
            .notes
            .iter()
            .any(|n| n.contains("metres_per_unit"))
    };
    let assumed = build(room(None));
    assert!(assumed.unit_is_assumed && told(&assumed));
    let diagonal_m = assumed.metres_per_unit * f64::from(assumed.diagonal);
    assert!((diagonal_m - ASSUMED_DIAGONAL_M).abs() < 1e-9);
    let declared = build(room(Some(0.1)));
    assert!(!declared.unit_is_assumed && !told(&declared));
    assert_eq!(declared.metres_per_unit, 0.1);
}

/// The shipped scenes are in metres and say so.
#[test]
fn shipped_scenes_declare_their_unit() {
    for name in lightbench::scene::shipped_scenes() {
        let description =
            lightbench::scene::find_scene_in(name, &[]).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(description.metres_per_unit, Some(1.0), "{name}");
    }
}
