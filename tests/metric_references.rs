//! The metrics against official implementations, on the pairs of `$LIGHTBENCH_REFS/metrics`.
//!
//! Without `LIGHTBENCH_REFS` every test says that it is skipped.

use lightbench::image::{Plane, ToneCurve};
use lightbench::metric::{CompareOptions, Comparison, compare_files};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn references() -> Option<(PathBuf, Value)> {
    let folder =
        std::env::var_os("LIGHTBENCH_REFS").map(|path| PathBuf::from(path).join("metrics"));
    let Some(folder) = folder.filter(|folder| folder.join("official_values.json").exists()) else {
        println!("skipped: LIGHTBENCH_REFS is unset or holds no metrics/official_values.json");
        return None;
    };
    let text = std::fs::read_to_string(folder.join("official_values.json")).unwrap();
    Some((folder, serde_json::from_str(&text).unwrap()))
}

fn pairs(values: &Value, kind: &str) -> Vec<(String, Value)> {
    let pairs = values[kind].as_object().unwrap();
    pairs.iter().map(|(k, v)| (k.clone(), v.clone())).collect()
}

fn compare_pair(folder: &Path, name: &str, suffix: &str, options: &CompareOptions) -> Comparison {
    let file = |role: &str| folder.join(format!("{name}_{role}.{suffix}"));
    compare_files(&file("ref"), &file("test"), options).unwrap()
}

fn with_maps() -> CompareOptions {
    CompareOptions {
        maps: true,
        ..CompareOptions::default()
    }
}

/// The f32 values of a two-dimensional little-endian NumPy file.
fn read_npy(path: &Path) -> Vec<f32> {
    let bytes = std::fs::read(path).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let values = bytes[start..].chunks_exact(4);
    values
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
}

fn assert_map(name: &str, folder: &Path, map: &Plane) {
    let official = read_npy(&folder.join(format!("{name}_flipmap.npy")));
    assert_eq!(official.len(), map.values.len());
    let differences = official.iter().zip(&map.values).map(|(a, b)| (a - b).abs());
    let largest = differences.fold(0.0, f32::max);
    println!("{name}: largest difference of the FLIP maps {largest:e}");
    assert!(largest <= 1e-5, "{name}: FLIP map differs by {largest}");
}

fn assert_absolute(what: &str, ours: f64, official: &Value, tolerance: f64) {
    let official = official.as_f64().unwrap();
    println!("{what}: {ours} official {official}");
    assert!(
        (ours - official).abs() <= tolerance,
        "{what}: {ours} instead of {official}"
    );
}

fn assert_relative(what: &str, ours: f64, official: &Value) {
    let value = official.as_f64().unwrap();
    assert_absolute(what, ours, official, 1e-5 * value.abs().max(1e-12));
}

#[test]
fn display_referred_pairs_agree() {
    let Some((folder, values)) = references() else {
        return;
    };
    for (name, official) in pairs(&values, "ldr") {
        let ours = compare_pair(&folder, &name, "png", &with_maps());
        let label = |metric: &str| format!("{name} {metric}");
        assert_absolute(
            &label("flip"),
            ours.flip_ldr,
            &official["flip_map_mean_f64"],
            1e-4,
        );
        assert_map(&name, &folder, &ours.maps.unwrap().flip_ldr);
        assert_relative(&label("mse"), ours.rmse * ours.rmse, &official["mse"]);
        assert_relative(&label("ssim"), ours.ssim, &official["ssim_rgb_skimage"]);
        let luma = &official["ssim_lum709_of_srgb_skimage"];
        assert_relative(&label("ssim luma"), ours.ssim_luma, luma);
        match ours.psnr {
            Some(psnr) => assert_absolute(&label("psnr"), psnr, &official["psnr"], 1e-4),
            None => assert!(official["psnr"].is_null(), "{name}"),
        }
        assert!(ours.flip_hdr.is_none() && ours.display_referred);
        if official.get("msssim_pytorch_msssim_port_rgb").is_some() {
            assert_eq!(ours.ms_ssim_scales, 5);
            let rgb = &official["msssim_pytorch_msssim_port_rgb"];
            assert_relative(&label("ms-ssim"), ours.ms_ssim, rgb);
            let luma = &official["msssim_pytorch_msssim_port_lum"];
            assert_relative(&label("ms-ssim luma"), ours.ms_ssim_luma, luma);
        }
    }
}

#[test]
fn another_observer_agrees() {
    let Some((folder, values)) = references() else {
        return;
    };
    let options = CompareOptions {
        pixels_per_degree: 40.0,
        ..CompareOptions::default()
    };
    for (name, official) in pairs(&values, "ldr") {
        let ours = compare_pair(&folder, &name, "png", &options);
        // The official mean is summed in f32, which costs up to 5.5e-4.
        let what = format!("{name} flip at 40 pixels per degree");
        assert_absolute(&what, ours.flip_ldr, &official["flip_mean_ppd40"], 6e-4);
    }
}

#[test]
fn linear_pairs_agree_for_every_tone_curve() {
    let Some((folder, values)) = references() else {
        return;
    };
    for (name, official) in pairs(&values, "hdr") {
        for curve in ToneCurve::ALL {
            let options = CompareOptions {
                tone_curve: curve,
                ..with_maps()
            };
            let ours = compare_pair(&folder, &name, "exr", &options);
            let key = if curve == ToneCurve::Aces {
                "ACES".to_owned()
            } else {
                curve.to_string()
            };
            let label = |metric: &str| format!("{name} {key} {metric}");
            let mean = &official[format!("flip_map_mean_f64_{key}")];
            assert_absolute(&label("flip"), ours.flip_hdr.unwrap(), mean, 1e-6);
            let range = &official[format!("params_{key}")];
            let (start, stop) = (ours.flip_start_exposure, ours.flip_stop_exposure);
            assert_absolute(
                &label("start"),
                start.unwrap(),
                &range["startExposure"],
                1e-5,
            );
            assert_absolute(&label("stop"), stop.unwrap(), &range["stopExposure"], 1e-5);
            let count = ours.flip_exposures.unwrap() as f64;
            assert_absolute(&label("exposures"), count, &range["numExposures"], 0.0);
            if curve == ToneCurve::Aces {
                assert_map(
                    &name,
                    &folder,
                    ours.maps.unwrap().flip_hdr.as_ref().unwrap(),
                );
                assert_relative(&label("rmse"), ours.rmse, &official["rmse"]);
                assert_relative(&label("mae"), ours.mae, &official["mae"]);
                assert_relative(&label("relmse"), ours.relmse, &official["relmse_eps1e-2"]);
            }
        }
    }
}
