//! Gradients against differences of irradiance, and the store's rules.

use glam::{DMat4, DVec3, Mat3, Quat, Vec3};

use super::record::{Evaluator, Record, Strata};
use super::store::{Metric, Placed, Store};
use crate::scene::{Material, Needs, Scene, SceneDescription, ShapeDescription, ShapeSource, View};
use crate::shade::Depths;
use crate::technique::{Film, Shot, Site};
use crate::trace::{RayCounter, Tracer};
use crate::world::Moment;

/// A lamp of side 1 over the floor of a black room of side 2.
fn lit_room() -> Scene {
    let mut lamp = ShapeDescription::new("lamp", ShapeSource::Rectangle);
    lamp.emission = Some([1.0, 2.0, 4.0]);
    lamp.to_world = DMat4::from_translation(DVec3::new(0.0, 0.5, 0.0))
        * DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2)
        * DMat4::from_scale(DVec3::splat(0.5));
    let mut room = ShapeDescription::new("room", ShapeSource::Cube);
    room.flip_normals = true;
    let eye = [DVec3::new(0.0, 0.0, 0.9), DVec3::ZERO, DVec3::Y];
    let description = SceneDescription {
        name: "room".into(),
        metres_per_unit: Some(1.0),
        views: vec![View::look_at("v", eye, 60.0, [4, 4])],
        materials: vec![Material::diffuse("black", [0.0; 3])],
        shapes: vec![room, lamp],
        ..SceneDescription::default()
    };
    Scene::build(&description, Needs::ALL).expect("room")
}

fn site(position: Vec3, normal: Vec3) -> Site {
    Site {
        position,
        normal,
        geometric_normal: Vec3::Y,
    }
}

#[test]
fn gradients_agree_with_differences() {
    let scene = lit_room();
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let film = Film {
        width: 4,
        height: 4,
        spp: 1,
    };
    let shot = Shot::new(Moment::still(&scene, &tracer), &scene.views[0], film);
    let evaluator = Evaluator {
        shot: &shot,
        strata: Strata::of(60_000),
        depths: Depths::up_to(1),
        seed: 1,
    };
    let counter = RayCounter::default();
    let at = |p: Vec3, n: Vec3| evaluator.evaluate(&site(p, n), 7, &counter);
    let p = Vec3::new(0.35, -1.0, 0.2) - scene.origin.as_vec3();
    let record = at(p, Vec3::Y);
    for axis in [Vec3::X, Vec3::Z, Vec3::new(0.6, 0.0, -0.8)] {
        let step = 0.04;
        let ahead = at(p + axis * step, Vec3::Y).irradiance;
        let behind = at(p - axis * step, Vec3::Y).irradiance;
        let measured = (ahead - behind) / (2.0 * step);
        let found = record.translation.transpose() * axis;
        // Along some directions the change is nearly nothing: errors count against the largest.
        let largest = record.translation.col(2).length();
        let error = (found.z - measured.z).abs() / largest;
        assert!(error < 0.1, "along {axis}: {found} {measured}, {largest}");

        let turn = 0.2f32;
        let about = Vec3::Y.cross(axis).normalize();
        let turned = |angle: f32| Quat::from_axis_angle(about, angle) * Vec3::Y;
        let measured = (at(p, turned(turn)).irradiance - at(p, turned(-turn)).irradiance) / 2.0;
        let found = record.rotation.transpose() * Vec3::Y.cross(turned(turn));
        let largest = record.rotation.col(2).length() * turn.sin();
        let error = (found.z - measured.z).abs() / largest;
        assert!(
            error < 0.05,
            "towards {axis}: {found} {measured}, {largest}"
        );
    }
}

fn placed(position: Vec3, radius: f32) -> Placed {
    Placed {
        record: Record {
            site: site(position, Vec3::Y),
            irradiance: Vec3::splat(position.x),
            rotation: Mat3::ZERO,
            translation: Mat3::ZERO,
            mean_distance: radius,
            least_distance: radius,
            non_finite: 0,
        },
        radius,
        limits: [0.01, 100.0],
        point: 0,
    }
}

#[test]
fn records_serve_within_their_radius_and_on_their_side() {
    for metric in [Metric::Ward, Metric::Tabellion] {
        let mut store = Store::new(metric, 0.5);
        store.insert(placed(Vec3::X, 1.0));
        let value = |p: Vec3, n: Vec3| store.interpolate(&site(p, n));
        assert_eq!(value(Vec3::X, Vec3::Y), Some(Vec3::ONE));
        assert!(value(Vec3::X * 1.2, Vec3::Y).is_some());
        assert_eq!(value(Vec3::X * 1.6, Vec3::Y), None, "beyond the radius");
        assert_eq!(value(Vec3::X, -Vec3::Y), None, "the other side");
        let in_front = Vec3::new(1.0, -0.1, 0.0);
        assert_eq!(value(in_front, Vec3::Y), None, "in front of the record");
    }
}

#[test]
fn radii_differ_by_no_more_than_the_distance() {
    let mut store = Store::new(Metric::Ward, 1.0);
    store.insert(placed(Vec3::ZERO, 5.0));
    store.insert(placed(Vec3::X, 0.5));
    store.insert(placed(Vec3::X * 1.2, 3.0));
    let radii: Vec<f32> = store.placed.iter().map(|p| p.radius).collect();
    assert_eq!(radii[..2], [1.5, 0.5]);
    assert!((radii[2] - 0.7).abs() < 1e-6, "{radii:?}");
}

#[test]
fn a_steep_gradient_limits_validity_and_darkness_does_not() {
    let mut record = placed(Vec3::X, 8.0).record;
    assert_eq!(record.validity(Metric::Ward), 8.0);
    record.translation = Mat3::from_cols(Vec3::X * 2.0, Vec3::ZERO, Vec3::ZERO);
    assert_eq!(record.validity(Metric::Ward), 0.5);
    record.irradiance = Vec3::ZERO;
    record.translation = Mat3::ZERO;
    assert_eq!(record.validity(Metric::Ward), 8.0);
}
