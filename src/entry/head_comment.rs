//! The comment at the head of a module, taken out of its source while the program is built.

/// The `//!` lines that a source file begins with: the rest of the file stays out of the program.
macro_rules! head_comment {
    ($file:literal) => {{
        const SOURCE: &str = include_str!($file);
        const HEAD: [u8; $crate::entry::head_length(SOURCE)] = $crate::entry::head_of(SOURCE);
        match std::str::from_utf8(&HEAD) {
            Ok(head) => head,
            Err(_) => unreachable!(),
        }
    }};
}
pub(crate) use head_comment;

/// Bytes of the lines at the head of a source that begin with `//!`.
pub const fn head_length(source: &str) -> usize {
    let bytes = source.as_bytes();
    let (mut end, mut at) = (0, 0);
    while at < bytes.len() {
        let column = at - end;
        if column < 3 && bytes[at] != b"//!"[column] {
            return end;
        }
        at += 1;
        if bytes[at - 1] == b'\n' {
            end = at;
        }
    }
    at
}

/// The first bytes of a source.
pub const fn head_of<const LENGTH: usize>(source: &str) -> [u8; LENGTH] {
    let mut head = [0; LENGTH];
    let (head_bytes, _) = source.as_bytes().split_at(LENGTH);
    head.copy_from_slice(head_bytes);
    head
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_ends_where_code_begins() {
        let length = |source: &str| head_length(source);
        assert_eq!(length("//! One.\n//!\n//! Two.\n\nuse a;\n"), 22);
        assert_eq!(length("use a;\n//! no head\n"), 0);
        assert_eq!(length("//! alone"), 9);
        assert_eq!(length("//"), 2, "no source");
        assert_eq!(&head_of::<8>("//! One.\n"), b"//! One.");
        assert!(head_comment!("head_comment.rs").ends_with("is built.\n"));
    }
}
