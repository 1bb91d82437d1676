//! What PNG and JPEG files say of their colours and of their orientation, and is not followed.

use std::io::Cursor;

use ::image::ImageDecoder;
use ::image::codecs::jpeg::JpegDecoder;
use ::image::metadata::Orientation;

use super::guard::decoded;
use super::primaries::REC709;

/// What a file says of its colours and of its orientation that is not followed, in words; of other formats nothing.
///
/// Values are taken for sRGB, rows as they are stored.
pub(crate) fn unheeded(bytes: &[u8]) -> Vec<String> {
    let notes = match bytes {
        [0x89, b'P', b'N', b'G', ..] => decoded(|| unheeded_png(bytes).map_err(|e| e.to_string())),
        [0xff, 0xd8, ..] => decoded(|| unheeded_jpeg(bytes).map_err(|e| e.to_string())),
        _ => return Vec::new(),
    };
    // A file that cannot be read is an error where its picture is decoded.
    notes.unwrap_or_default()
}

fn unheeded_png(bytes: &[u8]) -> Result<Vec<String>, png::DecodingError> {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info()?;
    if reader.info().exif_metadata.is_none() && bytes.windows(4).any(|name| name == b"eXIf") {
        // It may stand behind the pixels.
        reader.finish()?;
    }
    let info = reader.info();
    let mut notes = colours_of_png(info);
    if let Some(dimensions) = info.pixel_dims
        && dimensions.xppu != dimensions.yppu
    {
        let (x, y) = (dimensions.xppu, dimensions.yppu);
        notes.push(format!(
            "its pixels are not square (pHYs {x} to {y}): they are taken for square"
        ));
    }
    if info.animation_control.is_some_and(|of| of.num_frames > 1) {
        notes.push("it is an animation: its first frame is taken".into());
    }
    let exif = info.exif_metadata.as_deref();
    notes.extend(exif.and_then(Orientation::from_exif_chunk).and_then(turned));
    Ok(notes)
}

/// What is not followed of the colours of a PNG file. Of the chunks that speak of them the first that is there decides.
fn colours_of_png(info: &png::Info) -> Vec<String> {
    if let Some(points) = info.coding_independent_code_points {
        let is_srgb = (points.color_primaries, points.transfer_function) == (1, 13);
        let note =
            "its coding-independent code points (cICP) are left out: values are taken for sRGB";
        return match is_srgb && points.is_video_full_range_image {
            true => Vec::new(),
            false => vec![note.into()],
        };
    }
    if let Some(profile) = &info.icc_profile {
        return foreign_profile(profile).into_iter().collect();
    }
    if info.srgb.is_some() {
        return Vec::new();
    }
    let mut notes = Vec::new();
    if let Some(gamma) = info.gama_chunk.map(|gamma| gamma.into_value())
        && (gamma - 0.45455).abs() > 0.005
    {
        notes.push(format!(
            "its gamma (gAMA {gamma}) is left out: values are taken for sRGB"
        ));
    }
    if let Some(c) = info.chrm_chunk {
        let found = [c.red, c.green, c.blue, c.white];
        let found = found.map(|(x, y)| [x.into_value(), y.into_value()]);
        let mut pairs = found.as_flattened().iter().zip(REC709.as_flattened());
        if pairs.any(|(a, b)| (a - b).abs() > 0.005) {
            notes.push("its primaries (cHRM) are left out: they are taken for sRGB's".into());
        }
    }
    notes
}

fn unheeded_jpeg(bytes: &[u8]) -> Result<Vec<String>, ::image::ImageError> {
    let mut decoder = JpegDecoder::new(Cursor::new(bytes))?;
    let profile = decoder.icc_profile()?;
    let profile = profile.and_then(|profile| foreign_profile(&profile));
    let turn = turned(decoder.orientation()?);
    Ok(profile.into_iter().chain(turn).collect())
}

/// A colour profile that is not called after sRGB, in bytes or in UTF-16.
fn foreign_profile(profile: &[u8]) -> Option<String> {
    let has = |name: &[u8]| profile.windows(name.len()).any(|word| word == name);
    let is_srgb = has(b"sRGB") || has(b"\0s\0R\0G\0B");
    let note = "its colour profile (ICC) is left out: values are taken for sRGB";
    (!is_srgb).then(|| note.to_owned())
}

