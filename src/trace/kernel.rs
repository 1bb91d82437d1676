//! Which instructions answer ray queries, decided at run time.

use crate::instructions::{Instructions, hidden};

/// The environment variable that names a kernel.
const VARIABLE: &str = "LIGHTBENCH_KERNEL";

/// A traversal with the tree it needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// As many boxes or triangles at a time as a register has lanes.
    Wide(Instructions),
    /// As [`Kernel::Wide`], with a triangle test that no ray passes between neighbours.
    Watertight(Instructions),
    /// obvhs' traversal of its compressed tree; runs everywhere.
    Portable,
}

impl Kernel {
    /// Every kernel, whether this processor can run it or not.
    pub const ALL: [Self; 5] = [
        Self::Wide(Instructions::Avx512),
        Self::Wide(Instructions::Avx2),
        Self::Watertight(Instructions::Avx512),
        Self::Watertight(Instructions::Avx2),
        Self::Portable,
    ];

    /// The wide kernel for the best instructions of this processor, if it has any.
    pub fn wide() -> Option<Self> {
        Instructions::best().map(Self::Wide)
    }

    /// The watertight kernel for the best instructions of this processor, if it has any.
    pub fn watertight() -> Option<Self> {
        Instructions::best().map(Self::Watertight)
    }

    /// The kernel that the environment variable `LIGHTBENCH_KERNEL` names (`wide`, `watertight` or
    /// one of [`Kernel::name`]), or the fastest one of this processor when it is not set.
    ///
    /// # Errors
    /// A name that is not one of these, or a kernel that this processor cannot run; a name that
    /// `LIGHTBENCH_HIDE` does not know.
    pub fn requested() -> Result<Self, String> {
        hidden().as_ref().map_err(String::clone)?;
        let Some(value) = std::env::var_os(VARIABLE) else {
            return Ok(Self::wide().unwrap_or(Self::Portable));
        };
        let name = value.to_str().unwrap_or_default();
        let named = Self::ALL.into_iter().find(|kernel| kernel.name() == name);
        let found = match name {
            "wide" => Self::wide(),
            "watertight" => Self::watertight(),
            _ if named.is_none() => {
                let names = Self::ALL.map(Self::name).join(", ");
                return Err(format!(
                    "{VARIABLE} = {value:?}: expected wide, watertight or one of {names}"
                ));
            }
            _ => named.filter(|kernel| kernel.is_available()),
        };
        found.ok_or_else(|| {
            let present = Self::ALL.into_iter().filter(|kernel| kernel.is_available());
            let names: Vec<&str> = present.map(Self::name).collect();
            format!(
                "{VARIABLE} = {value:?}: this processor lacks the instructions, or they are hidden; it runs {}",
                names.join(", ")
            )
        })
    }

    /// [`Kernel::requested`], or the portable kernel where that is an error; the command line refuses
    /// such a request before anything is traced.
    pub fn best() -> Self {
        Self::requested().unwrap_or(Self::Portable)
    }

    /// Whether this processor has the instructions and they are not hidden.
    pub fn is_available(self) -> bool {
        match self {
            Self::Wide(set) | Self::Watertight(set) => set.is_present(),
            Self::Portable => true,
        }
    }

    /// The name for provenance.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wide(Instructions::Avx512) => "wide-avx512",
            Self::Wide(Instructions::Avx2) => "wide-avx2-fma",
            Self::Watertight(Instructions::Avx512) => "watertight-avx512",
            Self::Watertight(Instructions::Avx2) => "watertight-avx2-fma",
            Self::Portable => "portable",
        }
    }
}
