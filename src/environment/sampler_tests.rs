//! What every sampler must do on every map, listed or not when this was written.

use glam::{DMat4, DVec3, Vec3};

use super::{
    Environment, EnvironmentOptions, EnvironmentSampler, Light, LightKind, LightSampler, LightSet,
};
use crate::environment::ENVIRONMENT_SAMPLERS;
use crate::image::Image;

fn samplers() -> Vec<(&'static str, Box<dyn LightSampler>)> {
    ENVIRONMENT_SAMPLERS
        .iter()
        .filter_map(
            |entry| match (entry.build)(&toml::Table::new()).expect("defaults are valid") {
                EnvironmentSampler::Lights(sampler) => Some((entry.about.id, sampler)),
                EnvironmentSampler::PerPoint(_) | EnvironmentSampler::Product { .. } => None,
            },
        )
        .collect()
}

fn image(width: usize, height: usize, f: impl Fn(usize, usize) -> [f32; 3]) -> Image {
    Image {
        width,
        height,
        pixels: (0..width * height)
            .map(|i| f(i % width, i / width))
            .collect(),
    }
}

fn spot(size: (usize, usize), at: (usize, usize), surround: f32) -> Image {
    image(size.0, size.1, |x, y| {
        if (x, y) == at {
            [3e4, 2e4, 1e4]
        } else {
            [surround; 3]
        }
    })
}

/// Waves with a few bright patches, nothing symmetric.
pub(super) fn rich(width: usize, height: usize) -> Image {
    image(width, height, |x, y| {
        let (u, v) = (x as f32 / width as f32, y as f32 / height as f32);
        let wave = 1.2 + (9.0 * u + 3.0 * v).sin() * (7.0 * v).cos();
        let patch = |cu: f32, cv: f32, r: f32| f32::from((u - cu).hypot(v - cv) < r);
        let bright = 60.0 * patch(0.3, 0.25, 0.03) + 25.0 * patch(0.8, 0.4, 0.05);
        [
            wave + bright,
            0.8 * wave + bright,
            0.5 * wave + 0.7 * bright,
        ]
    })
}

/// Name, map.
pub(super) fn maps() -> Vec<(&'static str, Image)> {
    let mut broken = rich(24, 12);
    broken.pixels[5] = [f32::NAN, 1.0, 1.0];
    broken.pixels[60] = [f32::INFINITY, 2.0, -3.0];
    broken.pixels[61] = [-1.0; 3];
    vec![
        ("black", Image::new(16, 8)),
        ("constant", image(32, 16, |_, _| [0.7, 0.8, 0.9])),
        ("pole", spot((32, 16), (9, 0), 0.0)),
        ("seam", spot((32, 16), (31, 7), 0.0)),
        ("antipodes", {
            let mut both = spot((32, 16), (3, 5), 0.0);
            both.pixels[10 * 32 + 19] = both.pixels[5 * 32 + 3];
            both
        }),
        ("3×2", rich(3, 2)),
        ("1×1", image(1, 1, |_, _| [2.0, 1.0, 0.5])),
        ("1×9", rich(1, 9)),
        ("9×1", rich(9, 1)),
        ("not twice as wide", rich(20, 31)),
        ("broken", broken),
        ("sun", spot((64, 32), (20, 9), 1e-2)),
        ("rich", rich(128, 64)),
    ]
}

pub(super) fn environment(image: &Image) -> Environment {
    let options = EnvironmentOptions::default();
    Environment::from_image(image, &options).expect("a map")
}

fn check(context: &str, map: &Environment, set: &LightSet, count: usize) {
    assert!(set.lights.len() <= count, "{context}: too many lights");
    for light in &set.lights {
        assert!(
            (light.direction.length() - 1.0).abs() < 1e-5,
            "{context}: {light:?}"
        );
        assert!(
            light.power.iter().all(|p| p.is_finite() && *p >= 0.0)
                && light.power.iter().any(|p| *p > 0.0),
            "{context}: {light:?}"
        );
        let extent = f64::from(light.extent_rad);
        assert!(
            (0.0..=std::f64::consts::PI + 1e-6).contains(&extent),
            "{context}: {light:?}"
        );
    }
    let expected = map.total_power();
    for (found, expected) in set.total_power().into_iter().zip(expected) {
        assert!(
            (found - expected).abs() <= 1e-4 * expected,
            "{context}: power {found} instead of {expected}"
        );
    }
}

