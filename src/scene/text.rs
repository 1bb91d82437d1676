//! What text files say, places in them, and the advice that goes with them.

use std::borrow::Cow;
use std::path::Path;

use super::SceneError;
use crate::other_kind::other_kind;
pub(super) use crate::suggest::{advice, nearest};

/// The text of a file in UTF-8, with or without a byte order mark, in UTF-16 with one, or else in Latin-1, which has a
/// character for every byte. Carriage returns end lines alone as well, and two before a line feed are one end.
pub(super) fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    let bare = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = match (std::str::from_utf8(bare), wide_units(bytes)) {
        (Ok(text), _) => Cow::Borrowed(text),
        (_, Some(units)) => Cow::Owned(String::from_utf16_lossy(&units)),
        (_, None) => Cow::Owned(bare.iter().map(|&byte| char::from(byte)).collect()),
    };
    match text.contains('\r') {
        true => {
            let text = text.replace("\r\r\n", "\n").replace("\r\n", "\n");
            Cow::Owned(text.replace('\r', "\n"))
        }
        false => text,
    }
}

/// The units of a text in UTF-16, which its byte order mark tells.
fn wide_units(bytes: &[u8]) -> Option<Vec<u16>> {
    let (rest, read): (_, fn([u8; 2]) -> u16) = match bytes {
        [0xff, 0xfe, rest @ ..] => (rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => (rest, u16::from_be_bytes),
        _ => return None,
    };
    Some(rest.chunks_exact(2).map(|c| read([c[0], c[1]])).collect())
}

/// The text of an XML file in the encoding that it declares. Of other encodings of one byte than Latin-1 the characters of
/// ASCII are read, the others replaced.
///
/// # Errors
/// A sentence, where that is neither UTF-8, UTF-16 nor of one byte, or the bytes are not in it.
pub(super) fn decoded_xml(bytes: &[u8]) -> Result<Cow<'_, str>, String> {
    if let Some(kind) = other_kind(bytes) {
        return Err(format!("this is no scene: {kind}"));
    }
    let marked = match bytes {
        [b'<', 0, ..] => Cow::Owned([b"\xff\xfe", bytes].concat()),
        [0, b'<', ..] => Cow::Owned([b"\xfe\xff", bytes].concat()),
        _ => Cow::Borrowed(bytes),
    };
    if let Some(units) = wide_units(&marked) {
        let text = String::from_utf16(&units);
        return text
            .map(Cow::Owned)
            .map_err(|_| "the file is not sound UTF-16".to_owned());
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let head = &bytes[..bytes.iter().position(|&b| b == b'>').unwrap_or(0)];
    let head = String::from_utf8_lossy(head);
    let declared = head
        .strip_prefix("<?xml")
        .and_then(|head| head.split_once("encoding"))
        .and_then(|(_, rest)| rest.split(['"', '\'']).nth(1))
        .unwrap_or("UTF-8");
    match declared.to_ascii_lowercase().as_str() {
        "iso-8859-1" | "latin1" | "latin-1" | "windows-1252" => {
            Ok(Cow::Owned(bytes.iter().map(|&b| char::from(b)).collect()))
        }
        "utf-8" | "utf8" | "us-ascii" | "ascii" => match std::str::from_utf8(bytes) {
            Ok(text) => Ok(Cow::Borrowed(text)),
            Err(error) => {
                let line = bytes[..error.valid_up_to()]
                    .iter()
                    .filter(|&&b| b == b'\n')
                    .count()
                    + 1;
                Err(format!(
                    "line {line} is not {declared}: declare the encoding in the first line, <?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>, or save the file as UTF-8"
                ))
            }
        },
        other if other.starts_with("iso-8859-") || other.starts_with("windows-125") => {
            let read = |&byte: &u8| match byte.is_ascii() {
                true => char::from(byte),
                false => char::REPLACEMENT_CHARACTER,
            };
            Ok(Cow::Owned(bytes.iter().map(read).collect()))
        }
        _ => Err(format!(
            "the encoding `{declared}` is not read: save the file as UTF-8"
        )),
    }
}

/// Line and column (both from 1, the column in characters) of a byte offset.
pub(super) fn line_column(text: &str, offset: usize) -> (usize, usize) {
    let mut end = offset.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = &text[..end];
    let line = before.bytes().filter(|&b| b == b'\n').count() + 1;
    let start = before.rfind('\n').map_or(0, |i| i + 1);
    (line, before[start..].chars().count() + 1)
}

/// Where the lines of a text begin, for many places in it.
pub(super) struct LineStarts<'a> {
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> LineStarts<'a> {
    pub fn of(text: &'a str) -> Self {
        let feeds = text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n');
        let starts = std::iter::once(0).chain(feeds.map(|(i, _)| i + 1));
        Self {
            text,
            starts: starts.collect(),
        }
    }

    /// As [`line_column`], of an offset at the start of a character.
    pub fn place(&self, offset: usize) -> (usize, usize) {
        let line = self.starts.partition_point(|&start| start <= offset);
        let before = &self.text[self.starts[line - 1]..offset];
        (line, before.chars().count() + 1)
    }
}

/// An error at a byte offset of a text.
pub(super) fn error_at(file: &Path, text: &str, offset: usize, message: String) -> SceneError {
    let (line, column) = line_column(text, offset);
    SceneError::At {
        file: file.to_owned(),
        line,
        column,
        message,
    }
}

/// An error of a whole file.
pub(super) fn file_error(file: &Path, message: impl Into<String>) -> SceneError {
    SceneError::File {
        file: file.to_owned(),
        message: message.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn xml_is_read_in_the_encoding_that_it_declares() {
        let latin = b"<?xml version='1.0' encoding='ISO-8859-1'?><a b='caf\xe9'/>";
        assert!(decoded_xml(latin).unwrap().contains("café"));
        assert_eq!(decoded_xml(b"\xef\xbb\xbf<a/>").unwrap(), "<a/>");
        assert_eq!(decoded_xml(b"\xff\xfe<\0a\0/\0>\0").unwrap(), "<a/>");
        assert_eq!(decoded_xml(b"<\0a\0/\0>\0").unwrap(), "<a/>");
        let euro = b"<?xml version='1.0' encoding='ISO-8859-15'?><a b='1\xa4'/>";
        assert!(decoded_xml(euro).unwrap().contains("'1\u{fffd}'"));
        let undeclared = decoded_xml(b"<a>\n<b c='caf\xe9'/>").unwrap_err();
        assert!(
            undeclared.starts_with("line 2 is not UTF-8"),
            "{undeclared}"
        );
        let other = decoded_xml(b"<?xml encoding=\"EBCDIC\"?><a/>").unwrap_err();
        assert!(other.contains("`EBCDIC`"), "{other}");
    }

    #[test]
    fn text_is_utf8_or_else_latin1() {
        assert_eq!(decoded("\u{feff}né\r\nb\rc".as_bytes()), "né\nb\nc");
        assert_eq!(decoded(b"n\xe9"), "né");
    }

    #[test]
    fn places_count_from_one() {
        let text = "ab\ncäd\n";
        assert_eq!(line_column(text, 0), (1, 1));
        let lines = LineStarts::of(text);
        for offset in (0..=text.len()).filter(|&i| text.is_char_boundary(i)) {
            assert_eq!(lines.place(offset), line_column(text, offset), "{offset}");
        }
        assert_eq!(line_column(text, 3), (2, 1));
        assert_eq!(line_column(text, 6), (2, 3));
        assert_eq!(line_column(text, 5), (2, 2), "inside a character");
        assert_eq!(line_column(text, 99), (3, 1));
    }
}
