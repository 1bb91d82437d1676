//! Instruction sets: which of them this processor has, and those that the environment hides, so that one machine can speak for
//! another. Functions that go through many numbers are compiled once for each (`compiled_for_avx512`).

use std::sync::OnceLock;

/// The environment variable with the names, between commas.
const VARIABLE: &str = "LIGHTBENCH_HIDE";

/// An instruction set that a processor may lack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// AVX-512: F, VL and DQ.
    Avx512,
    /// AVX2, FMA and the other ones of x86-64-v3; hidden, it hides AVX-512 too.
    Avx2,
}

impl Instructions {
    const ALL: [Self; 2] = [Self::Avx512, Self::Avx2];

    /// The widest of this processor.
    pub fn best() -> Option<Self> {
        Self::ALL.into_iter().find(|set| set.is_present())
    }

    /// As the environment variable has it.
    fn name(self) -> &'static str {
        match self {
            Self::Avx512 => "avx512",
            Self::Avx2 => "avx2",
        }
    }

    /// Whether the program must do without it.
    #[cfg(target_arch = "x86_64")]
    fn is_hidden(self) -> bool {
        hidden().as_ref().is_ok_and(|sets| sets.contains(&self))
    }

    /// Whether this processor has it, and it is not hidden.
    pub fn is_present(self) -> bool {
        static PRESENT: OnceLock<[bool; 2]> = OnceLock::new();
        PRESENT.get_or_init(|| Self::ALL.map(Self::detect))[self as usize]
    }

    #[cfg(target_arch = "x86_64")]
    fn detect(self) -> bool {
        if self.is_hidden() {
            return false;
        }
        match self {
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512dq")
                    && Self::Avx2.detect()
            }
            Self::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
                    && is_x86_feature_detected!("lzcnt")
                    && is_x86_feature_detected!("popcnt")
            }
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn detect(self) -> bool {
        false
    }
}

/// Compiles a function for AVX-512, for AVX2 and for any processor, and calls what this one has: `#[apply(compiled_for_avx512)]`.
/// Nothing is reassociated or fused, so that all copies give the same to the last bit.
macro_rules! compiled_for_avx512 {
    ($($function:tt)*) => {
        $crate::instructions::compiled! { Avx512, $($function)* }
    };
}

/// The same without AVX-512.
macro_rules! compiled_for_avx2 {
    ($($function:tt)*) => {
        $crate::instructions::compiled! { Avx2, $($function)* }
    };
}

macro_rules! compiled {
    (
        $widest:ident, $(#[$attribute:meta])* $visible:vis fn $name:ident(
            $($argument:ident: $type:ty),* $(,)?
        ) $(-> $returned:ty)? $body:block
    ) => {
        $(#[$attribute])*
        $visible fn $name($($argument: $type),*) $(-> $returned)? {
            #[inline(always)]
            fn any($($argument: $type),*) $(-> $returned)? $body
            #[cfg(target_arch = "x86_64")]
            {
                use $crate::instructions::Instructions;
                #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
                fn avx512($($argument: $type),*) $(-> $returned)? {
                    any($($argument),*)
                }
                #[target_feature(enable = "avx2,fma")]
                fn avx2($($argument: $type),*) $(-> $returned)? {
                    any($($argument),*)
                }
                let may_be_avx512 = matches!(Instructions::$widest, Instructions::Avx512);
                if may_be_avx512 && Instructions::Avx512.is_present() {
                    // SAFETY: the processor has the instructions.
                    return unsafe { avx512($($argument),*) };
                }
                if Instructions::Avx2.is_present() {
                    // SAFETY: as above.
                    return unsafe { avx2($($argument),*) };
                }
            }
            any($($argument),*)
        }
    };
}
pub(crate) use {compiled, compiled_for_avx2, compiled_for_avx512};

/// What `LIGHTBENCH_HIDE` hides, read once.
///
/// # Errors
/// A name that is not known, in a sentence; nothing is hidden then.
pub fn hidden() -> &'static Result<Vec<Instructions>, String> {
    static HIDDEN: OnceLock<Result<Vec<Instructions>, String>> = OnceLock::new();
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

fn parse(list: &str) -> Result<Vec<Instructions>, String> {
    let names = list.split(',').map(str::trim).filter(|n| !n.is_empty());
    let set = |name: &str| {
        let known = Instructions::ALL
            .into_iter()
            .find(|known| known.name() == name);
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
            Ok(vec![Instructions::Avx512, Instructions::Avx2])
        );
        assert!(parse("avx512,sse9").is_err_and(|text| text.contains("avx512,sse9")));
    }
}
