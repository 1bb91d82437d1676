//! Round trips through every format, and files that are damaged on purpose.

use super::*;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, FlatSamples, LayerAttributes, LineOrder,
    WritableImage, f16,
};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn picture(width: usize, height: usize) -> Image {
    let mut image = Image::new(width, height);
    for (i, pixel) in image.pixels.iter_mut().enumerate() {
        let t = i as f32 / (width * height) as f32;
        *pixel = [t, (t * 9.0).sin() * 0.5 + 0.5, 1.0 - t];
    }
    image
}

fn scratch(name: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

fn written(name: &str) -> (TempDir, PathBuf) {
    let (folder, path) = scratch(name);
    let image = picture(19, 7);
    let rgb: Vec<::image::Rgb<f32>> = image.pixels.iter().map(|&p| ::image::Rgb(p)).collect();
    match path.extension().unwrap().to_str().unwrap() {
        "exr" => write_exr(&path, &[Layer::color("beauty", image)], &Attributes::new()).unwrap(),
        "png" => write_png(&path, &image, 0.0).unwrap(),
        "hdr" => ::image::codecs::hdr::HdrEncoder::new(std::fs::File::create(&path).unwrap())
            .encode(&rgb, 19, 7)
            .unwrap(),
        _ => {
            let bytes: Vec<u8> = rgb
                .iter()
                .flat_map(|p| p.0.map(|v| (v * 255.0) as u8))
                .collect();
            ::image::RgbImage::from_raw(19, 7, bytes)
                .unwrap()
                .save(&path)
                .unwrap();
        }
    }
    (folder, path)
}

#[test]
fn layers_and_attributes_come_back_bit_for_bit() {
    let (_folder, path) = scratch("a.exr");
    let mut odd = picture(5, 3);
    odd.pixels[0] = [f32::NAN, f32::INFINITY, -1e-40];
    let flip = Plane {
        width: 5,
        height: 3,
        values: (0..15).map(|i| i as f32).collect(),
    };
    let layers = [
        Layer::color("beauty", odd.clone()),
        Layer::gray("flip", flip.clone()),
        Layer::color("error", picture(5, 3)),
    ];
    let mut attributes = Attributes::new();
    attributes.insert("scene".into(), "Treppenhaus – süd".into());
    attributes.insert("seed".into(), 17.into());
    attributes.insert("budget".into(), 0.25.into());
    write_exr(&path, &layers, &attributes).unwrap();
    let read_back = read_layers(&path).unwrap();
    assert_eq!(read_back.attributes, attributes);
    let names: Vec<_> = read_back.layers.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["", "error", "flip"]);
    assert_eq!(
        read_back.layer("flip").unwrap().samples,
        Samples::Gray(flip)
    );
    assert_eq!(read_back.layer("error"), Some(&layers[2]));
    let bits = |image: &Image| -> Vec<u32> {
        image.pixels.iter().flatten().map(|v| v.to_bits()).collect()
    };
    assert_eq!(bits(&read(&path).unwrap()), bits(&odd));

    let first = std::fs::read(&path).unwrap();
    write_exr(&path, &layers, &attributes).unwrap();
    assert_eq!(
        std::fs::read(&path).unwrap(),
        first,
        "equal input, equal bytes"
    );
}

