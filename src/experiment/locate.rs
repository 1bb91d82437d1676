//! Where a key path stands in a TOML text.

use toml::de::{DeTable, DeValue};

/// Byte offset of the value at `path` (keys, and decimal indices into arrays), or of the deepest
/// enclosing value that exists; `None` if the text is not TOML.
pub fn locate(text: &str, path: &[&str]) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let mut offset = 0;
    let mut here: Option<&DeValue> = None;
    for segment in path {
        let next = match (here, segment.parse::<usize>()) {
            (None, _) => root
                .get_ref()
                .get_key_value(*segment)
                .map(|(k, v)| (k.span().start, v)),
            (Some(DeValue::Table(table)), _) => table
                .get_key_value(*segment)
                .map(|(k, v)| (k.span().start, v)),
            (Some(DeValue::Array(array)), Ok(index)) => {
                array.get(index).map(|v| (v.span().start, v))
            }
            _ => None,
        };
        let Some((start, value)) = next else { break };
        offset = start;
        here = Some(value.get_ref());
    }
    Some(offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_keys_inside_arrays_of_tables() {
        let text = "a = 1\n[[method]]\nid = \"x\"\n[[method]]\nid = \"y\"\nsize = 3\n";
        let at = locate(text, &["method", "1", "size"]).expect("toml");
        assert!(text[at..].starts_with("size = 3"));
        let parent = locate(text, &["method", "1", "absent"]).expect("toml");
        assert_eq!(&text[parent..parent + 2], "[[");
    }
}
