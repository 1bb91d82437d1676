//! PLY files as other programs write them, made plain, and messages about them.

use std::borrow::Cow;

/// A PLY file as the parser understands it.
pub(super) struct PlainPly<'a> {
    pub bytes: Cow<'a, [u8]>,
    /// What of it is left out.
    pub notes: Vec<String>,
    /// Lines of the file, counted from 1, that are left out since nothing stands in them.
    pub blank_lines: Vec<usize>,
}

/// The line of the file, given that of the plain one and the blank lines that were left out.
pub(super) fn line_of_file(plain_line: usize, blank_lines: &[usize]) -> usize {
    let before = |line: usize, blank: &usize| line + usize::from(*blank <= line);
    blank_lines.iter().fold(plain_line, before)
}

/// Adds the lines of a body in which something stands, and the first, which ends the header. Returns the others.
fn push_filled(plain: &mut Vec<u8>, body: &[u8]) -> Vec<usize> {
    let header_lines = plain.iter().filter(|&&byte| byte == b'\n').count();
    let mut blank_lines = Vec::new();
    for (number, line) in body.split_inclusive(|&byte| byte == b'\n').enumerate() {
        if number > 0 && line.trim_ascii().is_empty() {
            blank_lines.push(header_lines + number + 1);
        } else {
            plain.extend(line);
        }
    }
    blank_lines
}

/// The file as the parser understands it, with as many lines but the blank ones of a text: without a byte order mark and
/// characters beyond ASCII in the header (comments may have them in any encoding), without blank lines there, with line feeds where lines end in carriage
/// returns alone, and in text with numbers for what is none: vertices that are not finite are left to whoever uses them, as
/// in OBJ files. Text whose entries do not stand in lines of their own is laid out anew.
///
/// # Errors
/// A sentence, where the header cannot mean what it says.
pub(super) fn plain_ply(bytes: &[u8]) -> Result<PlainPly<'_>, String> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let (mut notes, mut blank_lines) = (Vec::new(), Vec::new());
    let Some(end) = end_of_header(bytes) else {
        return Ok(PlainPly {
            bytes: Cow::Borrowed(bytes),
            notes,
            blank_lines,
        });
    };
    let (header, body) = bytes.split_at(end);
    let is_text = header.windows(12).any(|w| w == b"format ascii");
    let mut plain = plain_header(header);
    let declared = Declared::of(&plain)?;
    notes.extend(declared.notes());
    match (is_text, body) {
        (true, _) => {
            let body = with_feeds(&finite_words(body));
            match declared.layout(&body) {
                Layout::Lines => {
                    blank_lines = push_filled(&mut plain, &body);
                }
                Layout::Longer(lines) => {
                    notes.push(format!(
                        "{lines} lines have more values than the header declares, these are left out"
                    ));
                    blank_lines = push_filled(&mut plain, &body);
                }
                Layout::Other(laid) => {
                    plain.push(b'\n');
                    plain.extend(laid);
                }
            }
        }
        // The byte that ends the header, or the first of two.
        (false, [b'\r', b'\n', rest @ ..] | [b'\r', rest @ ..]) => {
            plain.push(b'\n');
            plain.extend(rest);
        }
        (false, rest) => plain.extend(rest),
    }
    Ok(PlainPly {
        bytes: Cow::Owned(plain),
        notes,
        blank_lines,
    })
}

/// Where the line that ends the header ends.
fn end_of_header(bytes: &[u8]) -> Option<usize> {
    const END: &[u8] = b"end_header";
    let mut from = 0;
    loop {
        let found = bytes[from..].windows(END.len()).position(|w| w == END)?;
        let (start, end) = (from + found, from + found + END.len());
        let begins = bytes[..start]
            .iter()
            .rev()
            .find(|&&byte| byte != b' ' && byte != b'\t')
            .is_none_or(|byte| b"\r\n".contains(byte));
        if begins && bytes.get(end).is_none_or(u8::is_ascii_whitespace) {
            return Some(end);
        }
        from = end;
    }
}

/// An element of a header.
struct Element {
    name: String,
    count: u64,
    /// Names, and whether they are lists.
    properties: Vec<(String, bool)>,
}

/// The elements that a header declares.
struct Declared(Vec<Element>, Vec<String>);

/// How the entries of a text stand in its lines.
enum Layout {
    /// One a line, or so that the parser tells what is wrong.
    Lines,
    /// One a line, this many of which have more values.
    Longer(usize),
    /// Otherwise; here they are one a line.
    Other(Vec<u8>),
}

