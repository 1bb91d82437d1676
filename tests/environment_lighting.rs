//! Environment lighting against brute-force summation over the map, and what every sampler must do.

use glam::{DMat4, DVec3, Vec3};
use lightbench::environment::ENVIRONMENT_SAMPLERS;
use lightbench::environment::{Environment, EnvironmentOptions};
use lightbench::image::Image;
use lightbench::registry::technique;
use lightbench::sample::Rng;
use lightbench::scene::{
    Bsdf, ColourSource, Material, MicrofacetDistribution, Scene, SceneDescription,
    ShapeDescription, ShapeSource, View,
};
use lightbench::technique::{Choice, Film, Rendered, Shot, Technique, Terms, reference_pass};
use lightbench::trace::{RayCounter, Tracer};
use lightbench::world::Moment;

const SIZE: [usize; 2] = [12, 9];

fn shape(source: ShapeSource, to_world: DMat4, material: usize) -> ShapeDescription {
    ShapeDescription {
        to_world,
        material,
        ..ShapeDescription::new("shape", source)
    }
}

/// A floor with a glossy ball and a box.
fn still_life() -> SceneDescription {
    let glossy = Material {
        bsdf: Bsdf::Plastic {
            diffuse: ColourSource::Constant([0.5, 0.3, 0.2]),
            specular: [1.0; 3],
            ior: 1.5,
            alpha: 0.3,
            nonlinear: false,
            lossless: false,
            distribution: MicrofacetDistribution::Ggx,
        },
        ..Material::diffuse("glossy", [0.5; 3])
    };
    let flat = DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let cube = DMat4::from_translation(DVec3::new(-0.7, 0.4, 0.1))
        * DMat4::from_rotation_y(0.5)
        * DMat4::from_scale(DVec3::splat(0.4));
    let ball = ShapeSource::Sphere {
        centre: DVec3::new(0.6, 0.5, 0.0),
        radius: 0.5,
    };
    let eye = [
        DVec3::new(0.3, 1.6, 3.0),
        DVec3::new(0.0, 0.4, 0.0),
        DVec3::Y,
    ];
    SceneDescription {
        name: "test".into(),
        exposure: 1.0,
        metres_per_unit: Some(1.0),
        max_depth: 2,
        views: vec![View::look_at("v", eye, 50.0, SIZE)],
        materials: vec![Material::diffuse("grey", [0.7, 0.6, 0.5]), glossy],
        shapes: vec![
            shape(
                ShapeSource::Rectangle,
                flat * DMat4::from_scale(DVec3::splat(3.0)),
                0,
            ),
            shape(ShapeSource::Cube, cube, 0),
            shape(ball, DMat4::IDENTITY, 1),
        ],
        ..SceneDescription::default()
    }
}

fn map(width: usize, height: usize, value: impl Fn(usize, usize) -> [f32; 3]) -> Environment {
    let pixels = (0..width * height).map(|i| value(i % width, i / width));
    let image = Image {
        width,
        height,
        pixels: pixels.collect(),
    };
    let options = EnvironmentOptions {
        to_world: DMat4::from_rotation_y(0.7),
        ..EnvironmentOptions::default()
    };
    Environment::from_image(&image, &options).expect("a map")
}

/// Noise with a bright patch above the horizon.
fn noisy() -> Environment {
    map(16, 8, |x, y| {
        let mut rng = Rng::new(1, 2, (y * 16 + x) as u64, 0);
        let bright = if (4..6).contains(&x) && y == 2 {
            12.0
        } else {
            0.2
        };
        [0, 1, 2].map(|_| bright * (0.3 + rng.next_f32()))
    })
}

/// A scene under a map, with its technique.
struct Lit {
    scene: Scene,
    tracer: Tracer,
    technique: Box<dyn Technique>,
}

