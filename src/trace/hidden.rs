//! Instruction sets that the environment hides, so that one machine can speak for another.

use std::sync::OnceLock;

/// The environment variable with the names, between commas.
const VARIABLE: &str = "LIGHTBENCH_HIDE";

/// An instruction set that can be hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hideable {
    Avx512,
    /// AVX2 and FMA, and with them AVX-512.
    Avx2,
}

impl Hideable {
    const ALL: [Self; 2] = [Self::Avx512, Self::Avx2];

    /// As the environment variable has it.
    fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
        }
    }

    /// Whether the program must do without it.
    #[cfg(target_arch = "x86_64")]
    pub fn is_hidden(self) -> bool {
        hidden().as_ref().is_ok_and(|sets| sets.contains(&self))
    }
}

/// What `LIGHTBENCH_HIDE` hides, read once.
///
/// # Errors
/// A name that is not known, in a sentence; nothing is hidden then.
pub fn hidden() -> &'static Result<Vec<Hideable>, String> {
    static HIDDEN: OnceLock<Result<Vec<Hideable>, String>> = OnceLock::new();
    HIDDEN.get_or_init(|| match std::env::var_os(VARIABLE) {
        None => Ok(Vec::new()),
        Some(value) => parse(&value.to_string_lossy()),
    })
}

/// Names of the instruction sets that `LIGHTBENCH_HIDE` hides, for provenance.
pub fn hidden_instructions() -> Vec<&'static str> {
    let hidden = hidden().as_deref().unwrap_or_default();
    hidden.iter().map(|set| set.name()).collect()
}

fn parse(list: &str) -> Result<Vec<Hideable>, String> {
    let names = list.split(',').map(str::trim).filter(|n| !n.is_empty());
    let set = |name: &str| {
        let known = Hideable::ALL.into_iter().find(|known| known.name() == name);
        known.ok_or_else(|| format!("{VARIABLE} = {list:?}: expected avx512, avx2 or both"))
    };
    names.map(set).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_and_unknown_ones_refused() {
        assert_eq!(parse(""), Ok(vec![]));
        assert_eq!(
            parse("avx512, avx2"),
            Ok(vec![Hideable::Avx512, Hideable::Avx2])
        );
        assert!(parse("avx512,sse9").is_err_and(|text| text.contains("avx512,sse9")));
    }
}
