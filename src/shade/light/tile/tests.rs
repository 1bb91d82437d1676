use glam::{DMat4, DVec3};

use super::*;
use crate::environment::EnvironmentDescription;
use crate::scene::{
    LightKind, Material, Needs, Scene, SceneDescription, ShapeDescription, ShapeSource, View,
};
use crate::shade::PathTracer;
use crate::trace::{Hit, Tracer};

/// A floor under a round lamp, a point light, parallel light and a sky.
fn scene() -> Scene {
    let mut floor = ShapeDescription::new("floor", ShapeSource::Rectangle);
    floor.to_world = DMat4::from_scale(DVec3::splat(4.0));
    let ball = ShapeSource::Sphere {
        centre: DVec3::new(0.5, 0.2, 1.0),
        radius: 0.3,
    };
    let mut lamp = ShapeDescription::new("lamp", ball);
    lamp.emission = Some([20.0, 15.0, 10.0]);
    let eye = [DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y];
    let lights = [
        LightKind::Point {
            position: DVec3::new(-1.0, 0.0, 1.0),
            intensity: [2.0; 3],
        },
        LightKind::Directional {
            direction: DVec3::NEG_Z,
            irradiance: [1.0; 3],
        },
    ];
    let description = SceneDescription {
        views: vec![View::look_at("v", eye, 60.0, [8, 8])],
        materials: vec![Material::diffuse("grey", [0.5; 3])],
        shapes: vec![floor, lamp],
        lights: lights.into_iter().map(Into::into).collect(),
        environment: Some(EnvironmentDescription::Constant {
            radiance: [0.3, 0.4, 0.5],
        }),
        ..SceneDescription::default()
    };
    Scene::build(&description, Needs::ALL).expect("a scene")
}

#[test]
fn a_tile_is_one_place_after_another_bit_for_bit() {
    let scene = scene();
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let paths = PathTracer::new(&scene, &tracer);
    let lights = paths.lights();
    let show = |found: &dyn std::fmt::Debug| format!("{found:?}");
    for (place, count) in [(0.1, 100), (0.4, LANES), (0.7, 1), (0.2, 0)] {
        let hit = Hit {
            t: 1.0,
            u: place,
            v: 0.2,
            triangle: 0,
        };
        let at = paths.surfaces().interact(&hit, Vec3::NEG_Z);
        let tile = LightTile::new(lights, count, &mut Rng::new(7, 0, 0, 0));
        assert_eq!(tile.count(), count);
        assert_eq!(tile.parts().len(), count.div_ceil(LANES));
        let mut rng = Rng::new(7, 0, 0, 0);
        let offset = rng.next_f64();
        let (mut sent, mut lit) = (Sent::default(), 0);
        for number in 0..count {
            let choice = (number as f64 + offset) / count as f64;
            let chosen = lights.choose(choice, &mut rng).expect("something shines");
            let (part, lane) = (&tile.parts()[number / LANES], number % LANES);
            part.send(lights, &at, &mut sent);
            let found = Some(sent.at(lane)).filter(|light| light.irradiance != Vec3::ZERO);
            let expected = lights.unshadowed(&chosen.place, &at);
            assert_eq!(show(&found), show(&expected));
            assert_eq!(part.density()[lane], chosen.density);
            let expected = lights.arriving(&chosen.place, &at);
            assert_eq!(
                show(&tile.arriving(number, lights, &at, &sent)),
                show(&expected)
            );
            let is_triangle = matches!(chosen.place, LightPlace::Triangle(..));
            lit += u32::from(is_triangle && found.is_some());
            let normal = Vec3::new(0.6, 0.0, 0.8);
            let received = part.received(&sent, normal, &[1.0; LIGHT_GROUPS])[lane];
            let expected = sent.each(|light| {
                let cosine = light.direction.dot(normal).max(0.0);
                cosine * luminance(light.irradiance.into())
            })[lane];
            assert!((received - expected).abs() <= 1e-6 * expected, "{received}");
        }
        let density = tile.parts().iter().flat_map(|part| part.density());
        assert_eq!(density.filter(|density| **density > 0.0).count(), count);
        assert!(count < 100 || (5..60).contains(&lit), "{lit}");
    }
}