impl Lit {
    fn new(map: Environment, parameters: &str) -> Self {
        let entry = technique("environment-lighting").expect("registered");
        let parameters: toml::Table = parameters.parse().expect("toml");
        let technique = (entry.build)(&parameters).expect("parameters");
        let mut scene = Scene::build(&still_life(), technique.needs()).expect("scene");
        scene.environment = Some(map);
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        Self {
            scene,
            tracer,
            technique,
        }
    }

    fn shot(&self, spp: u32) -> Shot<'_> {
        let film = Film {
            width: SIZE[0],
            height: SIZE[1],
            spp,
        };
        let moment = Moment::still(&self.scene, &self.tracer);
        Shot::exposed_for(self.technique.as_ref(), moment, &self.scene.views[0], film)
    }

    fn render(
        &self,
        id: &str,
        parameters: &str,
        (budget, seed, spp): (usize, u64, u32),
    ) -> Rendered {
        let choice = Choice {
            method: id,
            parameters: &parameters.parse().expect("toml"),
            terms: Terms { budget, seed },
        };
        let technique = self.technique.as_ref();
        choice
            .still(technique, &self.shot(spp), None)
            .expect("renders")
    }

    /// Sums over `side`² points in each texel, with shadow rays.
    fn brute_force(&self, side: usize) -> Image {
        let shot = self.shot(1);
        let map = self.scene.environment.as_ref().expect("a map");
        let directions = directions(map, side);
        let counter = RayCounter::default();
        let caster = self.tracer.caster(&counter);
        let mut image = Image::new(SIZE[0], SIZE[1]);
        for (pixel, value) in (0u32..).zip(&mut image.pixels) {
            let seen = match shot.look_out(&caster, pixel, 0) {
                Ok(seen) => seen,
                Err(missed) => {
                    *value = map.radiance(missed.direction);
                    continue;
                }
            };
            let at = shot.paths.surfaces().interact(&seen.hit, seen.direction);
            let mut sum = [0.0f64; 3];
            for (direction, solid_angle) in &directions {
                let reflected = at.evaluate(*direction) * Vec3::from(map.radiance(*direction));
                let ray = shot.paths.lights().spawn(&at, *direction);
                if reflected != Vec3::ZERO && !caster.occluded(&ray) {
                    (0..3).for_each(|c| sum[c] += f64::from(reflected[c]) * solid_angle);
                }
            }
            *value = sum.map(|s| s as f32);
        }
        image
    }
}

/// Directions that divide every texel evenly, and their solid angles.
fn directions(map: &Environment, side: usize) -> Vec<(Vec3, f64)> {
    let (columns, rows) = (map.width() * side, map.height() * side);
    let turn = glam::DMat3::from_rotation_y(0.7);
    (0..columns * rows)
        .map(|i| {
            let (x, y) = (i % columns, i / columns);
            let theta = |y: f64| std::f64::consts::PI * y / rows as f64;
            let phi = std::f64::consts::TAU * (x as f64 + 0.5) / columns as f64;
            let (sin, cos) = theta(y as f64 + 0.5).sin_cos();
            let local = DVec3::new(phi.sin() * sin, cos, -phi.cos() * sin);
            let height = theta(y as f64).cos() - theta(y as f64 + 1.0).cos();
            let solid_angle = std::f64::consts::TAU / columns as f64 * height;
            ((turn * local).as_vec3().normalize(), solid_angle)
        })
        .collect()
}

const PLAIN: &str = "mean_luminance = 0.0";

fn mean(image: &Image) -> f64 {
    let sum: f64 = image.pixels.iter().flatten().map(|&v| f64::from(v)).sum();
    sum / (3 * image.pixels.len()) as f64
}

