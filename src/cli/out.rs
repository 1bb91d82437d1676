//! Standard output whose reader may have gone.

use std::fmt::Display;
use std::io::{ErrorKind, Write};

use super::exit;
use crate::standard_error::tell;

/// Prints to standard output. A reader that has had enough, as `head` has, is no error: the command goes
/// on, so that its files and its exit code do not depend on who reads. Other errors end the program.
pub fn write(text: impl Display) {
    let mut out = std::io::stdout().lock();
    if let Err(error) = write!(out, "{text}").and_then(|()| out.flush())
        && error.kind() != ErrorKind::BrokenPipe
    {
        tell!("error: standard output: {error}");
        std::process::exit(i32::from(exit::USAGE));
    }
}

/// [`write`] of a line.
macro_rules! say {
    ($($text:tt)*) => {
        $crate::cli::out::write(format_args!("{}\n", format_args!($($text)*)))
    };
}
pub(super) use say;
