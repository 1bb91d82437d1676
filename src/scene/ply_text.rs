//! PLY files as other programs write them, made plain, and messages about them.

use std::borrow::Cow;

/// The file as the parser understands it, with as many lines: without characters beyond ASCII in the header (comments may
/// have them in any encoding), without blank lines there, with line feeds where lines end in carriage returns alone, and in
/// text with numbers for what is none: vertices that are not finite are left to whoever uses them, as in OBJ files.
pub(super) fn plain_ply(bytes: &[u8]) -> Cow<'_, [u8]> {
    const END: &[u8] = b"end_header";
    let end = bytes.windows(END.len()).position(|window| window == END);
    let Some(end) = end.map(|start| start + END.len()) else {
        return Cow::Borrowed(bytes);
    };
    let (header, body) = bytes.split_at(end);
    let is_text = header.windows(12).any(|w| w == b"format ascii");
    let mut plain = plain_header(header);
    match (is_text, body) {
        (true, _) => plain.extend(with_feeds(&finite_words(body))),
        // The byte that ends the header, or the first of two.
        (false, [b'\r', b'\n', rest @ ..] | [b'\r', rest @ ..]) => {
            plain.push(b'\n');
            plain.extend(rest);
        }
        (false, rest) => plain.extend(rest),
    }
    Cow::Owned(plain)
}

/// Blank lines become comments, so that the others stay where they are.
fn plain_header(header: &[u8]) -> Vec<u8> {
    let lines = with_feeds(header);
    let mut plain = Vec::with_capacity(header.len());
    for line in lines.split_inclusive(|&byte| byte == b'\n') {
        if line.iter().all(u8::is_ascii_whitespace) {
            plain.extend(b"comment");
        }
        let ascii = |&byte: &u8| if byte.is_ascii() { byte } else { b'?' };
        plain.extend(line.iter().map(ascii));
    }
    plain
}

/// A text whose lines end in line feeds, whether they did or in carriage returns.
fn with_feeds(text: &[u8]) -> Vec<u8> {
    let alone = |i: usize| text[i] == b'\r' && text.get(i + 1) != Some(&b'\n');
    let feed = |i: usize| if alone(i) { b'\n' } else { text[i] };
    (0..text.len()).map(feed).collect()
}

/// A text in which `nan`, `inf` and what C libraries print for them are numbers beyond all that are finite.
fn finite_words(body: &[u8]) -> Vec<u8> {
    let is_number = |word: &[u8]| {
        let numeric = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
        word.iter().all(numeric)
    };
    let mut out = Vec::with_capacity(body.len());
    for word in body.split_inclusive(u8::is_ascii_whitespace) {
        let end = word.iter().position(u8::is_ascii_whitespace);
        let (word, blank) = word.split_at(end.unwrap_or(word.len()));
        let lower = String::from_utf8_lossy(word).to_lowercase();
        let odd = !is_number(word)
            && ["nan", "inf", "#ind", "#qnan"]
                .iter()
                .any(|n| lower.contains(n));
        out.extend(if odd { b"1e999".as_slice() } else { word });
        out.extend(blank);
    }
    out
}

/// A message of the parser without its own structures.
pub(super) fn plainly(message: &str) -> String {
    let message: Vec<&str> = message.split_whitespace().collect();
    let message = message.join(" ");
    let Some((what, rest)) = message.split_once(" String: '") else {
        return message
            .split(" Error: ")
            .next()
            .unwrap_or_default()
            .to_owned();
    };
    let found = rest.split("' Error:").next().unwrap_or(rest).trim();
    let found: String = found.chars().take(60).collect();
    let what = what.trim_end_matches('.');
    match what.contains("element") {
        true => format!("`{found}` is not what the header declares"),
        false => format!("{what}: `{found}`"),
    }
}
