//! The three levels of chunks against looking at every light.

use glam::Vec3;

use super::contributions::{Contributions, Detail};
use super::irradiance::Irradiance;
use super::lights::{LANES, LightArrays};
use super::selection::systematic;
use super::terms::Terms;
use crate::environment::{Environment, EnvironmentOptions, TexelLights, embedded_map};
use crate::image::luminance;
use crate::scene::{Needs, Scene, find_scene};
use crate::technique::{Film, Shot};
use crate::trace::{RayCounter, Tracer};
use crate::world::Moment;

/// Calls `look` with the lights of a map and scattering at points of a scene.
fn at_points(map: &str, count: usize, mut look: impl FnMut(&LightArrays, &Irradiance, &Terms)) {
    let image = embedded_map(map).expect("an embedded map");
    let map = Environment::from_image(&image, &EnvironmentOptions::default()).expect("a map");
    let lights = TexelLights::new(&map, count, 1);
    let arrays = LightArrays::new(&lights, 2.0);
    let irradiance = Irradiance::new(&arrays);
    let description = find_scene("still-glossy").expect("an embedded scene");
    let scene = Scene::build(&description, Needs::ALL).expect("a scene");
    let tracer = Tracer::new(&scene.positions, &scene.triangles);
    let film = Film {
        width: 16,
        height: 12,
        spp: 1,
    };
    let shot = Shot::new(Moment::still(&scene, &tracer), &scene.views[0], film);
    let counter = RayCounter::default();
    let caster = tracer.caster(&counter);
    let mut points = 0;
    for seen in (0..shot.pixels() as u32).filter_map(|pixel| shot.look(&caster, pixel, 0)) {
        let surface = shot.surface(&seen);
        look(&arrays, &irradiance, &Terms::new(&surface));
        points += 1;
    }
    assert!(points > 50, "{points}");
}

fn close(a: f32, b: f32, relative: f32) -> bool {
    (a - b).abs() <= relative * a.abs().max(b.abs())
}

#[test]
fn weights_of_parts_add_up_and_chosen_lights_follow_the_list() {
    let mut chosen = Vec::new();
    for (count, detail) in [
        (700, Detail::All),
        (700, Detail::Highlights(3e-4)),
        (3, Detail::Highlights(3e-4)),
    ] {
        let mut own = Contributions::default();
        at_points("loft", count, |lights, irradiance, terms| {
            own.evaluate(lights, irradiance, terms, detail);
            let of_chunks = |level: usize| -> f32 {
                let chunks = 0..lights.levels[level].len();
                let lanes = chunks.flat_map(|chunk| own.weights(lights, level, chunk));
                lanes.sum()
            };
            assert!(own.total() > 0.0);
            assert!(close(of_chunks(0), own.total(), 1e-4));
            assert!(close(of_chunks(1), own.total(), 1e-4));
            for rays in [1, 7, 64] {
                systematic(&own, lights, rays, 0.3, &mut chosen);
                assert_eq!(chosen.len(), rays);
                assert!(chosen.is_sorted_by_key(|c| c.light));
                for choice in &chosen {
                    let lanes = own.weights(lights, 0, choice.light / LANES);
                    assert_eq!(choice.weight, lanes[choice.light % LANES]);
                    assert!(choice.weight > 0.0 && (0.0..1.0).contains(&choice.within));
                }
            }
        });
    }
}

#[test]
fn what_is_not_opened_changes_the_unshadowed_light_little() {
    let (mut all, mut some) = (Contributions::default(), Contributions::default());
    let (mut sum, mut error) = (0.0, 0.0);
    at_points("loft", 2048, |lights, irradiance, terms| {
        all.evaluate(lights, irradiance, terms, Detail::All);
        some.evaluate(lights, irradiance, terms, Detail::Highlights(3e-4));
        let unshadowed = |of: &Contributions| of.unshadowed[0] + of.unshadowed[1];
        let (exact, near) = (unshadowed(&all), unshadowed(&some));
        let (a, b) = (luminance(exact.into()), luminance(near.into()));
        assert!(close(a, b, 0.1), "{a} {b}");
        sum += a;
        error += (a - b).abs();
    });
    assert!(error < 0.02 * sum, "{error} of {sum}");
}

#[test]
fn a_black_map_has_no_lights_to_choose() {
    let mut own = Contributions::default();
    let mut chosen = Vec::new();
    at_points("black", 64, |lights, irradiance, terms| {
        own.evaluate(lights, irradiance, terms, Detail::All);
        assert_eq!((own.total(), own.unshadowed), (0.0, [Vec3::ZERO; 2]));
        systematic(&own, lights, 4, 0.5, &mut chosen);
        assert!(chosen.is_empty());
    });
}
