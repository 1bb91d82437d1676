//! What PNG and JPEG files say of their colours and of their orientation, and is not followed.

use std::io::Read;

use flate2::read::ZlibDecoder;

/// Chunks of a PNG file in front of its pixels, by name.
fn png_chunks(bytes: &[u8]) -> impl Iterator<Item = (&[u8], &[u8])> {
    let mut rest = bytes.get(8..).unwrap_or(&[]);
    std::iter::from_fn(move || {
        let length = u32::from_be_bytes(rest.get(..4)?.try_into().ok()?) as usize;
        let name = rest.get(4..8)?;
        let data = rest.get(8..)?.get(..length)?;
        rest = rest.get(length.checked_add(12)?..).unwrap_or(&[]);
        (name != b"IDAT").then_some((name, data))
    })
}

/// Application segments of a JPEG file in front of its first scan: the second byte of their marker, and what they hold.
fn jpeg_segments(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut rest = bytes.get(2..).unwrap_or(&[]);
    std::iter::from_fn(move || {
        let [0xff, marker, high, low, ..] = *rest else {
            return None;
        };
        let length = usize::from(u16::from_be_bytes([high, low]));
        let data = rest.get(4..)?.get(..length.checked_sub(2)?)?;
        rest = &rest[2 + length..];
        (marker != 0xda).then_some((marker, data))
    })
}

/// What a file says of its colours and of its orientation that is not followed, in words; of other formats nothing.
///
/// Values are taken for sRGB, rows as they are stored.
pub(crate) fn unheeded(bytes: &[u8]) -> Vec<String> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => unheeded_png(bytes),
        [0xff, 0xd8, ..] => unheeded_jpeg(bytes),
        _ => Vec::new(),
    }
}

fn unheeded_png(bytes: &[u8]) -> Vec<String> {
    let find = |wanted: &[u8; 4]| {
        let mut chunks = png_chunks(bytes);
        chunks.find_map(|(name, data)| (name == wanted).then_some(data))
    };
    let hundred_thousandths = |data: &[u8]| -> Vec<u32> {
        let numbers = data.chunks_exact(4);
        numbers
            .map(|n| u32::from_be_bytes([n[0], n[1], n[2], n[3]]))
            .collect()
    };
    let mut notes = Vec::new();
    // Of these the first that is there decides.
    if let Some(data) = find(b"cICP") {
        if !matches!(data, [1, 13, ..]) {
            notes.push(
                "its coding-independent code points (cICP) are left out: values are taken for sRGB"
                    .into(),
            );
        }
    } else if let Some(data) = find(b"iCCP") {
        if !names_srgb(data) && !names_srgb(&inflated(data)) {
            notes.push(PROFILE.into());
        }
    } else if find(b"sRGB").is_none() {
        let gamma = find(b"gAMA").map(hundred_thousandths);
        if let Some([gamma, ..]) = gamma.as_deref()
            && gamma.abs_diff(45_455) > 500
        {
            let gamma = f64::from(*gamma) / 1e5;
            notes.push(format!(
                "its gamma (gAMA {gamma}) is left out: values are taken for sRGB"
            ));
        }
        const REC709: [u32; 8] = [
            31_270, 32_900, 64_000, 33_000, 30_000, 60_000, 15_000, 6_000,
        ];
        let primaries = find(b"cHRM").map(hundred_thousandths);
        let far = |all: &Vec<u32>| all.iter().zip(REC709).any(|(a, b)| a.abs_diff(b) > 500);
        if primaries.as_ref().is_some_and(far) {
            notes.push("its primaries (cHRM) are left out: they are taken for sRGB's".into());
        }
    }
    if let Some(turn) = find(b"eXIf").and_then(orientation) {
        notes.push(turn);
    }
    notes
}

/// The profile behind its name and the number of its compression, as far as it can be read.
fn inflated(chunk: &[u8]) -> Vec<u8> {
    let name = chunk.iter().position(|&byte| byte == 0);
    let data = name.and_then(|end| chunk.get(end + 2..)).unwrap_or(&[]);
    let mut profile = Vec::new();
    let mut read = ZlibDecoder::new(data).take(LONGEST_PROFILE);
    // What is damaged names nothing.
    let _ = read.read_to_end(&mut profile);
    profile
}

/// Bytes of a profile that are looked at.
const LONGEST_PROFILE: u64 = 1 << 16;

const PROFILE: &str = "its colour profile (ICC) is left out: values are taken for sRGB";

