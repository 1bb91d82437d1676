//! Where the bytes of buffers and images are: data URIs and files beside the scene.

use std::path::{Path, PathBuf};

/// What a URI of a glTF file names.
#[derive(Debug, PartialEq)]
pub(super) enum Uri {
    /// The bytes themselves.
    Data(Vec<u8>),
    File(PathBuf),
}

/// Reads a URI; files are relative to `folder`. Errors say what cannot be read.
pub(super) fn parse_uri(uri: &str, folder: &Path) -> Result<Uri, String> {
    if let Some(rest) = strip_scheme(uri, "data:") {
        return data(rest).map(Uri::Data);
    }
    let path = strip_scheme(uri, "file://").unwrap_or(uri);
    if let Some((scheme, _)) = path.split_once("://") {
        return Err(format!(
            "`{scheme}://` addresses are not fetched: put the file beside the scene"
        ));
    }
    let decoded = percent_decoded(path)
        .and_then(|bytes| String::from_utf8(bytes).ok())
        .ok_or_else(|| format!("the URI `{}` is not readable", shortened(uri)))?;
    Ok(Uri::File(folder.join(decoded.replace('\\', "/"))))
}

fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let head = uri.get(..scheme.len())?;
    head.eq_ignore_ascii_case(scheme)
        .then(|| &uri[scheme.len()..])
}

/// At most forty characters of a URI, for messages.
pub(super) fn shortened(uri: &str) -> String {
    match uri.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", &uri[..end]),
        None => uri.to_owned(),
    }
}

/// What follows `data:`: a media type, perhaps `;base64`, a comma and the data.
fn data(rest: &str) -> Result<Vec<u8>, String> {
    let (kind, text) = rest
        .split_once(',')
        .ok_or("a data URI has no comma before its data")?;
    if kind.to_ascii_lowercase().ends_with(";base64") {
        base64(text.as_bytes()).ok_or_else(|| "a data URI is not base64".to_owned())
    } else {
        percent_decoded(text).ok_or_else(|| "a data URI is damaged".to_owned())
    }
}

/// Bytes of base64 text (RFC 4648, either alphabet), padded or not.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let text: Vec<u8> = text.iter().copied().filter(|c| *c != b'=').collect();
    if text.len() % 4 == 1 {
        return None;
    }
    let mut bytes = Vec::with_capacity(text.len() * 3 / 4);
    for group in text.chunks(4) {
        let mut bits = 0_u32;
        for &character in group {
            bits = bits << 6 | u32::from(sextet(character)?);
        }
        bits <<= 6 * (4 - group.len());
        bytes.extend_from_slice(&bits.to_be_bytes()[1..group.len()]);
    }
    Some(bytes)
}

fn sextet(character: u8) -> Option<u8> {
    Some(match character {
        b'A'..=b'Z' => character - b'A',
        b'a'..=b'z' => character - b'a' + 26,
        b'0'..=b'9' => character - b'0' + 52,
        b'+' | b'-' => 62,
        b'/' | b'_' => 63,
        _ => return None,
    })
}

fn percent_decoded(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, after @ ..] = rest {
        if *first == b'%' {
            let digits = std::str::from_utf8(after.get(..2)?).ok()?;
            bytes.push(u8::from_str_radix(digits, 16).ok()?);
            rest = &after[2..];
        } else {
            bytes.push(*first);
            rest = after;
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(uri: &str) -> Result<Uri, String> {
        parse_uri(uri, Path::new("dir"))
    }

    #[test]
    fn data_is_decoded_with_and_without_padding() {
        for (text, expected) in [
            ("", ""),
            ("Zg", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
        ] {
            let uri = format!("data:application/octet-stream;base64,{text}");
            assert_eq!(bytes(&uri), Ok(Uri::Data(expected.into())));
        }
        assert_eq!(bytes("data:,a%20b"), Ok(Uri::Data("a b".into())));
        for damaged in [
            "data:x;base64",
            "data:;base64,Zm9vY",
            "data:;base64,Z*==",
            "data:,%2",
        ] {
            assert!(bytes(damaged).is_err(), "{damaged}");
        }
    }

    #[test]
    fn files_lie_beside_the_scene() {
        assert_eq!(bytes("a%20b/c.bin"), Ok(Uri::File("dir/a b/c.bin".into())));
        assert_eq!(bytes("ä.bin"), Ok(Uri::File("dir/ä.bin".into())));
        assert!(
            bytes("https://x.org/a.bin")
                .unwrap_err()
                .contains("https://")
        );
        assert!(bytes("a%zz").is_err());
        assert!(bytes("a%ff").is_err(), "not UTF-8");
    }
}
