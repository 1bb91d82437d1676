//! OBJ and MTL files as other programs write them, made plain: one statement a line, without comments.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::text::decoded;

/// Name of the material of faces below a `usemtl` that names none.
const NAMELESS: &str = "(nameless)";

/// Statements that shape nothing that is seen, or nothing by themselves.
const SILENT: [&str; 29] = [
    "", "v", "vt", "vn", "vp", "f", "g", "o", "s", "mg", "mtllib", "usemtl", "cstype", "deg",
    "bmat", "step", "parm", "trim", "hole", "scrv", "sp", "end", "con", "lod", "bevel", "c_interp",
    "d_interp", "ctech", "stech",
];

/// An OBJ file in a form that every reader understands.
#[derive(Debug, Default)]
pub(super) struct PlainObj {
    /// Every statement stands in the line that it began in.
    pub text: String,
    /// What is not used, in words, and how often it occurs.
    pub left_out: BTreeMap<String, usize>,
}

/// The text of an OBJ file: lines that `\` continues are joined, comments are cut off wherever they stand, and points,
/// lines, curves and colours of vertices, which are not used here, are left out and counted.
pub(super) fn plain_obj(bytes: &[u8]) -> PlainObj {
    let text = decoded(bytes);
    let mut plain = PlainObj {
        text: String::with_capacity(text.len()),
        left_out: BTreeMap::new(),
    };
    // A last line that does not end may be cut: what lacks there is not left out, but refused.
    let ends = text.is_empty() || text.ends_with(['\n', '\r']);
    let mut statements = statements(&text).peekable();
    while let Some((statement, lines)) = statements.next() {
        let whole = ends || statements.peek().is_some();
        match small_face(&statement).filter(|_| whole) {
            Some(corners) => {
                let what = format!("faces of {corners} corners (`f`)");
                *plain.left_out.entry(what).or_insert(0) += 1;
            }
            None => plain.push(&statement),
        }
        plain.text.extend(std::iter::repeat_n('\n', lines));
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

impl PlainObj {
    fn push(&mut self, statement: &str) {
        let mut words = statement.split_whitespace();
        let unused = match words.next().unwrap_or("") {
            "v" => {
                let bare = bare(statement);
                let vertex = without_colour(bare);
                self.text.push_str(vertex);
                let dropped = bare[vertex.len()..].split_whitespace().count();
                (dropped >= 3).then(|| "colours of vertices".to_owned())
            }
            "vt" => {
                self.text.push_str(bare(statement));
                if let (Some(_), None) = (words.next(), words.next()) {
                    // A texture of one dimension.
                    self.text.push_str(" 0");
                }
                None
            }
            "vn" | "f" => {
                self.text.push_str(bare(statement));
                None
            }
            // What faces were called before version 3 of the format, which reads them so.
            "fo" => {
                self.text.push_str(&bare(statement).replacen("fo", "f", 1));
                None
            }
            // The parser wants a blank behind it, and a name.
            "usemtl" => {
                let name = statement.trim_start()["usemtl".len()..].trim();
                let name = if name.is_empty() { NAMELESS } else { name };
                self.text.push_str("usemtl ");
                self.text.push_str(name);
                None
            }
            "l" => Some("lines (`l`)".to_owned()),
            "p" => Some("points (`p`)".to_owned()),
            word @ ("curv" | "curv2" | "surf") => {
                Some(format!("curves and surfaces of free form (`{word}`)"))
            }
            known if SILENT.contains(&known) => {
                self.text.push_str(statement);
                None
            }
            other => Some(format!("unknown statements (`{}`)", clip(other))),
        };
        if let Some(unused) = unused {
            *self.left_out.entry(unused).or_insert(0) += 1;
        }
    }
}

/// How many corners a face has, if they are too few.
fn small_face(statement: &str) -> Option<usize> {
    let mut words = bare(statement).split_whitespace();
    let corners = matches!(words.next()?, "f" | "fo").then(|| words.take(3).count());
    corners.filter(|&count| count < 3)
}

/// At most twenty characters of a word, for messages; what cannot be printed is written out.
fn clip(word: &str) -> String {
    let start = word.chars().take(20).collect::<String>();
    start.escape_debug().to_string()
}

/// Numbers without a comment that touches the last of them. (Some programs write `-1.#IND` for what is none.)
pub(super) fn bare(statement: &str) -> &str {
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
            plain_obj(text.as_bytes()).text,
            "v 0 0 0 \nf 1   2 3\n\n\nv 1 2 3\nusemtl (nameless)\nusemtl wood#1\n"
        );
    }

    #[test]
    fn names_of_materials_may_stand_behind_any_blanks() {
        let plain = plain_obj(b"usemtl\twood oak\n usemtl  \t b \nusemtl\t\n");
        assert_eq!(plain.text, "usemtl wood oak\nusemtl b\nusemtl (nameless)\n");
    }

    #[test]
    fn endless_continuation_and_other_encodings_end() {
        let text = |bytes: &[u8]| plain_obj(bytes).text;
        assert_eq!(text(b"f 1 2 3\\"), "f 1 2 3 \n");
        assert_eq!(text(b"g caf\xe9\n"), "g café\n");
        assert_eq!(text(b"\xff\xfeg\0 \0a\0\n\0"), "g a\n");
        assert_eq!(text(b"\xfe\xff\0g\0 \0a\0\n"), "g a\n");
        assert_eq!(text(b""), "");
    }

    #[test]
    fn faces_of_two_corners_are_left_out_but_where_the_file_may_be_cut() {
        let plain = plain_obj(b"f 1 2\nf 1\nf # none\nf 1/1 2/2 # 3/3\nf 1 2 3\n");
        assert_eq!(plain.text, "\n\n\n\nf 1 2 3\n");
        let told: Vec<(&str, usize)> = plain
            .left_out
            .iter()
            .map(|(w, n)| (w.as_str(), *n))
            .collect();
        let faces = |corners: usize| {
            [
                "faces of 0 corners (`f`)",
                "faces of 1 corners (`f`)",
                "faces of 2 corners (`f`)",
            ][corners]
        };
        assert_eq!(told, [(faces(0), 1), (faces(1), 1), (faces(2), 2)]);
        assert_eq!(plain_obj(b"f 1 2 3\nf 1 2").text, "f 1 2 3\nf 1 2\n");
    }

    #[test]
    fn what_is_no_vertex_is_left_to_be_refused() {
        for line in ["v 1 2", "v 1 2 x 4", "v 1 2 3 4 5"] {
            assert_eq!(plain_obj(line.as_bytes()).text, format!("{line}\n"));
        }
    }

    #[test]
    fn what_is_left_out_is_counted() {
        let text = "v 0 0 0 1 0 0\nv 1 0 0 0.5\nvt 0.25 # half\nvt 0 1\nl 1 2\nsurf 0 1 0 1 1 2\nkurv 1\nkurv 2\ns off\nend\n";
        let plain = plain_obj(text.as_bytes());
        let told: Vec<(&str, usize)> = plain
            .left_out
            .iter()
            .map(|(w, n)| (w.as_str(), *n))
            .collect();
        let expected = [
            ("colours of vertices", 1),
            ("curves and surfaces of free form (`surf`)", 1),
            ("lines (`l`)", 1),
            ("unknown statements (`kurv`)", 2),
        ];
        assert_eq!(told, expected);
        assert!(
            plain
                .text
                .starts_with("v 0 0 0\nv 1 0 0\nvt 0.25  0\nvt 0 1\n\n\n\n"),
            "{}",
            plain.text
        );
    }
}