#[test]
fn wrong_layers_are_refused_and_nothing_is_written() {
    let (folder, path) = scratch("a.exr");
    let color = |name: &str, width| Layer::color(name, Image::new(width, 2));
    let refused = [
        vec![],
        vec![color("a", 0)],
        vec![color("a", 2), color("b", 3)],
        vec![color("a", 2), color("b", 2), color("b", 2)],
        vec![color("a", 2), color("", 2)],
    ];
    for layers in refused {
        assert!(
            write_exr(&path, &layers, &Attributes::new()).is_err(),
            "{layers:?}"
        );
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Writes one channel per name with the exr crate itself, as other programs would.
fn write_foreign(path: &Path, names: &[&str], compression: Compression) {
    let values: Vec<f16> = (0..64 * 40)
        .map(|i| f16::from_f32(i as f32 / 512.0))
        .collect();
    let channels = names
        .iter()
        .map(|&name| AnyChannel::new(name, FlatSamples::F16(values.clone())))
        .collect();
    let encoding = exr::prelude::Encoding {
        compression,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let attributes = LayerAttributes::named("render");
    let channels = AnyChannels::sort(channels);
    let layer = exr::prelude::Layer::new((64, 40), attributes, encoding, channels);
    exr::prelude::Image::from_layer(layer)
        .write()
        .to_file(path)
        .unwrap();
}

#[test]
fn foreign_channel_names_and_compressions_are_read() {
    let (_folder, path) = scratch("foreign.exr");
    let lossy = [
        Compression::DWAA(None),
        Compression::DWAB(None),
        Compression::PIZ,
    ];
    for compression in lossy {
        for names in [
            &["R", "G", "B", "A"][..],
            &["ViewLayer.r", "ViewLayer.g", "ViewLayer.b"],
        ] {
            write_foreign(&path, names, compression);
            let image = read(&path).unwrap();
            assert_eq!((image.width, image.height), (64, 40));
            let error = (image.at(63, 39)[1] - 2559.0 / 512.0).abs();
            assert!(error < 0.1, "{compression:?}: {error}");
        }
    }
    for names in [&["Y"][..], &["depth"], &["Y", "Z"]] {
        write_foreign(&path, names, Compression::RLE);
        assert_eq!(
            read(&path).unwrap().at(3, 1),
            [67.0 / 512.0; 3],
            "{names:?}"
        );
    }
    write_foreign(&path, &["U", "V"], Compression::Uncompressed);
    let message = read(&path).unwrap_err().to_string();
    assert!(
        message.contains("U, V") && message.contains("foreign.exr"),
        "{message}"
    );
}

#[test]
fn display_referred_files_are_told_apart_and_decoded() {
    let (_folder, path) = written("a.png");
    let (coded, encoding) = read_coded(&path).unwrap();
    assert_eq!(encoding, Encoding::Srgb);
    let linear = read(&path).unwrap();
    for (i, expected) in picture(19, 7).pixels.iter().enumerate() {
        let stored = coded.pixels[i];
        assert_eq!(linear.pixels[i], stored.map(srgb_decode));
        for (stored, expected) in stored.iter().zip(expected) {
            assert!((stored - srgb_encode(*expected)).abs() <= 0.5001 / 255.0);
        }
    }
    assert_eq!(read_coded(&written("a.jpg").1).unwrap().1, Encoding::Srgb);
    assert_eq!(read_coded(&written("a.hdr").1).unwrap().1, Encoding::Linear);
    assert_eq!(read_coded(&written("a.exr").1).unwrap().1, Encoding::Linear);
}

#[test]
fn sixteen_bit_and_gray_png_are_read() {
    let (_folder, path) = scratch("gray.png");
    let gray = ::image::ImageBuffer::<::image::Luma<u16>, _>::from_raw(2, 1, vec![0u16, 40000]);
    gray.unwrap().save(&path).unwrap();
    let (image, _) = read_coded(&path).unwrap();
    assert_eq!(image.pixels, vec![[0.0; 3], [40000.0 / 65535.0; 3]]);
}

#[test]
fn radiance_values_survive_within_the_shared_exponent() {
    let (_folder, path) = written("a.hdr");
    for (read, expected) in read(&path)
        .unwrap()
        .pixels
        .iter()
        .zip(picture(19, 7).pixels)
    {
        let top = expected.iter().fold(0.0_f32, |a, &b| a.max(b));
        for c in 0..3 {
            assert!((read[c] - expected[c]).abs() <= top / 128.0 + 1e-6);
        }
    }
}

#[test]
fn files_cut_short_are_errors_that_name_the_file() {
    for name in ["a.exr", "a.hdr", "a.png"] {
        let (_folder, path) = written(name);
        let bytes = std::fs::read(&path).unwrap();
        for length in (0..bytes.len() - 12).step_by(7) {
            std::fs::write(&path, &bytes[..length]).unwrap();
            match read(&path) {
                Ok(_) => panic!("{name} cut to {length} of {} bytes was read", bytes.len()),
                Err(error) => assert!(error.to_string().contains(name), "{error}"),
            }
        }
    }
    let (_folder, path) = scratch("none.exr");
    assert!(read(&path).unwrap_err().to_string().contains("none.exr"));
}

#[test]
fn damaged_bytes_never_panic() {
    for name in ["a.exr", "a.hdr", "a.png", "a.jpg"] {
        let (_folder, path) = written(name);
        let bytes = std::fs::read(&path).unwrap();
        for position in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[position] ^= [0x01, 0x80, 0xff][position % 3];
            std::fs::write(&path, &damaged).unwrap();
            if let Ok(image) = read(&path) {
                assert_eq!(image.pixels.len(), image.width * image.height);
            }
        }
    }
}

/// Writes a grey picture of 64×40 at a place in a display window, as other programs would.
fn write_window(path: &Path, data: [i32; 2], display: ([i32; 2], [usize; 2])) {
    let values: Vec<f32> = (0..64 * 40).map(|i| 1.0 + i as f32).collect();
    let channels =
        ["R", "G", "B"].map(|name| AnyChannel::new(name, FlatSamples::F32(values.clone())));
    let mut attributes = LayerAttributes::named("render");
    attributes.layer_position = (data[0], data[1]).into();
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let encoding = exr::prelude::Encoding::UNCOMPRESSED;
    let layer = exr::prelude::Layer::new((64, 40), attributes, encoding, channels);
    let mut image = exr::prelude::Image::from_layer(layer);
    let ([x, y], [width, height]) = display;
    image.attributes.display_window = exr::prelude::IntegerBounds::new((x, y), (width, height));
    image.write().to_file(path).unwrap();
}

#[test]
fn data_windows_are_put_into_display_windows() {
    let (_folder, path) = scratch("a.exr");
    write_window(&path, [10, -5], ([0, 0], [100, 50]));
    let picture = read_picture(&path).unwrap();
    let image = &picture.image;
    assert_eq!((image.width, image.height), (100, 50));
    // Row 0 of the display window is row 5 of the data.
    assert_eq!(image.at(10, 0), [1.0 + 5.0 * 64.0; 3]);
    assert_eq!(image.at(73, 34), [64.0 * 40.0; 3]);
    for (x, y) in [(9, 0), (74, 0), (10, 35), (99, 49)] {
        assert_eq!(image.at(x, y), [0.0; 3], "{x} {y}");
    }
    let note = picture.window.unwrap();
    assert!(note.contains("64x40") && note.contains("100x50"), "{note}");
    write_window(&path, [-2, -2], ([0, 0], [60, 36]));
    assert_eq!(
        read(&path).unwrap().at(0, 0),
        [1.0 + 2.0 * 64.0 + 2.0; 3],
        "cut off"
    );
    write_window(&path, [7, 7], ([7, 7], [64, 40]));
    assert!(read_picture(&path).unwrap().window.is_none());
    write_window(&path, [0, 0], ([64, 0], [64, 40]));
    let message = read(&path).unwrap_err().to_string();
    assert!(
        message.contains("outside of its display window"),
        "{message}"
    );
    write_window(&path, [0, 0], ([0, 0], [30000, 30000]));
    let message = read(&path).unwrap_err().to_string();
    assert!(message.contains("30000x30000"), "{message}");
    write_window(&path, [0, 0], ([0, 0], [16_000_000, 1]));
    let message = read(&path).unwrap_err().to_string();
    assert!(message.contains("16000000x1"), "{message}");
}

#[test]
fn a_luminance_that_is_part_of_a_colour_is_no_picture() {
    let (_folder, path) = scratch("xyz.exr");
    for names in [&["X", "Y", "Z"][..], &["BY", "RY", "Y"]] {
        write_foreign(&path, names, Compression::RLE);
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains("save it as R, G and B"), "{message}");
    }
    write_foreign(&path, &["Y", "Z"], Compression::RLE);
    assert!(read(&path).is_ok(), "grey with a depth");
}

#[test]
fn headers_of_exr_files_promise_what_their_compression_can_hold() {
    let (_folder, path) = scratch("a.exr");
    for (compression, fits) in [
        (Compression::Uncompressed, false),
        (Compression::RLE, false),
        (Compression::ZIP16, false),
        (Compression::ZIP16, true),
    ] {
        let size = if fits { 40 } else { 4000 };
        write_foreign(&path, &["B", "G", "R"], compression);
        let mut bytes = std::fs::read(&path).unwrap();
        let (_, data) = attribute(&mut bytes, b"dataWindow\0box2i\0");
        let corner = |value: i32| value.to_le_bytes();
        if !fits {
            data[8..12].copy_from_slice(&corner(size - 1));
            data[12..16].copy_from_slice(&corner(size - 1));
        }
        std::fs::write(&path, &bytes).unwrap();
        match read(&path) {
            Ok(_) => assert!(fits, "{compression:?}"),
            Err(error) => {
                assert!(error.to_string().contains("too few"), "{error}");
                assert!(!fits, "{error}");
            }
        }
    }
}

/// Where the value of an attribute of an EXR file stands, and the bytes from there on.
fn attribute<'a>(bytes: &'a mut [u8], head: &[u8]) -> (usize, &'a mut [u8]) {
    let at = bytes.windows(head.len()).position(|part| part == head);
    let at = at.expect("the attribute") + head.len() + 4;
    (at, &mut bytes[at..])
}

