//! `compare`: all metrics of two images.

use super::args::CompareArgs;
use super::exit::{self, Failure};
use crate::image::{Encoding, Palette, false_color, read_coded, write_png_coded};
use crate::metric::{CompareOptions, Comparison, compare};

/// Prints the metrics and, with `--out`, writes the maps.
pub fn run(args: &CompareArgs) -> Result<u8, Failure> {
    if !(args.exposure > 0.0 && args.exposure.is_finite()) {
        return Err(Failure::usage("--exposure must be positive"));
    }
    let (reference, reference_coding) = read_coded(&args.reference)?;
    let (test, test_coding) = read_coded(&args.test)?;
    if reference_coding != test_coding {
        return Err(Failure::usage(format!(
            "{} and {} cannot be compared: one is display-referred (PNG, JPEG), the other linear (EXR, HDR)",
            args.reference.display(),
            args.test.display()
        )));
    }
    let mut options = CompareOptions {
        exposure: args.exposure,
        display_referred: reference_coding == Encoding::Srgb,
        maps: args.out.is_some(),
        ..CompareOptions::default()
    };
    if let Some(ppd) = args.ppd {
        options.pixels_per_degree = ppd;
    }
    let result = compare(&reference, &test, &options)?;
    if let Some(folder) = &args.out {
        write_maps(folder, &result)?;
    }
    let json = serde_json::to_value(&result)?;
    if args.json {
        println!("{json:#}");
    } else {
        for (key, value) in json.as_object().into_iter().flatten() {
            println!("{key:<20} {value}");
        }
    }
    Ok(exit::OK)
}

fn write_maps(folder: &std::path::Path, result: &Comparison) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)?;
    let maps = [
        ("flip_ldr.png", &result.flip_map),
        ("flip_hdr.png", &result.flip_hdr_map),
        ("error.png", &result.error_map),
    ];
    for (name, map) in maps {
        if let Some(map) = map {
            let top = if name == "error.png" {
                map.values.iter().copied().fold(0.0f32, f32::max).max(f32::MIN_POSITIVE)
            } else {
                1.0
            };
            write_png_coded(&folder.join(name), &false_color(map, (0.0, top), Palette::Magma))?;
        }
    }
    Ok(())
}
