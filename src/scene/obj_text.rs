//! OBJ and MTL files as other programs write them, made plain: one statement a line, without comments.

use std::borrow::Cow;

use super::text::decoded;

/// Name of the material of faces below a `usemtl` that names none.
const NAMELESS: &str = "(nameless)";

/// The text of an OBJ file in a form that every reader understands, with every statement in the line that it began in.
///
/// Lines that `\` continues are joined, comments are cut off wherever they stand, and points, lines and colours of
/// vertices, which are not used here, are left out.
pub(super) fn plain_obj(bytes: &[u8]) -> String {
    let text = decoded(bytes);
    let mut plain = String::with_capacity(text.len());
    for (statement, lines) in statements(&text) {
        push(&mut plain, &statement);
        plain.extend(std::iter::repeat_n('\n', lines));
    }
    plain
}

/// Statements, each with the number of lines that it takes.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (Cow<'_, str>, usize)> {
    let mut lines = text.lines();
    std::iter::from_fn(move || {
        let mut statement = Cow::Borrowed(without_comment(lines.next()?));
        let mut count = 1;
        while let Some(start) = continued(&statement) {
            let mut joined = start.to_owned();
            let next = lines.next().map(without_comment);
            count += usize::from(next.is_some());
            joined.push(' ');
            joined.push_str(next.unwrap_or(""));
            statement = Cow::Owned(joined);
        }
        Some((statement, count))
    })
}

/// What stands before the `\` at the end of a line.
fn continued(line: &str) -> Option<&str> {
    line.trim_end().strip_suffix('\\')
}

/// A line without what follows a `#` that stands at its beginning or behind a blank.
fn without_comment(line: &str) -> &str {
    let begins = |&(i, _): &(usize, &str)| i == 0 || line[..i].ends_with(char::is_whitespace);
    match line.match_indices('#').find(begins) {
        Some((i, _)) => &line[..i],
        None => line,
    }
}

fn push(plain: &mut String, statement: &str) {
    let mut words = statement.split_whitespace();
    match words.next().unwrap_or("") {
        "l" | "p" => {}
        "v" | "vt" | "vn" | "f" => plain.push_str(without_colour(bare(statement))),
        "usemtl" if words.next().is_none() => {
            plain.push_str("usemtl ");
            plain.push_str(NAMELESS);
        }
        _ => plain.push_str(statement),
    }
}

/// Numbers without a comment that touches the last of them. (Some programs write `-1.#IND` for what is none.)
fn bare(statement: &str) -> &str {
    let touches = |&(i, _): &(usize, &str)| statement[..i].ends_with(|c: char| c.is_ascii_digit());
    match statement.match_indices('#').find(touches) {
        Some((i, _)) => &statement[..i],
        None => statement,
    }
}

/// A vertex without the colour, or the weight, behind its three coordinates.
fn without_colour(statement: &str) -> &str {
    let words: Vec<&str> = statement.split_whitespace().collect();
    let numbers = words.iter().skip(1).all(|word| word.parse::<f64>().is_ok());
    if words.first() != Some(&"v") || !numbers || !matches!(words.len(), 5 | 7 | 8) {
        return statement;
    }
    let end = words[3].as_ptr() as usize + words[3].len() - statement.as_ptr() as usize;
    &statement[..end]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_keep_their_lines() {
        let text = "\u{feff}v 0 0 0 # corner\r\nf 1 \\\r\n 2 3\rl 1 2 3\nv 1 2 3 0.5 0.5 0.5\nusemtl\nusemtl wood#1\n";
        assert_eq!(
            plain_obj(text.as_bytes()),
            "v 0 0 0 \nf 1   2 3\n\n\nv 1 2 3\nusemtl (nameless)\nusemtl wood#1\n"
        );
    }

    #[test]
    fn endless_continuation_and_other_encodings_end() {
        assert_eq!(plain_obj(b"f 1 2 3\\"), "f 1 2 3 \n");
        assert_eq!(plain_obj(b"g caf\xe9\n"), "g café\n");
        assert_eq!(plain_obj(b""), "");
    }

    #[test]
    fn what_is_no_vertex_is_left_to_be_refused() {
        for line in ["v 1 2", "v 1 2 x 4", "v 1 2 3 4 5"] {
            assert_eq!(plain_obj(line.as_bytes()), format!("{line}\n"));
        }
    }
}