#[test]
fn depth_alone_is_no_picture() {
    let (_folder, path) = scratch("z.exr");
    for names in [&["Z"][..], &["ViewLayer.Z"], &["A"]] {
        write_foreign(&path, names, Compression::RLE);
        let message = read(&path).unwrap_err().to_string();
        assert!(
            message.contains(&format!("found: {}", names[0])),
            "{message}"
        );
    }
}

#[test]
fn primaries_of_radiance_files_are_converted() {
    let (_folder, path) = written("a.hdr");
    let plain = read(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let with = |primaries: &str| {
        let end = bytes.iter().position(|&b| b == b'\n').unwrap() + 1;
        let line = format!("PRIMARIES= {primaries}\n");
        std::fs::write(
            &path,
            [&bytes[..end], line.as_bytes(), &bytes[end..]].concat(),
        )
        .unwrap();
        read(&path).map_err(|error| error.to_string())
    };
    for same in [
        "0.64 0.33 0.29 0.60 0.15 0.06 0.3333 0.3333",
        "0.640 0.330 0.300 0.600 0.150 0.060 0.3127 0.3290",
        // Photoshop's, in many published maps.
        "0 0 0 0 0 0 0 0",
    ] {
        assert_eq!(with(same).unwrap(), plain);
    }
    // White of Display P3 is that of Rec.709; its red is (1.2249, −0.0420, −0.0197) there.
    let wide = with("0.680 0.320 0.265 0.690 0.150 0.060 0.3127 0.3290").unwrap();
    let matrix = [
        [1.2249, -0.2247, 0.0],
        [-0.0420, 1.0419, 0.0],
        [-0.0197, -0.0786, 1.0979],
    ];
    for (found, rgb) in wide.pixels.iter().zip(&plain.pixels) {
        for (value, row) in found.iter().zip(matrix) {
            let expected: f32 = row.iter().zip(rgb).map(|(m, c)| m * c).sum();
            assert!((value - expected).abs() < 1e-3, "{value} {expected}");
        }
    }
    assert!(with("0.1 0.1 0.2 0.2 0.3 0.3 0.3 0.3").is_err());
    assert!(with("0.64 0.33").unwrap_err().contains("eight numbers"));
}

/// A map in layers `left` and `right`, with what a file may say of it.
fn write_map(path: &Path, space: Option<&str>, cube: bool) {
    let names = [
        "left.R", "left.G", "left.B", "right.R", "right.G", "right.B",
    ];
    let channels = names.map(|name| {
        let value = if name.starts_with("left") { 1.0 } else { 2.0 };
        AnyChannel::new(name, FlatSamples::F32(vec![value; 8]))
    });
    let mut attributes = LayerAttributes::named("map");
    if cube {
        attributes.environment_map = Some(exr::meta::attribute::EnvironmentMap::Cube);
    }
    if let Some(space) = space {
        let space = exr::meta::attribute::AttributeValue::Text(space.into());
        attributes.other.insert("oiio:ColorSpace".into(), space);
    }
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let encoding = exr::prelude::Encoding::UNCOMPRESSED;
    let layer = exr::prelude::Layer::new((4, 2), attributes, encoding, channels);
    let image = exr::prelude::Image::from_layer(layer);
    image.write().to_file(path).unwrap();
}

#[test]
fn colour_spaces_that_are_named_are_told() {
    let (_folder, path) = scratch("a.exr");
    let layer = PathBuf::from(format!("{}#left", path.display()));
    let told = |space: Option<&str>| {
        write_map(&path, space, false);
        read_picture(&layer).unwrap().unheeded
    };
    assert!(told(None).is_empty() && told(Some("Linear")).is_empty());
    assert_eq!(
        told(Some("ACEScg")),
        ["its oiio:ColorSpace `ACEScg` is left out: values are taken for linear Rec.709"]
    );
}

#[test]
fn cubes_are_told_from_maps() {
    let (_folder, path) = scratch("a.exr");
    let layer = PathBuf::from(format!("{}#right", path.display()));
    for cube in [false, true] {
        write_map(&path, None, cube);
        assert_eq!(read_picture(&layer).unwrap().cube, cube);
    }
}
