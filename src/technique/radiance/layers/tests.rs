use super::*;
use crate::sample::Rng;
use crate::technique::radiance::filter::FilterParameters;

const SIZE: [usize; 2] = [37, 19];

fn setting(smoothing: Smoothing) -> Setting {
    Setting {
        smoothing,
        filter: Filter::new(FilterParameters::default()),
        exposure: 1.0,
    }
}

fn wall(base: Vec3) -> LayerVertex {
    LayerVertex {
        normal: Vec3::Z,
        path_length: 4.0,
        albedo: Some(Vec3::new(0.5, 0.25, 0.0)),
        base,
        ..LayerVertex::default()
    }
}

/// Layers of what `vertices` gives for a pixel, first vertex first.
fn layers(depth: usize, vertices: impl Fn(usize, usize) -> Vec<LayerVertex> + Sync) -> Layers {
    let mut layers = Layers::new(SIZE[0], SIZE[1], depth);
    layers.fill(|mut row, y| {
        let mut used = 0;
        for x in 0..SIZE[0] {
            for (layer, vertex) in vertices(x, y).iter().enumerate() {
                row.put(layer, x, vertex);
                used = used.max(layer + 1);
            }
        }
        (used, ())
    });
    layers
}

fn close(image: &Image, value: impl Fn(usize, usize) -> [f32; 3]) {
    for (i, pixel) in image.pixels.iter().enumerate() {
        let expected = value(i % SIZE[0], i / SIZE[0]);
        for c in 0..3 {
            let off = (pixel[c] - expected[c]).abs();
            assert!(off < 1e-5, "pixel {i}: {pixel:?} instead of {expected:?}");
        }
    }
}

#[test]
fn even_light_stays_as_it_is_under_every_setting() {
    for smoothing in [Smoothing::Off, Smoothing::Plain, Smoothing::Layered] {
        let mut layers = layers(2, |_, _| vec![wall(Vec3::new(2.0, 4.0, 8.0))]);
        let (image, filled) = layers.image(&setting(smoothing));
        close(&image, |_, _| [1.0, 1.0, 0.0]);
        assert_eq!(filled, Filled::default());
    }
}

#[test]
fn a_chain_sends_back_emission_base_and_gloss() {
    let chain = |_, _| {
        let coated = LayerVertex {
            emission: Vec3::splat(0.1),
            gloss: Some(GlossVertex {
                light: Vec3::splat(0.2),
                throughput: Vec3::new(0.5, 0.5, 1.0),
                mirror: false,
            }),
            ..wall(Vec3::ONE)
        };
        let sky = LayerVertex {
            emission: Vec3::new(1.0, 2.0, 3.0),
            ..LayerVertex::default()
        };
        vec![coated, wall(Vec3::splat(2.0)), sky]
    };
    for smoothing in [Smoothing::Off, Smoothing::Plain, Smoothing::Layered] {
        let (image, _) = layers(3, chain).image(&setting(smoothing));
        // 0.1 + C · 1 + 0.2 + T · (C · 2); the wall behind has no gloss, so nothing comes of the sky behind it.
        close(&image, |_, _| [0.3 + 0.5 + 0.5, 0.3 + 0.25 + 0.25, 0.3]);
    }
}

#[test]
fn noise_is_smoothed_within_a_wall_and_not_across_its_edges() {
    let noisy = |x: usize, y: usize| {
        let mut rng = Rng::new(1, 2, (y * SIZE[0] + x) as u64, 0);
        Vec3::splat(0.9 + 0.2 * rng.next_f32())
    };
    let corner = |x: usize, y: usize| {
        let mut vertex = wall(noisy(x, y));
        if x >= 20 {
            vertex.normal = Vec3::X;
            vertex.base *= 0.2;
        }
        vec![vertex]
    };
    let (image, _) = layers(1, corner).image(&setting(Smoothing::Layered));
    for (i, pixel) in image.pixels.iter().enumerate() {
        let level = if i % SIZE[0] >= 20 { 0.1 } else { 0.5 };
        let off = (pixel[0] / level - 1.0).abs();
        assert!(off < 0.08, "pixel {i}: {off}");
    }
}