/// A picture that is not stored upright, in words.
fn turned(orientation: Orientation) -> Option<String> {
    let turn = orientation.to_exif();
    (turn != 1).then(|| {
        format!("its Exif orientation {turn} is left out: the picture is taken as it is stored")
    })
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    type Chunk<'a> = (&'a [u8; 4], &'a [u8]);

    fn zlib(data: &[u8]) -> Vec<u8> {
        let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        zlib.write_all(data).unwrap();
        zlib.finish().unwrap()
    }

    /// A PNG of one pixel with chunks in front of it and behind it.
    fn png(before: &[Chunk], behind: &[Chunk]) -> Vec<u8> {
        let size = [0, 0, 0, 1, 0, 0, 0, 1, 8, 2, 0, 0, 0];
        let pixels = zlib(&[0, 1, 2, 3]);
        let (head, picture, end) = (
            (b"IHDR", &size[..]),
            (b"IDAT", &pixels[..]),
            (b"IEND", &[][..]),
        );
        let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
        for (name, data) in [&[head], before, &[picture], behind, &[end]].concat() {
            let mut check = flate2::Crc::new();
            check.update(name);
            check.update(data);
            bytes.extend((data.len() as u32).to_be_bytes());
            bytes.extend(name);
            bytes.extend(data);
            bytes.extend(check.sum().to_be_bytes());
        }
        bytes
    }

    /// A JPEG with a segment behind its first marker.
    fn jpeg(marker: u8, data: &[u8]) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let picture = ::image::RgbImage::new(8, 8);
        picture
            .write_to(&mut bytes, ::image::ImageFormat::Jpeg)
            .unwrap();
        let mut bytes = bytes.into_inner();
        let mut segment = vec![0xff, marker];
        segment.extend((data.len() as u16 + 2).to_be_bytes());
        segment.extend(data);
        bytes.splice(2..2, segment);
        bytes
    }

    #[test]
    fn colours_that_are_not_srgb_are_told() {
        let told = |before: &[Chunk]| unheeded(&png(before, &[]));
        let gamma = |g: u32| told(&[(b"gAMA", &g.to_be_bytes())]);
        assert!(gamma(45_455).is_empty());
        assert!(
            gamma(100_000)[0].contains("gAMA 1)"),
            "{:?}",
            gamma(100_000)
        );
        let both = [(b"sRGB", &[0][..]), (b"gAMA", &100_000_u32.to_be_bytes())];
        assert!(told(&both).is_empty(), "sRGB decides");
        let profile = |text: &[u8]| [b"name\0\0", &zlib(text)[..]].concat();
        assert!(told(&[(b"iCCP", &profile(b"desc Adobe RGB (1998)"))])[0].contains("profile"));
        assert!(told(&[(b"iCCP", &profile(b"desc sRGB IEC61966-2.1"))]).is_empty());
        assert!(told(&[(b"cICP", &[9, 16, 0, 1])])[0].contains("cICP"));
        assert!(told(&[(b"cICP", &[1, 13, 0, 1])]).is_empty());
        let wide = [
            31_270_u32, 32_900, 68_000, 32_000, 26_500, 69_000, 15_000, 6_000,
        ];
        let wide = wide.map(u32::to_be_bytes);
        assert!(told(&[(b"cHRM", wide.as_flattened())])[0].contains("cHRM"));
        assert!(unheeded(&jpeg(0xe2, b"ICC_PROFILE\0\x01\x01 Display P3"))[0].contains("ICC"));
        assert!(unheeded(&jpeg(0xe2, b"ICC_PROFILE\0\x01\x01 \0s\0R\0G\0B")).is_empty());
        assert!(unheeded(b"BM").is_empty());
    }

    #[test]
    fn turned_pictures_are_told() {
        let tiff = |turn: u8| {
            let mut bytes = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
            bytes.extend([turn, 0, 0, 0, 0, 0, 0, 0]);
            bytes
        };
        let exif = |turn| [b"Exif\0\0".to_vec(), tiff(turn)].concat();
        assert!(unheeded(&jpeg(0xe1, &exif(1))).is_empty());
        assert!(unheeded(&jpeg(0xe1, &exif(6)))[0].contains("orientation 6"));
        let chunk: Chunk = (b"eXIf", &tiff(3));
        for file in [png(&[chunk], &[]), png(&[], &[chunk])] {
            assert!(unheeded(&file)[0].contains("orientation 3"));
            // Damage is told by whoever reads the picture.
            (0..file.len()).for_each(|end| drop(unheeded(&file[..end])));
        }
    }

    #[test]
    fn animations_and_pixels_that_are_not_square_are_told() {
        let dimensions: Chunk = (b"pHYs", &[0, 0, 0, 1, 0, 0, 0, 2, 0]);
        assert!(unheeded(&png(&[dimensions], &[]))[0].contains("pHYs 1 to 2"));
        let frame = [[0; 4], [0, 0, 0, 1], [0, 0, 0, 1], [0; 4], [0; 4], [0; 4]];
        let frame = [frame.as_flattened(), &[0, 0]].concat();
        let chunks: [Chunk; 2] = [(b"acTL", &[0, 0, 0, 2, 0, 0, 0, 0]), (b"fcTL", &frame)];
        assert!(unheeded(&png(&chunks, &[]))[0].contains("first frame"));
    }
}
