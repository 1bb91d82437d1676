use glam::{DMat4, DVec3, Vec3};

use super::super::sampler_tests::{environment, maps, rich};
use super::super::{Environment, EnvironmentOptions};
use super::*;

#[test]
fn lights_of_any_map_keep_its_power_and_their_texels() {
    for (name, image) in maps() {
        let map = environment(&image);
        for count in [1, 2, 16, 512] {
            let context = format!("{name}, {count} lights");
            let lights = TexelLights::with_texels(&map, count, 1);
            let real = lights.set.lights.len();
            assert!(real <= count, "{context}: {real}");
            assert_eq!(
                lights.is_empty(),
                map.total_power() == [0.0; 3],
                "{context}"
            );
            assert!(lights.len().is_multiple_of(BLOCK), "{context}");
            // Lists of texels count with means of the bilinear lookup, which carries light of a
            // polar texel to larger ones: the power is that of the map without them only.
            let own = TexelLights::new(&map, count, 1).set.total_power();
            for (found, expected) in own.into_iter().zip(map.total_power()) {
                assert!(
                    (found - expected).abs() <= 1e-3 * expected,
                    "{context}: {found}"
                );
            }
            for (i, light) in lights.set.lights.iter().enumerate() {
                assert!(
                    (light.direction.length() - 1.0).abs() < 1e-5,
                    "{context}: {i}"
                );
                assert!(
                    light.power.iter().all(|p| p.is_finite() && *p >= 0.0),
                    "{context}: {i}"
                );
            }
            for light in 0..lights.len() {
                let lit = (0..3).any(|c| lights.power[c][light] > 0.0);
                let lists = lights.texels.as_ref().expect("kept");
                assert_eq!(lit, lists.count(light) > 0, "{context}: light {light}");
            }
        }
    }
}

#[test]
fn draws_of_a_light_have_its_power_and_stay_within_its_reach() {
    let map = environment(&rich(64, 32));
    let lights = TexelLights::with_texels(&map, 40, 1);
    for light in (0..lights.len()).filter(|&l| lights.moment[l] > 0.0) {
        let axis = Vec3::from([0, 1, 2].map(|c| lights.direction[c][light]));
        let steps = 2000;
        let mut sum = 0.0f64;
        for i in 0..steps {
            let u = (i as f32 + 0.5) / steps as f32;
            let v = [
                (i as f32 * 0.754_877_7).fract(),
                (i as f32 * 0.569_840_3).fract(),
            ];
            let sample = lights.sample(&map, light, u, v).expect("a texel");
            assert!(sample.pdf_sr > 0.0);
            sum += f64::from(map.radiance(sample.direction)[1] / sample.pdf_sr);
            let angle = axis.angle_between(sample.direction);
            assert!(angle <= lights.reach_rad[light] + 1e-3 || lights.reach_rad[light] > 1.57);
        }
        let expected = f64::from(lights.power[1][light]);
        let ratio = sum / f64::from(steps) / expected;
        assert!((ratio - 1.0).abs() < 0.05, "light {light}: {ratio}");
    }
}

#[test]
fn turning_a_map_turns_its_texel_lights() {
    let image = rich(64, 32);
    let turn = DMat4::from_axis_angle(DVec3::new(0.3, 0.8, -0.5).normalize(), 1.1);
    let options = EnvironmentOptions {
        to_world: turn,
        ..EnvironmentOptions::default()
    };
    let turned = Environment::from_image(&image, &options).expect("a map");
    let plain = environment(&image);
    let before = TexelLights::with_texels(&plain, 64, 2);
    let after = TexelLights::with_texels(&turned, 64, 2);
    assert_eq!(before.len(), after.len());
    let pairs = before.draws.iter().zip(&after.draws).enumerate();
    // Padding shines nowhere and is not turned.
    for (_, (a, b)) in pairs.filter(|(i, _)| before.moment[i / DRAWS] > 0.0) {
        let carried = turn.transform_vector3(a.as_dvec3()).as_vec3();
        assert!((carried - b).length() < 1e-5);
    }
    for (a, b) in before.set.lights.iter().zip(&after.set.lights) {
        let carried = turn.transform_vector3(a.direction.as_dvec3()).as_vec3();
        assert!((carried - b.direction).length() < 1e-5);
    }
    for light in (0..before.len()).filter(|&l| before.moment[l] > 0.0) {
        let draw = |lights: &TexelLights, map| {
            lights
                .sample(map, light, 0.3, [0.2, 0.7])
                .expect("a texel")
                .direction
        };
        let a = draw(&before, &plain);
        let carried = turn.transform_vector3(a.as_dvec3()).as_vec3();
        assert!((carried - draw(&after, &turned)).length() < 1e-5);
    }
}

#[test]
fn neighbours_in_the_list_are_neighbours_on_the_sphere() {
    let map = environment(&rich(128, 64));
    let lights = TexelLights::with_texels(&map, 512, 1).set.lights;
    let steps = lights.windows(2);
    let mean = steps
        .map(|pair| (pair[0].direction - pair[1].direction).length())
        .sum::<f32>()
        / lights.len() as f32;
    assert!(mean < 0.35, "{mean}");
}