/// Shadow rays a pixel when indirect lights cost a quarter at reduced resolution.
fn cost_of(light: &Light, sampler: &dyn LightSampler) -> f64 {
    match light.kind {
        LightKind::Indirect if sampler.reduction() > 1 => 0.25,
        _ => 1.0,
    }
}

#[test]
fn lights_are_sound_and_keep_the_power_of_any_map() {
    for (map_name, image) in maps() {
        let map = environment(&image);
        let black = map.total_power() == [0.0; 3];
        for (id, sampler) in samplers() {
            assert!(sampler.lights(&map, 0, 1).lights.is_empty());
            for count in [1, 2, 7, 16, 64] {
                let context = format!("{id} on {map_name}, {count} lights");
                let set = sampler.lights(&map, count, 3);
                check(&context, &map, &set, count);
                assert_eq!(set.lights.is_empty(), black, "{context}");
                let within = sampler.lights_within(&map, count, 0.25, 3);
                check(&context, &map, &within, 4 * count);
                let cost: f64 = within
                    .lights
                    .iter()
                    .map(|l| cost_of(l, sampler.as_ref()))
                    .sum();
                assert!(cost <= count as f64, "{context}: {cost}");
            }
        }
    }
}

#[test]
fn maps_of_thirty_million_texels_and_a_sun_are_taken() {
    let (width, height) = (8192, 4096);
    let large = image(width, height, |x, y| {
        if (x as i32 - 2000).pow(2) + (y as i32 - 900).pow(2) < 20 * 20 {
            return [1e6, 9e5, 7e5];
        }
        [1.0 + (x / 512 % 2) as f32, 0.8, 0.5 + (y / 512 % 2) as f32]
    });
    let map = environment(&large);
    drop(large);
    for (id, sampler) in samplers() {
        check(id, &map, &sampler.lights(&map, 32, 1), 32);
    }
}

#[test]
fn large_budgets_are_used_where_the_map_has_much_to_give() {
    let map = environment(&rich(128, 64));
    for (id, sampler) in samplers() {
        for count in [5, 16, 48] {
            let found = sampler.lights(&map, count, 1).lights.len();
            assert!(found * 10 >= count * 9, "{id}: {found} of {count}");
        }
    }
}

#[test]
fn lamps_far_apart_keep_the_lights_of_the_decomposition() {
    let map = environment(&super::gallery::embedded_map("night-lamps").expect("embedded"));
    let all = samplers();
    let (_, decomposition) = all
        .iter()
        .find(|(id, _)| *id == "decomposition")
        .expect("listed");
    for (count, least) in [(16, 0.12), (32, 0.25)] {
        let set = decomposition.lights(&map, count, 1);
        let luminance = |light: &&Light| light.power.iter().sum::<f64>();
        let direct = set.lights.iter().filter(|l| l.kind == LightKind::Direct);
        let (found, power) = (
            direct.clone().count(),
            direct.map(|l| luminance(&l)).sum::<f64>(),
        );
        let share = power / set.lights.iter().map(|l| luminance(&l)).sum::<f64>();
        assert!(set.notes.is_empty(), "{count}: {:?}", set.notes);
        assert!(
            2 * found > count && share > least,
            "{count}: {found}, {share}"
        );
    }
}

#[test]
fn a_lonely_texel_gets_the_lights() {
    for (size, at) in [((32, 16), (9, 0)), ((32, 16), (31, 7)), ((33, 17), (0, 16))] {
        let map = environment(&spot(size, at, 0.0));
        let texel = map.texel_direction(at.0, at.1);
        for (id, sampler) in samplers() {
            let set = sampler.lights(&map, 8, 1);
            assert_eq!(set.lights.len(), 1, "{id}");
            let off = (set.lights[0].direction - texel).length();
            // Points of a tiling lie anywhere in the texel.
            let most = if id == "fhis" { 0.3 } else { 1e-5 };
            assert!(off < most, "{id}: {off} from the texel");
            assert!(set.lights[0].extent_rad < most, "{id}");
        }
    }
}

