//! Scenes that break caches on surfaces, and what is left of them.

use glam::{DMat4, DVec3, Vec3};
use lightbench::environment::Environment;
use lightbench::scene::{
    Bsdf, ColourSource, MicrofacetDistribution, ShapeDescription, ShapeSource, View,
};
use lightbench::technique::Shot;

use super::{
    Built, SIZE, at, cones, direct, found, is_sound, lamp_room, lit_by, luminance, mean, point,
    rmse, room, seeded,
};

/// Centres of large texels around the foot of the block lie beneath it, where it is dark.
#[test]
fn texels_beneath_a_block_do_not_darken_the_floor_around_it() {
    let technique = direct();
    let built = Built::new(&lamp_room(0.3, 20.0));
    let truth = mean(&built.truth(technique.as_ref()));
    let [moved, kept] = ["moved", "kept"].map(|cut_off| {
        let text = format!("cut_off = '{cut_off}'\nbias = 2.0");
        let mut contender = cones(technique.as_ref(), &text);
        let first = built.play(contender.as_mut(), 0..1);
        let last = built.play(contender.as_mut(), 1..32);
        (found(&first, "moved_texels"), mean(&last.image) / truth)
    });
    assert!(moved.0 > 0.0 && kept.0 == 0.0);
    assert!(moved.1 > kept.1 && moved.1 < 1.0, "{moved:?} {kept:?}");
}

/// A sheet between a lamp above and darkness below is lit on one side.
#[test]
fn the_sides_of_a_thin_sheet_are_kept_apart() {
    let technique = direct();
    let mut description = lamp_room(0.3, 20.0);
    let eye = [DVec3::new(0.1, -2.0, 0.2), DVec3::ZERO, DVec3::X];
    description.views[1] = View::look_at("below", eye, 40.0, SIZE);
    let built = Built::new(&description);
    let mut contender = cones(technique.as_ref(), "");
    let images = contender
        .frame(&[built.seen(0, 0), built.seen(1, 0)])
        .expect("a frame");
    assert!(mean(&images[0].image) > 0.05);
    assert_eq!(mean(&images[1].image), 0.0);
}

#[test]
fn a_pool_without_room_shows_light_samples_instead_and_says_so() {
    let technique = direct();
    let built = Built::new(&lamp_room(0.3, 20.0));
    let truth = built.truth(technique.as_ref());
    for blocks in [0, 3] {
        let text = format!("most_blocks = {blocks}");
        let rendered = built.play(cones(technique.as_ref(), &text).as_mut(), 0..2);
        assert!(found(&rendered, "refused_blocks") > 0.0);
        assert!(found(&rendered, "blocks") <= f64::from(blocks));
        let uncached = found(&rendered, "uncached");
        assert!(
            uncached > 0.1 && (blocks > 0 || uncached > 0.5),
            "{uncached}"
        );
        assert!(rendered.notes[0].contains("most_blocks"));
        let off = mean(&rendered.image) / mean(&truth) - 1.0;
        assert!(off.abs() < 0.05, "{blocks} blocks: {off}");
    }
}

#[test]
fn scale_and_place_change_next_to_nothing() {
    let technique = direct();
    let image = |scale: f64, offset: f64| {
        let description = lamp_room(0.3, 20.0).transformed(scale, 0.0, DVec3::splat(offset));
        let built = Built::new(&description);
        let rendered = built.play(cones(technique.as_ref(), "").as_mut(), 0..12);
        assert!(is_sound(&rendered));
        rendered.image
    };
    let plain = image(1.0, 0.0);
    for (scale, offset) in [(1e-3, 0.0), (1e5, 0.0), (1.0, 1e4)] {
        let off = rmse(&image(scale, offset), &plain) / mean(&plain);
        assert!(off < 0.05, "{scale} {offset}: {off}");
    }
}

#[test]
fn hard_lights_leave_sound_images() {
    let technique = direct();
    let thousand = (0..1000).map(|i| {
        let angle = f64::from(i) * 0.7;
        point(
            [
                2.0 * angle.cos(),
                1.0 + 1e-3 * f64::from(i),
                2.0 * angle.sin(),
            ],
            0.01,
        )
    });
    let mut touching = lamp_room(0.3, 20.0);
    let mut glow = at(
        ShapeDescription::new("glow", ShapeSource::Cube),
        DMat4::from_translation(DVec3::new(-0.7, 0.2, 0.5)) * DMat4::from_scale(DVec3::splat(0.2)),
    );
    glow.emission = Some([3.0; 3]);
    touching.shapes.push(glow);
    let cases = [
        ("no light", room(), 0.0),
        (
            "behind the surface",
            lit_by([point([0.0, -1.0, 0.0], 5.0)]),
            0.0,
        ),
        ("in the surface", lit_by([point([0.0, 0.0, 0.5], 5.0)]), 0.0),
        ("a thousand", lit_by(thousand), 1.0),
        ("an emitter that touches", touching, 1.0),
    ];
    for (what, description, light) in cases {
        let built = Built::new(&description);
        let rendered = built.play(cones(technique.as_ref(), "").as_mut(), 0..10);
        assert!(is_sound(&rendered), "{what}");
        assert_eq!(rendered.non_finite, 0, "{what}");
        if light == 0.0 {
            // A light in the floor shines on the block's sides.
            let dark = what == "in the surface" || mean(&rendered.image) == 0.0;
            assert!(dark, "{what}: {}", mean(&rendered.image));
        } else {
            let truth = mean(&built.truth(technique.as_ref()));
            let off = mean(&rendered.image) / truth - 1.0;
            assert!(off.abs() < 0.12, "{what}: {off}");
        }
    }
}