fn largest_difference(a: &Image, b: &Image) -> f32 {
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Renders with many seeds and compares the mean with the sum over texels, within its noise.
fn assert_unbiased(lit: &Lit, exact: &Image, id: &str, parameters: &str, budget: usize) {
    let context = format!("{id} `{parameters}`, {budget} samples");
    let render = |seed| lit.render(id, parameters, (budget, seed, 1));
    assert_mean(exact, &context, 288 / budget as u64, render);
}

/// The mean of images of some seeds is that of the truth.
fn assert_mean(exact: &Image, context: &str, passes: u64, render: impl Fn(u64) -> Rendered) {
    let mut sums = vec![[0.0f64; 2]; 3 * exact.pixels.len()];
    for seed in 0..passes {
        let rendered = render(seed);
        assert_eq!(rendered.non_finite, 0);
        for (sum, value) in sums.iter_mut().zip(rendered.image.pixels.iter().flatten()) {
            sum[0] += f64::from(*value);
            sum[1] += f64::from(*value).powi(2);
        }
    }
    let n = passes as f64;
    let (mut beyond, mut total, mut expected_total) = (0, 0.0, 0.0);
    let mut total_variance = 0.0;
    for ([sum, squares], expected) in sums.iter().zip(exact.pixels.iter().flatten()) {
        let expected = f64::from(*expected);
        let variance = (squares / n - (sum / n).powi(2)).max(0.0) / n;
        // The sum over texels is itself exact to a percent only.
        let z = (sum / n - expected) / (variance + (0.01 * expected).powi(2)).sqrt();
        beyond += usize::from(z.abs() > 3.5);
        total += sum / n;
        // The three channels of a pixel share their samples.
        total_variance += 3.0 * variance;
        expected_total += expected;
    }
    assert!(beyond * 50 <= sums.len(), "{context}: {beyond} values off");
    let ratio = total / expected_total;
    let most = 4.0 * total_variance.sqrt() / expected_total + 0.005;
    assert!((ratio - 1.0).abs() < most.min(0.08), "{context}: {ratio}");
}

#[test]
fn every_form_of_multiple_importance_sampling_is_unbiased() {
    let lit = Lit::new(noisy(), PLAIN);
    let exact = lit.brute_force(4);
    for parameters in ["", "stratified = false", "compensated = true"] {
        for budget in [1, 6] {
            // One sample is a light sample: not stratified, and compensated ones need surface samples.
            if parameters.is_empty() || budget > 1 {
                assert_unbiased(&lit, &exact, "mis", parameters, budget);
            }
        }
    }
}

/// The fourth frame: samples of those before are in it.
#[test]
fn reservoirs_of_the_unbiased_form_have_the_mean_of_a_map() {
    let lit = Lit::new(noisy(), PLAIN);
    let exact = lit.brute_force(4);
    let fourth = |method: &'static str| {
        let lit = &lit;
        move |seed: u64| {
            let terms = Terms { budget: 6, seed };
            let started = lit.technique.start(method, &toml::Table::new(), terms);
            let mut contender = started.expect("starts").contender;
            let mut last = Rendered::default();
            for frame in 0..4 {
                let mut shot = lit.shot(1);
                shot.frame = frame;
                let mut images = contender.frame(&[shot]).expect("a frame");
                last = images.pop().expect("one image");
            }
            last
        }
    };
    assert_mean(&exact, "restir-unbiased", 96, fourth("restir-unbiased"));
    // The biased forms are darker than that, and not by much.
    let total = |image: &Image| image.pixels.iter().flatten().sum::<f32>();
    for (method, least) in [("restir", 0.9), ("rtxdi", 0.9)] {
        let biased = fourth(method);
        let mean = (0..96).map(|seed| total(&biased(seed).image)).sum::<f32>() / 96.0;
        let part = mean / total(&exact);
        assert!(least < part && part < 0.995, "{method}: {part}");
    }
}

#[test]
fn product_sampling_without_ratio_is_unbiased() {
    let lonely = map(8, 4, |x, y| [if (x, y) == (3, 1) { 50.0 } else { 0.0 }; 3]);
    let few = map(3, 2, |x, y| [0.2 + (x + 2 * y) as f32; 3]);
    for environment in [noisy(), lonely, few] {
        let lit = Lit::new(environment, PLAIN);
        let exact = lit.brute_force(8);
        for (parameters, budget) in [("", 1), ("", 6), ("lights = 5", 6)] {
            assert_unbiased(&lit, &exact, "product-ratio-unbiased", parameters, budget);
        }
    }
}

