//! Which instructions answer ray queries, decided at run time.

/// A traversal with the tree it needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Eight boxes or triangles at a time; needs a processor with AVX2 and FMA (x86-64-v3).
    Wide,
    /// obvhs' traversal of its compressed tree; runs everywhere.
    Portable,
}

impl Kernel {
    /// The fastest kernel of this processor, or the portable one when the environment variable
    /// `LIGHTBENCH_KERNEL` is `portable`.
    pub fn best() -> Self {
        let forced = std::env::var_os("LIGHTBENCH_KERNEL").is_some_and(|v| v == "portable");
        if Self::Wide.is_available() && !forced {
            Self::Wide
        } else {
            Self::Portable
        }
    }

    /// Whether this processor has the instructions.
    pub fn is_available(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Wide => super::wide::Features::detect().is_some(),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Wide => false,
            Self::Portable => true,
        }
    }

    /// The name for provenance.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wide => "wide-avx2-fma",
            Self::Portable => "portable",
        }
    }
}