/// However near texels are to it.
#[test]
fn a_wall_is_no_brighter_than_the_emitter_that_touches_it() {
    let technique = direct();
    let mut description = lamp_room(0.3, 20.0);
    let mut glow = at(
        ShapeDescription::new("glow", ShapeSource::Cube),
        DMat4::from_translation(DVec3::new(-0.7, 0.2, 0.5)) * DMat4::from_scale(DVec3::splat(0.2)),
    );
    glow.emission = Some([3.0; 3]);
    description.shapes.push(glow);
    let built = Built::new(&description);
    let brightest = (0..24).map(|seed| {
        let mut contender = seeded(technique.as_ref(), "bias = 1.0", seed);
        let image = built.play(contender.as_mut(), 0..6).image;
        let pixels = image.pixels.iter().map(|pixel| luminance(*pixel));
        pixels.fold(0.0, f32::max)
    });
    let brightest: Vec<f32> = brightest.collect();
    assert!(brightest.iter().all(|most| *most < 3.5), "{brightest:?}");
}

#[test]
fn a_sky_all_around_has_the_right_brightness_and_less_where_light_below_the_horizon_is_lost() {
    let technique = direct();
    let mut built = Built::new(&room());
    built.scene.environment = Some(Environment::constant([0.5, 0.6, 0.7]));
    let truth = mean(&built.truth(technique.as_ref()));
    let offs = ["lost", "renormalised"].map(|horizon| {
        let text = format!("horizon = '{horizon}'");
        let rendered = built.play(cones(technique.as_ref(), &text).as_mut(), 0..12);
        assert!(is_sound(&rendered));
        mean(&rendered.image) / truth - 1.0
    });
    // Cones as wide as the hemisphere lean over its rim, and the light of samples, most of which are high up, is spread all
    // over them.
    assert!(offs[0] < offs[1], "{offs:?}");
    assert!(offs.iter().all(|off| off.abs() < 0.08), "{offs:?}");
}

#[test]
fn light_that_is_not_a_number_is_left_out() {
    let technique = direct();
    let mut built = Built::new(&lamp_room(0.3, 20.0));
    built.scene.positions[3] = Vec3::splat(f32::NAN);
    let rendered = built.play(cones(technique.as_ref(), "").as_mut(), 0..2);
    assert!(is_sound(&rendered));
}

#[test]
fn viewers_of_nothing_ask_for_nothing() {
    let technique = direct();
    let mut description = lamp_room(0.3, 20.0);
    for view in &mut description.views {
        (view.forward, view.right) = (-view.forward, -view.right);
    }
    let built = Built::new(&description);
    let mut contender = cones(technique.as_ref(), "");
    let shots: Vec<Shot> = (0..16).map(|i| built.seen(i % 2, 0)).collect();
    let images = contender.frame(&shots).expect("a frame");
    assert_eq!(images.len(), 16);
    for rendered in &images {
        assert!(rendered.image.pixels.iter().all(|p| *p == [0.0; 3]));
        assert_eq!(found(rendered, "texels"), 0.0);
    }
    assert!(contender.frame(&[]).expect("no shot").is_empty());
}

/// Cones as wide as their lamp spread its light evenly: highlights keep their mean.
#[test]
fn highlights_keep_their_mean_and_most_of_their_shape() {
    let technique = direct();
    let mut description = lamp_room(0.2, 40.0);
    for alpha in [0.15, 0.3] {
        description.materials[0].bsdf = Bsdf::Conductor {
            eta: [0.0; 3],
            k: [0.0; 3],
            specular: ColourSource::Constant([0.8; 3]),
            alpha,
            distribution: MicrofacetDistribution::Ggx,
        };
        let built = Built::new(&description);
        let truth = built.truth(technique.as_ref());
        let mut order: Vec<usize> = (0..truth.pixels.len()).collect();
        order.sort_by(|a, b| luminance(truth.pixels[*b]).total_cmp(&luminance(truth.pixels[*a])));
        let brightest = &order[..order.len() / 10];
        let (mut signed, mut absolute, mut all) = (0.0, 0.0, 0.0);
        for seed in 0..4 {
            let mut contender = seeded(technique.as_ref(), "", seed);
            let image = built.play(contender.as_mut(), 0..48).image;
            for pixel in brightest {
                let [is, exact] = [&image, &truth].map(|of| luminance(of.pixels[*pixel]));
                signed += is - exact;
                absolute += (is - exact).abs();
                all += exact;
            }
        }
        let (signed, absolute) = (signed / all, absolute / all);
        assert!(
            signed.abs() < 0.04 && absolute < 0.06,
            "{alpha}: {signed} in the mean, {absolute} apart"
        );
    }
}