#[test]
fn ratios_of_hard_maps_are_finite_and_right_on_average() {
    let sun = map(64, 32, |x, y| match (x, y) {
        (20, 9) => [1e6, 0.9e6, 0.8e6],
        _ => [1.0; 3],
    });
    let constant = map(8, 4, |_, _| [1.0; 3]);
    let pole = map(8, 4, |x, y| [if (x, y) == (7, 0) { 9.0 } else { 0.0 }; 3]);
    let below = map(8, 4, |_, y| [f32::from(u8::from(y == 3)); 3]);
    let single = map(1, 1, |_, _| [2.0, 1.0, 0.5]);
    let all = [noisy(), sun, constant, pole, below, single];
    for (index, environment) in all.into_iter().enumerate() {
        let lit = Lit::new(environment, PLAIN);
        let exact = lit.brute_force(6);
        for budget in [1, 4, 64] {
            let rendered = lit.render("product-ratio", "", (budget, 1, 2));
            assert_eq!(rendered.non_finite, 0);
            assert!(
                rendered
                    .image
                    .pixels
                    .iter()
                    .flatten()
                    .all(|v| v.is_finite() && *v >= 0.0)
            );
            let (found, expected) = (mean(&rendered.image), mean(&exact));
            assert!(
                (found - expected).abs() < 0.2 * expected + 1e-4,
                "map {index}, {budget} rays: {found} instead of {expected}"
            );
        }
    }
}

#[test]
fn the_reference_is_the_sum_over_texels() {
    let lit = Lit::new(
        noisy(),
        "mean_luminance = 0.0\nreference_samples = 512\nreference_passes = 2",
    );
    let exact = lit.brute_force(6);
    let shot = lit.shot(1);
    let function = lit.technique.shading_function(&shot);
    let counter = RayCounter::default();
    let (pass, non_finite) = reference_pass(function.as_ref(), &shot, 0, &counter);
    assert_eq!(non_finite, 0);
    assert!((mean(&pass) / mean(&exact) - 1.0).abs() < 0.01);
    let scale = mean(&exact) as f32;
    assert!(largest_difference(&pass, &exact) < 0.15 * scale);
}

#[test]
fn many_lights_of_any_sampler_converge_to_the_sum_over_texels() {
    let lit = Lit::new(noisy(), "mean_luminance = 0.0\ninterleaved_sets = 1");
    let exact = lit.brute_force(3);
    let error = |id: &str, budget: usize| {
        let image = lit.render(id, "", (budget, 1, 1)).image;
        let pairs = image
            .pixels
            .iter()
            .flatten()
            .zip(exact.pixels.iter().flatten());
        let square: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
        (square / (3 * exact.pixels.len()) as f64).sqrt() / mean(&exact)
    };
    for entry in ENVIRONMENT_SAMPLERS {
        let id = entry.about.id;
        let (few, many) = (error(id, 4), error(id, 100));
        // Lights have no extent while the lookup spreads each of the map's 128 texels over its
        // neighbours; and half-resolution light of so few pixels remains wrong.
        let most = if id == "decomposition" { 0.9 } else { 0.65 };
        assert!(many < most * few.max(0.2), "{id}: {few}, then {many}");
    }
}

#[test]
fn lights_of_a_constant_sky_stand_for_parts_of_it() {
    let lit = Lit::new(Environment::constant([1.0; 3]), PLAIN);
    let shot = lit.shot(16);
    let function = lit.technique.shading_function(&shot);
    let counter = RayCounter::default();
    let (exact, _) = reference_pass(function.as_ref(), &shot, 0, &counter);
    for entry in ENVIRONMENT_SAMPLERS {
        let id = entry.about.id;
        let rendered = lit.render(id, "", (64, 1, 1));
        if rendered.lights.is_none() {
            continue; // It chooses directions at each point, of any map alike.
        }
        let off = mean(&rendered.image) / mean(&exact) - 1.0;
        assert!(off.abs() < 0.1, "{id}: {off}");
        assert_eq!(rendered.notes, [""; 0], "{id}");
    }
}