#[test]
fn a_tile_of_the_environment_holds_all_of_its_light_and_no_other() {
    let scene = scene();
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let paths = PathTracer::new(&scene, &tracer);
    let lights = paths.lights();
    let hit = Hit {
        t: 1.0,
        u: 0.3,
        v: 0.3,
        triangle: 0,
    };
    let at = paths.surfaces().interact(&hit, Vec3::NEG_Z);
    let tile = LightTile::of_environment(lights, 40, &mut Rng::new(3, 0, 0, 0));
    let (mut sent, mut sum) = (Sent::default(), Vec3::ZERO);
    for part in tile.parts() {
        part.send(lights, &at, &mut sent);
        for (lane, density) in part.density().iter().enumerate() {
            if *density > 0.0 {
                assert!(matches!(part.places()[lane], LightPlace::Environment(_)));
                sum += sent.at(lane).irradiance / *density;
            }
        }
    }
    let all = Vec3::new(0.3, 0.4, 0.5) * 4.0 * std::f32::consts::PI;
    assert!((sum / 40.0 - all).abs().max_element() < 0.01, "{sum} {all}");
}

/// Light of a polygon on a surface that is wholly below it, by Lambert's formula.
fn lambert(position: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    let sides = corners.iter().zip(next).map(|(a, b)| {
        let [a, b] = [a, b].map(|corner| (corner - position).normalize());
        a.angle_between(b) * a.cross(b).normalize().dot(normal)
    });
    0.5 * sides.sum::<f64>().abs()
}

#[test]
fn a_lamp_that_touches_a_floor_lights_it_as_it_should() {
    let mut floor = ShapeDescription::new("floor", ShapeSource::Rectangle);
    floor.to_world = DMat4::from_scale(DVec3::splat(4.0));
    // It stands on the floor and faces +x.
    let mut lamp = ShapeDescription::new("lamp", ShapeSource::Rectangle);
    let foot = DVec3::new(-0.5, 0.0, 1.0);
    lamp.to_world = DMat4::from_translation(foot)
        * DMat4::from_mat3(glam::DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X));
    lamp.emission = Some([1.0; 3]);
    let eye = [DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y];
    let description = SceneDescription {
        views: vec![View::look_at("v", eye, 60.0, [8, 8])],
        shapes: vec![floor, lamp],
        ..SceneDescription::default()
    };
    let scene = Scene::build(&description, Needs::ALL).expect("a scene");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let paths = PathTracer::new(&scene, &tracer);
    let lights = paths.lights();
    let tile = LightTile::new(lights, 4096, &mut Rng::new(5, 0, 0, 0));
    let corners: Vec<DVec3> = scene.positions[4..].iter().map(|p| p.as_dvec3()).collect();
    for distance in [1e-4, 1e-3, 0.03, 0.5, 1.5, 3.0, 4.0] {
        let hit = Hit {
            t: 1.0,
            u: 0.3,
            v: 0.2,
            triangle: 0,
        };
        let mut at = paths.surfaces().interact(&hit, Vec3::NEG_Z);
        at.position = scene.positions[4].with_y(0.1) + Vec3::X * distance;
        let (mut sent, mut sum, mut most) = (Sent::default(), 0.0, 0.0);
        for part in tile.parts() {
            part.send(lights, &at, &mut sent);
            let mut numbers = [0.0; LANES];
            let received = part.received(&sent, Vec3::Z, &[1.0; LIGHT_GROUPS]);
            assert!(part.over_density(&received, &mut numbers));
            for number in numbers {
                (sum, most) = (sum + number, f64::max(most, number));
            }
        }
        let exact = lambert(at.position.as_dvec3(), DVec3::Z, &corners);
        let mean = sum / 4096.0;
        assert!(
            (mean / exact - 1.0).abs() < 0.04,
            "{distance}: {mean} for {exact}"
        );
        // However near it is, no sample counts for much more than all of them together.
        assert!(most < 16.0 * exact, "{distance}: {most} of {exact}");
    }
}
