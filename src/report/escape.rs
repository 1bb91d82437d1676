//! Text in other languages: Markdown, LaTeX, file names, links and shells.

/// Text inside a cell of a Markdown table.
pub fn markdown(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '|' | '*' | '_' | '`' | '\\' | '[' | ']' | '<' | '>' => out.extend(['\\', c]),
            '\n' | '\r' => out.push(' '),
            _ => out.push(c),
        }
    }
    out
}

/// Text in LaTeX's text mode.
pub fn latex(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', c]),
            '\\' => out.push_str("\\textbackslash{}"),
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '<' => out.push_str("\\textless{}"),
            '>' => out.push_str("\\textgreater{}"),
            '↓' => out.push_str("$\\downarrow$"),
            '↑' => out.push_str("$\\uparrow$"),
            '±' => out.push_str("$\\pm$"),
            '·' => out.push_str("$\\cdot$"),
            '⁶' => out.push_str("$^{6}$"),
            '⁹' => out.push_str("$^{9}$"),
            '—' => out.push_str("---"),
            '–' => out.push_str("--"),
            '×' => out.push_str("$\\times$"),
            '\n' | '\r' => out.push(' '),
            _ => out.push(c),
        }
    }
    out
}

/// Text and attributes of XML.
pub fn xml(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A file name that needs no quoting: letters, digits, `+`, `-`, `_` and inner dots are kept. Where
/// anything had to be replaced a hash follows, so that different texts keep different names.
pub fn file_name(text: &str) -> String {
    let keep = |c: char| c.is_ascii_alphanumeric() || "+-_.".contains(c);
    let name: String = text
        .chars()
        .take(80)
        .map(|c| if keep(c) { c } else { '-' })
        .collect();
    let name = name.trim_matches('.');
    match name == text && !name.is_empty() {
        true => name.to_owned(),
        false => format!("{name}-{}", &crate::experiment::hash(text)[..6]),
    }
}

/// A relative path as it stands in a link.
pub fn link(path: &str) -> String {
    path.replace('%', "%25")
        .replace('+', "%2B")
        .replace(' ', "%20")
        .replace('#', "%23")
        .replace('?', "%3F")
}

/// One argument of a shell command.
pub fn shell(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,+:@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', "'\\''"))
}

/// Text without the characters that XML cannot hold: control characters and two that are no characters.
pub fn xml_text(text: &str) -> std::borrow::Cow<'_, str> {
    let refused = |c: char| {
        c.is_control() && !matches!(c, '\t' | '\n' | '\r') || matches!(c, '\u{fffe}' | '\u{ffff}')
    };
    match text.contains(refused) {
        true => text.replace(refused, "\u{fffd}").into(),
        false => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn special_characters_lose_their_meaning() {
        assert_eq!(markdown("a|b_*c*\n"), "a\\|b\\_\\*c\\* ");
        assert_eq!(
            latex("50 % of A_B & {x}\\"),
            "50 \\% of A\\_B \\& \\{x\\}\\textbackslash{}"
        );
        assert_eq!(latex("RMSE ↓"), "RMSE $\\downarrow$");
        assert_eq!(file_name("VGC+DGS"), "VGC+DGS");
        assert!(file_name("../VGC+DGS <b>").starts_with("-VGC+DGS--b--"));
        assert_ne!(file_name("a b"), file_name("a/b"));
        assert!(file_name("...").starts_with('-') && file_name("").starts_with('-'));
        assert_eq!(link("figures/a+b c.png"), "figures/a%2Bb%20c.png");
        assert_eq!(
            xml_text("bell \u{7}\u{ffff}\n<"),
            "bell \u{fffd}\u{fffd}\n<"
        );
        assert_eq!(shell("scale=1/4"), "scale=1/4");
        assert_eq!(shell("it's"), "'it'\\''s'");
    }
}