#[test]
fn images_do_not_depend_on_the_number_of_threads() {
    let lit = Lit::new(noisy(), "");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one = one.expect("a pool");
    for entry in ENVIRONMENT_SAMPLERS {
        let render = || lit.render(entry.about.id, "", (6, 3, 2)).image;
        assert_eq!(one.install(render), render(), "{}", entry.about.id);
    }
}

#[test]
fn a_black_map_is_black_and_a_lonely_texel_is_not() {
    let black = Lit::new(map(8, 4, |_, _| [0.0; 3]), "");
    let texel = Lit::new(
        map(8, 4, |x, y| [if (x, y) == (3, 1) { 50.0 } else { 0.0 }; 3]),
        "",
    );
    for entry in ENVIRONMENT_SAMPLERS {
        let id = entry.about.id;
        let dark = black.render(id, "", (8, 1, 1));
        assert!(
            dark.image.pixels.iter().flatten().all(|v| *v == 0.0),
            "{id}"
        );
        let light = texel.render(id, "", (8, 1, 1));
        assert_eq!(light.non_finite, 0, "{id}");
        assert!(mean(&light.image) > 0.0, "{id}");
    }
}

#[test]
fn shadow_rays_keep_the_budget() {
    let lit = Lit::new(noisy(), "");
    let points: u64 = {
        let shot = lit.shot(2);
        let counter = RayCounter::default();
        let caster = lit.tracer.caster(&counter);
        let pixels = (SIZE[0] * SIZE[1]) as u32;
        (0..2 * pixels)
            .filter(|i| shot.look(&caster, i / 2, i % 2).is_some())
            .count() as u64
    };
    for entry in ENVIRONMENT_SAMPLERS {
        for budget in [1, 5, 16] {
            let rendered = lit.render(entry.about.id, "", (budget, 1, 2));
            // A grid of every second pixel has up to a row and a column more than a quarter.
            let most = points * budget as u64 * 12 / 10;
            assert!(
                rendered.rays.shadow <= most,
                "{}: {} rays of {most}",
                entry.about.id,
                rendered.rays.shadow
            );
        }
    }
}

#[test]
fn upsampling_serves_every_surface() {
    let lit = Lit::new(map(8, 4, |_, _| [1.0; 3]), PLAIN);
    let shot = lit.shot(1);
    let counter = RayCounter::default();
    let caster = lit.tracer.caster(&counter);
    let low = lit.render("decomposition", "", (64, 1, 1));
    let exact = lit.brute_force(4);
    for (pixel, (value, exact)) in (0u32..).zip(low.image.pixels.iter().zip(&exact.pixels)) {
        if shot.look(&caster, pixel, 0).is_some() {
            // So few pixels have odd neighbours, but none is black where there is light.
            assert!(value[0] > 0.05 * exact[0], "{pixel}: {value:?} {exact:?}");
        }
    }
    assert!((mean(&low.image) / mean(&exact) - 1.0).abs() < 0.15);
    let found = low.found.iter().find(|(k, _)| *k == "upsampling_fallbacks");
    assert!(found.is_some_and(|(_, share)| (0.0..=1.0).contains(share)));
}

#[test]
fn exposure_makes_maps_of_any_brightness_alike() {
    let scaled = |gain: f32| {
        let lit = Lit::new(
            map(16, 8, |x, y| [gain * (1.0 + ((x + 3 * y) % 5) as f32); 3]),
            "mean_luminance = 0.25",
        );
        lit.render("median-cut", "", (16, 1, 1)).image
    };
    let (dim, bright) = (scaled(1e-3), scaled(1e4));
    assert!(largest_difference(&dim, &bright) < 1e-3);
}
