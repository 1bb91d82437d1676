//! `compare`: all metrics of two images.

use super::args::CompareArgs;
use super::exit::{self, Failure};
use super::out::say;
use crate::image::{Palette, Plane, false_color, luminance, write_png_coded};
use crate::metric::{CompareOptions, Maps, compare_files};
use crate::standard_error::tell;

/// Prints the metrics and, with `--out`, writes the maps.
pub fn run(args: &CompareArgs) -> Result<u8, Failure> {
    if let Some(out) = args
        .out
        .as_ref()
        .filter(|out| out.exists() && !out.is_dir())
    {
        let message = format!(
            "--out {}: expected a folder for the maps, and this is a file",
            out.display()
        );
        return Err(Failure::usage(message));
    }
    let mut options = CompareOptions {
        exposure: args.exposure,
        maps: args.out.is_some(),
        ..CompareOptions::default()
    };
    if let Some(ppd) = args.ppd {
        options.pixels_per_degree = ppd;
    }
    let result = compare_files(&args.reference, &args.test, &options)?;
    if let (Some(folder), Some(maps)) = (&args.out, &result.maps) {
        write_maps(folder, maps)?;
    }
    for note in &result.notes {
        tell!("note: {note}");
    }
    let json = serde_json::to_value(&result)?;
    if args.json {
        say!("{json:#}");
    } else {
        for (key, value) in json.as_object().into_iter().flatten() {
            say!("{key:<20} {value}");
        }
    }
    Ok(exit::OK)
}

/// False-colour pictures: FLIP from 0 to 1, the error from 0 to its largest luminance.
fn write_maps(folder: &std::path::Path, maps: &Maps) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)?;
    let write = |name: &str, map: &Plane, top: f32| {
        write_png_coded(
            &folder.join(name),
            &false_color(map, [0.0, top], Palette::Magma),
        )
    };
    write("flip_ldr.png", &maps.flip_ldr, 1.0)?;
    if let Some(map) = &maps.flip_hdr {
        write("flip_hdr.png", map, 1.0)?;
    }
    let error = Plane {
        width: maps.error.width,
        height: maps.error.height,
        values: maps.error.pixels.iter().map(|p| luminance(*p)).collect(),
    };
    let top = error
        .values
        .iter()
        .copied()
        .fold(f32::MIN_POSITIVE, f32::max);
    write("error.png", &error, top)?;
    Ok(())
}
