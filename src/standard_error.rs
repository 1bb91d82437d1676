//! Standard error whose reader may have gone.

use std::fmt::Display;
use std::io::Write;

/// Prints a line to standard error. What cannot be printed there can be told nowhere, and is no reason to end.
pub fn write(text: impl Display) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// Says something on standard error, as `eprintln` does, whoever reads it.
macro_rules! tell {
    ($($text:tt)*) => {
        $crate::standard_error::write(format_args!($($text)*))
    };
}
pub(crate) use tell;
