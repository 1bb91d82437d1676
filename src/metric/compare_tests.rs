use super::*;

fn noise(width: usize, height: usize, seed: u32) -> Image {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mut image = Image::new(width, height);
    for pixel in &mut image.pixels {
        *pixel = [next(), next() * 2.0, next() * 0.5];
    }
    image
}

fn constant(width: usize, height: usize, value: f32) -> Image {
    let mut image = Image::new(width, height);
    image.pixels.fill([value; 3]);
    image
}

fn assert_sane(comparison: &Comparison, what: &str) {
    let json = serde_json::to_value(comparison).unwrap();
    let optional = [
        "psnr",
        "flip_hdr",
        "flip_start_exposure",
        "flip_stop_exposure",
        "flip_exposures",
        "mean_error",
    ];
    for (key, value) in json.as_object().unwrap() {
        let allowed = optional.contains(&key.as_str()) && value.is_null();
        let fine = value.as_f64().is_none_or(f64::is_finite) && !value.is_null();
        assert!(allowed || fine, "{what}: {key} is {value}");
    }
    for flip in [Some(comparison.flip_ldr), comparison.flip_hdr]
        .into_iter()
        .flatten()
    {
        assert!((0.0..=1.0).contains(&flip), "{what}: FLIP {flip}");
    }
    assert!(
        comparison.ssim <= 1.0 + 1e-12 && comparison.ms_ssim <= 1.0 + 1e-12,
        "{what}"
    );
}

#[test]
fn the_first_ten_keys_are_the_contract() {
    let comparison = compare(&noise(8, 8, 1), &noise(8, 8, 2), &CompareOptions::default()).unwrap();
    let json = serde_json::to_value(&comparison).unwrap();
    let keys: Vec<_> = json.as_object().unwrap().keys().take(10).cloned().collect();
    let contract = "rmse relmse psnr ssim ms_ssim flip_ldr flip_hdr flip_start_exposure \
                    flip_stop_exposure non_finite";
    assert_eq!(keys.join(" "), contract);
}

#[test]
fn equal_images_have_no_error_at_any_size_or_content() {
    for (width, height) in [
        (1, 1),
        (1, 50),
        (50, 1),
        (2, 3),
        (11, 10),
        (37, 23),
        (70, 67),
    ] {
        let contents = [
            noise(width, height, 7),
            constant(width, height, 0.0),
            constant(width, height, 0.5),
            constant(width, height, 1e30),
        ];
        for image in contents {
            let same = compare(&image, &image, &CompareOptions::default()).unwrap();
            let what = format!("{width}x{height}");
            assert_sane(&same, &what);
            assert_eq!(
                (same.rmse, same.psnr, same.flip_ldr),
                (0.0, None, 0.0),
                "{what}"
            );
            assert_eq!(same.flip_hdr, Some(0.0), "{what}");
            assert!((same.ssim - 1.0).abs() < 1e-12, "{what}: {}", same.ssim);
        }
    }
}

#[test]
fn every_pair_of_hard_images_gives_finite_results() {
    let (width, height) = (13, 9);
    let mut broken = noise(width, height, 3);
    broken.pixels[5] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    broken.pixels[6] = [-1.0; 3];
    let mut mostly_black = constant(width, height, 0.0);
    mostly_black.pixels[3] = [1e-40, 0.0, 5.0];
    let images = [
        noise(width, height, 4),
        constant(width, height, 0.0),
        constant(width, height, f32::MAX),
        constant(width, height, f32::MIN_POSITIVE),
        constant(width, height, f32::NAN),
        constant(width, height, f32::INFINITY),
        broken,
        mostly_black,
    ];
    for (i, reference) in images.iter().enumerate() {
        for (j, test) in images.iter().enumerate() {
            for display_referred in [false, true] {
                for tone_curve in ToneCurve::ALL {
                    let options = CompareOptions {
                        display_referred,
                        tone_curve,
                        maps: true,
                        ..CompareOptions::default()
                    };
                    let result = compare(reference, test, &options).unwrap();
                    assert_sane(&result, &format!("{i} against {j}, {tone_curve}"));
                    let maps = result.maps.unwrap();
                    assert!(maps.flip_ldr.values.iter().all(|v| (0.0..=1.0).contains(v)));
                }
            }
        }
    }
}

#[test]
fn non_finite_pixels_are_counted_in_both_images() {
    let clean = noise(6, 6, 1);
    let mut broken = clean.clone();
    broken.pixels[1][0] = f32::NAN;
    broken.pixels[2] = [f32::INFINITY; 3];
    broken.pixels[3][2] = -0.5;
    let counts = |a: &Image, b: &Image| {
        let result = compare(a, b, &CompareOptions::default()).unwrap();
        (result.non_finite, result.negative)
    };
    assert_eq!(counts(&clean, &broken), (2, 1));
    assert_eq!(counts(&broken, &broken), (4, 2));
    assert_eq!(counts(&clean, &clean), (0, 0));
}

#[test]
fn black_reference_and_bright_test_is_an_error_not_a_failure() {
    let result = compare(
        &constant(9, 9, 0.0),
        &constant(9, 9, 4.0),
        &CompareOptions::default(),
    )
    .unwrap();
    assert_eq!(result.flip_start_exposure, Some(0.0));
    assert!(result.flip_hdr.unwrap() > 0.9);
}

#[test]
fn sizes_and_options_are_checked_with_advice() {
    let options = CompareOptions::default();
    let message = compare(&Image::new(4, 3), &Image::new(3, 4), &options)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("4x3") && message.contains("3x4"),
        "{message}"
    );
    assert!(compare(&Image::new(0, 0), &Image::new(0, 0), &options).is_err());
    for pixels_per_degree in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let options = CompareOptions {
            pixels_per_degree,
            ..CompareOptions::default()
        };
        assert!(compare(&Image::new(1, 1), &Image::new(1, 1), &options).is_err());
    }
}

#[test]
fn exposure_moves_the_display_metrics_only() {
    let (reference, test) = (noise(20, 20, 5), noise(20, 20, 6));
    let darker = CompareOptions {
        exposure: -3.0,
        ..CompareOptions::default()
    };
    let plain = compare(&reference, &test, &CompareOptions::default()).unwrap();
    let dark = compare(&reference, &test, &darker).unwrap();
    assert_eq!((plain.rmse, plain.relmse), (dark.rmse, dark.relmse));
    assert_eq!(plain.flip_hdr, dark.flip_hdr);
    assert!(dark.psnr > plain.psnr && dark.flip_ldr != plain.flip_ldr);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let (reference, test) = (noise(150, 170, 8), noise(150, 170, 9));
    let options = CompareOptions {
        maps: true,
        ..CompareOptions::default()
    };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| compare(&reference, &test, &options).unwrap())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn files_choose_what_is_compared() {
    let folder = tempfile::tempdir().unwrap();
    let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
    let image = noise(12, 12, 1);
    crate::image::write_png(&png, &image, 0.0).unwrap();
    let layers = [crate::image::Layer::color("beauty", image)];
    crate::image::write_exr(&exr, &layers, &crate::image::Attributes::new()).unwrap();
    let options = CompareOptions::default();
    let display = compare_files(&png, &png, &options).unwrap();
    assert!(display.display_referred && display.flip_hdr.is_none());
    let mixed = compare_files(&exr, &png, &options).unwrap();
    assert!(!mixed.display_referred && mixed.flip_hdr.is_some());
    assert!(compare_files(&exr, &folder.path().join("none.png"), &options).is_err());
}
