//! Files that are not what their names say: what is there in their place, and what to do.

use std::path::Path;

/// What bytes are that no reader of scenes, meshes or pictures takes, as the end of a message; nothing where that is not
/// known.
pub(crate) fn other_kind(bytes: &[u8]) -> Option<&'static str> {
    let bare = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let starts = |magic: &&(&[u8], &str)| bare.starts_with(magic.0);
    if let Some((_, kind)) = MAGICS.iter().find(starts) {
        return Some(kind);
    }
    let head = &bare[..bare.len().min(64)];
    let head = head.trim_ascii_start().to_ascii_lowercase();
    if head.starts_with(b"<!doctype html") || head.starts_with(b"<html") {
        return Some("it is a web page (HTML): the address it was fetched from gave no file");
    }
    match bare {
        [] => Some("it is empty"),
        [
            b'R',
            b'I',
            b'F',
            b'F',
            _,
            _,
            _,
            _,
            b'W',
            b'E',
            b'B',
            b'P',
            ..,
        ] => Some(PICTURE_WEBP),
        [_, _, _, _, b'f', b't', b'y', b'p', ..] => {
            Some("it is a film, or an AVIF or HEIC picture: make it a PNG, JPEG or EXR first")
        }
        zeros if zeros.iter().all(|&byte| byte == 0) => {
            Some("it holds nothing but zeros: was its copy interrupted?")
        }
        _ => None,
    }
}

const PICTURE_WEBP: &str = "it is a WebP picture: make it a PNG, JPEG or EXR first";

/// First bytes, and what they tell.
const MAGICS: &[(&[u8], &str)] = &[
    (
        b"version https://git-lfs",
        "it is a pointer of Git LFS: fetch the file itself with `git lfs pull`",
    ),
    (b"\x1f\x8b", "it is compressed with gzip: unpack it first"),
    (b"PK\x03\x04", "it is a ZIP archive: unpack it first"),
    (b"BZh", "it is compressed with bzip2: unpack it first"),
    (b"\xfd7zXZ\0", "it is compressed with xz: unpack it first"),
    (
        b"\x28\xb5\x2f\xfd",
        "it is compressed with zstd: unpack it first",
    ),
    (b"7z\xbc\xaf\x27\x1c", "it is a 7z archive: unpack it first"),
    (b"Rar!", "it is a RAR archive: unpack it first"),
    (
        b"BLENDER",
        "it is a file of Blender: export the scene from there",
    ),
    (
        b"Kaydara FBX",
        "it is an FBX file: make it a glTF or OBJ first",
    ),
    (
        b"GIF8",
        "it is a GIF picture: make it a PNG, JPEG or EXR first",
    ),
    (
        b"II*\0",
        "it is a TIFF picture: make it a PNG, JPEG or EXR first",
    ),
    (
        b"MM\0*",
        "it is a TIFF picture: make it a PNG, JPEG or EXR first",
    ),
    (
        b"DDS ",
        "it is a DDS texture: make it a PNG, JPEG or EXR first",
    ),
    (
        b"\xabKTX ",
        "it is a KTX texture: make it a PNG, JPEG or EXR first",
    ),
    (
        b"8BPS",
        "it is a file of Photoshop: make it a PNG, JPEG or EXR first",
    ),
    (b"PF\n", "it is a PFM picture: make it an EXR first"),
    (b"Pf\n", "it is a PFM picture: make it an EXR first"),
    (
        b"%PDF",
        "it is a PDF document: make it a PNG, JPEG or EXR first",
    ),
];

/// A message with what the file is in place of what was expected.
pub(crate) fn with_other_kind(message: String, bytes: &[u8]) -> String {
    match other_kind(bytes) {
        Some(kind) => format!("{message}; {kind}"),
        None => message,
    }
}

/// The text of a file of our own formats.
///
/// # Errors
/// A sentence: it cannot be read, is of another kind, or is not in UTF-8.
pub(crate) fn read_text(file: &Path) -> Result<String, String> {
    let bytes = crate::files::read(file).map_err(|error| format!("cannot be read: {error}"))?;
    text_of(bytes)
}

fn text_of(bytes: Vec<u8>) -> Result<String, String> {
    String::from_utf8(bytes).map_err(|error| {
        let bytes = error.as_bytes();
        if let Some(kind) = other_kind(bytes) {
            return format!("is no text: {kind}");
        }
        let sound = error.utf8_error().valid_up_to();
        let line = 1 + bytes[..sound].iter().filter(|&&b| b == b'\n').count();
        let wide = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
        let found = if wide {
            "the file is UTF-16"
        } else {
            "it is in another encoding"
        };
        format!("line {line} is not UTF-8, {found}: save it as UTF-8")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_in_other_encodings_is_refused_in_words() {
        let told = |bytes: &[u8]| text_of(bytes.to_vec()).unwrap_err();
        assert_eq!(
            told(b"\xff\xfen\0a\0"),
            "line 1 is not UTF-8, the file is UTF-16: save it as UTF-8"
        );
        assert_eq!(
            told(b"a = 1\nb = \"caf\xe9\""),
            "line 2 is not UTF-8, it is in another encoding: save it as UTF-8"
        );
        assert!(told(b"PK\x03\x04\xff").contains("ZIP"));
        assert_eq!(text_of(b"a = 1".to_vec()), Ok("a = 1".into()));
    }

    #[test]
    fn what_stands_in_place_of_a_file_is_named() {
        let named = |bytes: &[u8]| other_kind(bytes).unwrap_or_default();
        assert!(named(b"version https://git-lfs.github.com/spec/v1\noid sha256:1").contains("LFS"));
        assert!(named(b"\xef\xbb\xbf\n <!DOCTYPE HTML><html>404").contains("web page"));
        assert!(named(b"RIFF\x24\0\0\0WEBPVP8 ").contains("WebP"));
        assert!(named(b"\0\0\0\x1cftypavif").contains("AVIF"));
        assert!(named(b"").contains("empty"));
        assert!(named(&[0; 9]).contains("zeros"));
        assert_eq!(other_kind(b"v 0 0 0\n"), None);
        let told = with_other_kind("no faces".into(), b"PK\x03\x04..");
        assert_eq!(told, "no faces; it is a ZIP archive: unpack it first");
    }
}