#[test]
fn lengths_albedo_and_luminance_stop_the_filter() {
    type Change = fn(&mut LayerVertex);
    let changes: [Change; 4] = [
        |v| v.path_length = 4.5,
        |v| v.segment = 1.0,
        |v| v.albedo = Some(Vec3::new(0.02, 0.02, 0.9)),
        |v| v.base *= 1e6,
    ];
    for change in changes {
        let halves = |x: usize, _| {
            let mut vertex = wall(Vec3::ONE);
            if x >= 20 {
                vertex.base = Vec3::splat(3.0);
                change(&mut vertex);
            }
            vec![vertex]
        };
        let (image, _) = layers(1, halves).image(&setting(Smoothing::Layered));
        let left = image.pixels[9 * SIZE[0] + 19][0];
        assert!((left - 0.5).abs() < 1e-4, "{left}");
    }
}

#[test]
fn reflections_in_mirrors_are_smoothed_in_their_own_layer_alone() {
    let mirrored = |x: usize, _| {
        let mirror = LayerVertex {
            albedo: None,
            segment: 2.0,
            gloss: Some(GlossVertex {
                light: Vec3::ZERO,
                throughput: Vec3::ONE,
                mirror: true,
            }),
            ..wall(Vec3::ZERO)
        };
        let seen = LayerVertex {
            albedo: Some(Vec3::splat(if x.is_multiple_of(2) { 0.2 } else { 0.8 })),
            ..wall(Vec3::ONE)
        };
        vec![mirror, seen]
    };
    let (image, _) = layers(2, mirrored).image(&setting(Smoothing::Layered));
    close(&image, |x, _| {
        [if x.is_multiple_of(2) { 0.2 } else { 0.8 }; 3]
    });
    let (plain, _) = layers(2, mirrored).image(&setting(Smoothing::Plain));
    let middle = plain.pixels[9 * SIZE[0] + 18][0];
    assert!((0.3..0.7).contains(&middle), "{middle}");
}

#[test]
fn holes_are_filled_from_neighbours_and_counted() {
    let holed = |x: usize, y: usize| {
        vec![LayerVertex {
            hole: x == 5 && y == 5,
            ..wall(Vec3::splat(if x == 5 && y == 5 { 100.0 } else { 1.0 }))
        }]
    };
    for smoothing in [Smoothing::Off, Smoothing::Layered] {
        let (image, filled) = layers(1, holed).image(&setting(smoothing));
        close(&image, |_, _| [0.5, 0.25, 0.0]);
        assert_eq!((filled.holes, filled.unfilled), (1, 0));
    }
    let all = |_, _| {
        vec![LayerVertex {
            hole: true,
            ..wall(Vec3::splat(2.0))
        }]
    };
    let (image, filled) = layers(1, all).image(&setting(Smoothing::Layered));
    close(&image, |_, _| [1.0, 0.5, 0.0]);
    assert_eq!(filled.unfilled, (SIZE[0] * SIZE[1]) as u64);
}

#[test]
fn layers_that_are_filled_again_keep_nothing_of_before() {
    let mut reused = layers(2, |_, _| vec![wall(Vec3::ONE), wall(Vec3::ONE)]);
    reused.image(&setting(Smoothing::Layered));
    reused.fill(|_, _| (0, ()));
    let (image, _) = reused.image(&setting(Smoothing::Layered));
    close(&image, |_, _| [0.0; 3]);
}

#[test]
fn an_image_without_pixels_is_no_panic() {
    let mut empty = Layers::new(0, 0, 3);
    empty.fill(|_, _| (1, ()));
    assert!(
        empty
            .image(&setting(Smoothing::Layered))
            .0
            .pixels
            .is_empty()
    );
}