#[test]
fn the_seed_decides_alone() {
    let map = environment(&rich(64, 32));
    for (id, sampler) in samplers() {
        let lights = |seed| sampler.lights(&map, 16, seed).lights;
        assert_eq!(lights(5), lights(5), "{id}");
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .expect("a pool");
        assert_eq!(pool.install(|| lights(5)), lights(5), "{id}: threads");
    }
}

#[test]
fn turning_a_map_turns_its_lights() {
    let image = rich(64, 32);
    let plain = environment(&image);
    let turn = DMat4::from_axis_angle(DVec3::new(0.3, 0.8, -0.5).normalize(), 1.1);
    let options = EnvironmentOptions {
        to_world: turn,
        scale: 2.0,
        ..EnvironmentOptions::default()
    };
    let turned = Environment::from_image(&image, &options).expect("a map");
    for (id, sampler) in samplers() {
        let before = sampler.lights(&plain, 16, 2).lights;
        let after = sampler.lights(&turned, 16, 2).lights;
        assert_eq!(before.len(), after.len(), "{id}");
        for (a, b) in before.iter().zip(&after) {
            let carried = turn.transform_vector3(a.direction.as_dvec3()).as_vec3();
            assert!((carried - b.direction).length() < 1e-5, "{id}");
            assert!((2.0 * a.power[0] / b.power[0] - 1.0).abs() < 1e-4, "{id}");
        }
    }
}

/// Light that a diffuse surface of this normal gets without shadows.
fn irradiance(set: &LightSet, normal: Vec3) -> f64 {
    let lit = |l: &super::Light| f64::from(l.direction.dot(normal).max(0.0)) * l.power[1];
    set.lights.iter().map(lit).sum()
}

fn normals() -> Vec<Vec3> {
    (0..40)
        .map(|i| {
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / 40.0;
            let (sin, cos) = (2.399_963 * i as f32).sin_cos();
            let r = (1.0 - y * y).sqrt();
            Vec3::new(r * cos, y, r * sin)
        })
        .collect()
}

#[test]
fn many_lights_converge_to_the_irradiance_of_the_map() {
    let map = environment(&rich(128, 64));
    let exact: Vec<f64> = normals()
        .into_iter()
        .map(|normal| {
            let mut sum = 0.0;
            for y in 0..64 {
                for x in 0..128 {
                    let cos = map.texel_direction(x, y).dot(normal).max(0.0);
                    sum += f64::from(cos * map.texel(x, y)[1]) * map.texel_solid_angle(y);
                }
            }
            sum
        })
        .collect();
    let scale = exact.iter().sum::<f64>() / exact.len() as f64;
    for (id, sampler) in samplers() {
        let error = |count: usize| {
            let set = sampler.lights(&map, count, 1);
            let square: f64 = normals()
                .into_iter()
                .zip(&exact)
                .map(|(n, e)| (irradiance(&set, n) - e).powi(2))
                .sum();
            (square / exact.len() as f64).sqrt() / scale
        };
        let (few, many) = (error(8), error(256));
        assert!(many < 0.02, "{id}: {many} with 256 lights");
        assert!(many < 0.5 * few, "{id}: {few} with 8, {many} with 256");
    }
}

/// Rolling the columns by half the width turns the map by 180°: samplers without a seam follow.
#[test]
fn rolling_the_columns_rolls_the_lights_of_seamless_samplers() {
    let (width, height) = (96, 48);
    let image = rich(width, height);
    let mut rolled = image.clone();
    for y in 0..height {
        for x in 0..width {
            rolled.pixels[y * width + (x + width / 2) % width] = image.pixels[y * width + x];
        }
    }
    let (plain, rolled) = (environment(&image), environment(&rolled));
    for (id, sampler) in samplers() {
        if ["fhis", "median-cut", "variance-minimization"].contains(&id) {
            continue;
        }
        let before = sampler.lights(&plain, 12, 1);
        let after = sampler.lights(&rolled, 12, 1);
        for normal in normals() {
            let opposite = Vec3::new(-normal.x, normal.y, -normal.z);
            let (a, b) = (irradiance(&before, normal), irradiance(&after, opposite));
            assert!((a - b).abs() <= 0.02 * a.max(b), "{id}: {a} and {b}");
        }
    }
}