fn unheeded_jpeg(bytes: &[u8]) -> Vec<String> {
    let mut notes = Vec::new();
    for (marker, data) in jpeg_segments(bytes) {
        let note = match (marker, data) {
            (0xe1, data) => data.strip_prefix(b"Exif\0\0").and_then(orientation),
            (0xe2, data) if data.starts_with(b"ICC_PROFILE\0") => {
                (!names_srgb(data)).then(|| PROFILE.to_owned())
            }
            _ => None,
        };
        // A long profile has several segments, of which the first has the name.
        notes.extend(note.filter(|_| marker != 0xe2 || data.get(12) == Some(&1)));
    }
    notes
}

/// Whether a profile is called after sRGB, in bytes or in UTF-16.
fn names_srgb(bytes: &[u8]) -> bool {
    let wide: Vec<u8> = b"sRGB".iter().flat_map(|&byte| [0, byte]).collect();
    bytes.windows(4).any(|word| word == b"sRGB") || bytes.windows(8).any(|word| word == wide)
}

/// Exif's orientation of a picture that is not stored upright, in words.
fn orientation(tiff: &[u8]) -> Option<String> {
    let big = match tiff.get(..4)? {
        b"II*\0" => false,
        b"MM\0*" => true,
        _ => return None,
    };
    let short = |at: usize| {
        let two = tiff.get(at..at.checked_add(2)?)?.try_into().ok()?;
        Some(match big {
            true => u16::from_be_bytes(two),
            false => u16::from_le_bytes(two),
        })
    };
    let [a, b] = [short(4)?, short(6)?].map(usize::from);
    let first = if big { a << 16 | b } else { b << 16 | a };
    let count = usize::from(short(first)?);
    let entry = (0..count).map(|i| first + 2 + 12 * i);
    let turn = entry
        .take_while(|at| at + 12 <= tiff.len())
        .find_map(|at| (short(at)? == 0x112).then(|| short(at + 8)).flatten())?;
    (2..=8).contains(&turn).then(|| {
        format!("its Exif orientation {turn} is left out: the picture is taken as it is stored")
    })
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn png(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
        for (name, data) in chunks {
            bytes.extend((data.len() as u32).to_be_bytes());
            bytes.extend(*name);
            bytes.extend(*data);
            bytes.extend([0; 4]);
        }
        bytes
    }

    /// A JPEG's head with one segment.
    fn jpeg(marker: u8, data: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0xff, 0xd8, 0xff, marker];
        bytes.extend((data.len() as u16 + 2).to_be_bytes());
        bytes.extend(data);
        bytes.extend([0xff, 0xda, 0, 2]);
        bytes
    }

    #[test]
    fn colours_that_are_not_srgb_are_told() {
        let gamma = |g: u32| unheeded(&png(&[(b"gAMA", &g.to_be_bytes())]));
        assert!(gamma(45_455).is_empty());
        assert!(
            gamma(100_000)[0].contains("gAMA 1)"),
            "{:?}",
            gamma(100_000)
        );
        let both = [(b"sRGB", &[0][..]), (b"gAMA", &100_000_u32.to_be_bytes())];
        assert!(unheeded(&png(&both)).is_empty(), "sRGB decides");
        assert!(unheeded(&png(&[(b"iCCP", b"Adobe RGB (1998)\0\0xx")]))[0].contains("profile"));
        assert!(unheeded(&png(&[(b"iCCP", b"sRGB IEC61966-2.1\0\0xx")])).is_empty());
        let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        zlib.write_all(b"desc sRGB IEC61966-2.1").unwrap();
        let hidden = [&b"Photoshop ICC profile\0\0"[..], &zlib.finish().unwrap()].concat();
        assert!(unheeded(&png(&[(b"iCCP", &hidden)])).is_empty());
        assert!(unheeded(&png(&[(b"cICP", &[9, 16, 0, 1])]))[0].contains("cICP"));
        assert!(unheeded(&png(&[(b"cICP", &[1, 13, 0, 1])])).is_empty());
        let wide: Vec<u8> = [
            31_270_u32, 32_900, 68_000, 32_000, 26_500, 69_000, 15_000, 6_000,
        ]
        .iter()
        .flat_map(|v| v.to_be_bytes())
        .collect();
        assert!(unheeded(&png(&[(b"cHRM", &wide)]))[0].contains("cHRM"));
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
        assert!(unheeded(&png(&[(b"eXIf", &tiff(3))]))[0].contains("orientation 3"));
        for end in 0..tiff(6).len() {
            assert!(orientation(&tiff(6)[..end]).is_none() || end >= 20);
        }
    }
}
