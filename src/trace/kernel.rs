//! Which instructions answer ray queries, decided at run time.

/// The environment variable that names a kernel.
const VARIABLE: &str = "LIGHTBENCH_KERNEL";

/// A traversal with the tree it needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Eight boxes or triangles at a time; needs a processor with AVX2 and FMA (x86-64-v3).
    Wide,
    /// As [`Kernel::Wide`], with a triangle test that no ray passes between neighbours.
    Watertight,
    /// obvhs' traversal of its compressed tree; runs everywhere.
    Portable,
}

impl Kernel {
    pub const ALL: [Self; 3] = [Self::Wide, Self::Watertight, Self::Portable];

    /// The kernel that the environment variable `LIGHTBENCH_KERNEL` names (`wide`, `watertight` or
    /// `portable`), or the fastest one of this processor when it is not set.
    ///
    /// # Errors
    /// A name that is not one of these, or a kernel that this processor cannot run.
    pub fn requested() -> Result<Self, String> {
        let Some(value) = std::env::var_os(VARIABLE) else {
            return Ok(if Self::Wide.is_available() {
                Self::Wide
            } else {
                Self::Portable
            });
        };
        let kernel = match value.to_str() {
            Some("wide") => Self::Wide,
            Some("watertight") => Self::Watertight,
            Some("portable") => Self::Portable,
            _ => {
                return Err(format!(
                    "{VARIABLE} = {value:?}: expected wide, watertight or portable"
                ));
            }
        };
        if kernel.is_available() {
            Ok(kernel)
        } else {
            Err(format!(
                "{VARIABLE} = {value:?}: this processor lacks AVX2 or FMA; only portable runs here"
            ))
        }
    }

    /// [`Kernel::requested`], or the portable kernel where that is an error; the command line refuses
    /// such a request before anything is traced.
    pub fn best() -> Self {
        Self::requested().unwrap_or(Self::Portable)
    }

    /// Whether this processor has the instructions.
    pub fn is_available(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Wide | Self::Watertight => super::wide::Features::detect().is_some(),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Wide | Self::Watertight => false,
            Self::Portable => true,
        }
    }

    /// The name for provenance.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wide => "wide-avx2-fma",
            Self::Watertight => "watertight-avx2-fma",
            Self::Portable => "portable",
        }
    }
}