impl Declared {
    fn of(header: &[u8]) -> Result<Self, String> {
        let (mut elements, mut textures) = (Vec::<Element>::new(), Vec::new());
        for line in String::from_utf8_lossy(header).lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                ["element", name, count] => {
                    if elements.iter().any(|known| known.name == name) {
                        return Err(format!("element `{name}` is declared twice"));
                    }
                    elements.push(Element {
                        name: name.to_owned(),
                        count: count.parse().unwrap_or(0),
                        properties: Vec::new(),
                    });
                }
                ["property", .., name] => {
                    let Some(element) = elements.last_mut() else {
                        continue;
                    };
                    if element.properties.iter().any(|(known, _)| known == name) {
                        let of = &element.name;
                        return Err(format!("property `{name}` of `{of}` is declared twice"));
                    }
                    let is_list = words[1] == "list";
                    element.properties.push((name.to_owned(), is_list));
                }
                ["comment", "TextureFile", ..] => textures.push(words[2..].join(" ")),
                _ => {}
            }
        }
        Ok(Self(elements, textures))
    }

    fn notes(&self) -> impl Iterator<Item = String> {
        let textures = self.1.iter();
        textures.map(|file| format!("the texture `{file}` that a comment names is left out"))
    }

    /// How many words an entry takes of those that follow; `None` where they end before it, or are no numbers.
    fn words_of<'a>(
        element: &Element,
        words: &mut impl Iterator<Item = &'a [u8]>,
    ) -> Option<usize> {
        let mut taken = 0;
        for (_, is_list) in &element.properties {
            let word = words.next()?;
            taken += 1;
            if *is_list {
                let count: usize = std::str::from_utf8(word).ok()?.parse().ok()?;
                for _ in 0..count {
                    words.next()?;
                    taken += 1;
                }
            }
        }
        Some(taken)
    }

    fn layout(&self, body: &[u8]) -> Layout {
        let words_in = |line: &'_ [u8]| {
            let words = line.split(u8::is_ascii_whitespace);
            words.filter(|word| !word.is_empty()).count()
        };
        let mut lines = body
            .split(|&byte| byte == b'\n')
            .filter(|line| !line.trim_ascii().is_empty());
        let (mut longer, mut is_short) = (0, false);
        'all: for element in &self.0 {
            if element.properties.is_empty() {
                return Layout::Lines;
            }
            for _ in 0..element.count {
                let Some(line) = lines.next() else {
                    is_short = true;
                    break 'all;
                };
                let words = line.split(u8::is_ascii_whitespace);
                let mut words = words.filter(|word| !word.is_empty());
                match Self::words_of(element, &mut words) {
                    Some(taken) => longer += usize::from(words_in(line) > taken),
                    None => {
                        is_short = true;
                        break 'all;
                    }
                }
            }
        }
        match (is_short || longer > 0)
            .then(|| self.laid_out(body))
            .flatten()
        {
            Some(laid) => Layout::Other(laid),
            None if longer > 0 => Layout::Longer(longer),
            None => Layout::Lines,
        }
    }

    /// The entries, one a line, if the words of a text are just as many as they need.
    fn laid_out(&self, body: &[u8]) -> Option<Vec<u8>> {
        let words = body.split(u8::is_ascii_whitespace);
        let words: Vec<&[u8]> = words.filter(|word| !word.is_empty()).collect();
        let (mut laid, mut at) = (Vec::with_capacity(body.len()), 0);
        for element in &self.0 {
            for _ in 0..element.count {
                let taken = Self::words_of(element, &mut words[at..].iter().copied())?;
                laid.extend(words[at..at + taken].join(&b' '));
                laid.push(b'\n');
                at += taken;
            }
        }
        (at == words.len()).then_some(laid)
    }
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

/// A text whose lines end in line feeds, whether they did or in carriage returns. (Of two returns before a line feed the
/// first is a blank.)
fn with_feeds(text: &[u8]) -> Vec<u8> {
    let feed = |i: usize| match (text[i], &text[i + 1..]) {
        (b'\r', [b'\r', b'\n', ..]) => b' ',
        (b'\r', [b'\n', ..]) => b'\r',
        (b'\r', _) => b'\n',
        (byte, _) => byte,
    };
    (0..text.len()).map(feed).collect()
}

/// Adds a number as the parser takes it: without a plus, and with digits on both sides of a point that has some on one.
fn push_number(out: &mut Vec<u8>, word: &[u8]) {
    let word = match word {
        [b'+', rest @ ..] if !rest.starts_with(b"-") && !rest.starts_with(b"+") => rest,
        _ => word,
    };
    let digit = |i: usize| word.get(i).is_some_and(u8::is_ascii_digit);
    for (i, &byte) in word.iter().enumerate() {
        let before = i.checked_sub(1).is_some_and(digit);
        let is_point = byte == b'.' && (before || digit(i + 1));
        out.extend((is_point && !before).then_some(b'0'));
        out.push(byte);
        out.extend((is_point && !digit(i + 1)).then_some(b'0'));
    }
}

/// A text in which numbers are as the parser takes them, and `nan`, `inf` and what C libraries print for them are numbers beyond all that are finite.
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
        let numeric = is_number(word);
        let odd = !numeric
            && ["nan", "inf", "#ind", "#qnan"]
                .iter()
                .any(|n| lower.contains(n));
        match (odd, numeric) {
            (true, _) => out.extend(b"1e999"),
            (_, true) => push_number(&mut out, word),
            _ => out.extend(word),
        }
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
