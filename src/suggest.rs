//! What was perhaps meant by a name that nothing has.

/// The known name closest to `word`, if any is close enough to be a slip of the finger; case does not count.
pub fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let lower = word.to_lowercase();
    known
        .iter()
        .map(|&name| (distance(&lower, &name.to_lowercase()), name))
        .filter(|&(distance, name)| distance <= 1 + name.len().max(word.len()) / 3)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, name)| name)
}

/// `did you mean …?` where something is near, then what is known.
pub fn advice(word: &str, known: &[&str]) -> String {
    let list = match known.is_empty() {
        true => "none".to_owned(),
        false => known.join(", "),
    };
    match nearest(word, known) {
        Some(name) => format!("did you mean `{name}`? Known: {list}"),
        None => format!("known: {list}"),
    }
}

/// `; did you mean …?` where something is near, or nothing.
pub fn hint(word: &str, known: &[&str]) -> String {
    nearest(word, known).map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}

/// The message of a reader that lists what it expected (``unknown field `a`, expected one of `b`, `c` ``), with the
/// nearest of them put first.
pub fn with_hint(message: &str) -> String {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let is_about_names = ["unknown field", "unknown variant"]
        .iter()
        .any(|start| message.contains(start));
    match quoted.split_first() {
        Some((word, known)) if is_about_names => match nearest(word, known) {
            Some(name) => message.replacen(
                &format!("`{word}`, "),
                &format!("`{word}`; did you mean `{name}`? "),
                1,
            ),
            None => message.to_owned(),
        },
        _ => message.to_owned(),
    }
}

/// Edits between two words: characters put in, taken out, replaced or exchanged with their neighbours.
fn distance(a: &str, b: &str) -> usize {
    strsim::damerau_levenshtein(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_word_is_a_plausible_slip() {
        assert_eq!(distance("kitten", "sitting"), 3);
        let known = ["reflectance", "alpha"];
        assert_eq!(nearest("reflectence", &known), Some("reflectance"));
        assert_eq!(nearest("ALPAH", &known), Some("alpha"));
        assert_eq!(nearest("xyzzy", &known), None);
    }

    #[test]
    fn lists_of_readers_begin_with_the_nearest() {
        let message = "unknown field `cachez`, expected one of `name`, `caches`";
        assert_eq!(
            with_hint(message),
            "unknown field `cachez`; did you mean `caches`? expected one of `name`, `caches`"
        );
        for other in [
            "missing field `name`",
            "unknown field `zzzzzz`, expected `name`",
        ] {
            assert_eq!(with_hint(other), other);
        }
    }
}
