//! Exit codes, and errors that carry one.

use std::fmt;

pub const OK: u8 = 0;
/// Wrong usage, config, scene or image.
pub const USAGE: u8 = 2;
pub const NOTHING_SELECTED: u8 = 3;
pub const SOME_FAILED: u8 = 4;
pub const GATE_FAILED: u8 = 10;
pub const GATE_INCONCLUSIVE: u8 = 11;
pub const GATE_NO_DATA: u8 = 12;
pub const INTERRUPTED: u8 = 130;

/// An error with its exit code.
#[derive(Debug)]
pub struct Failure {
    pub code: u8,
    message: String,
}

impl Failure {
    /// Wrong input: exit code 2.
    pub fn usage(message: impl fmt::Display) -> Self {
        Self {
            code: USAGE,
            message: message.to_string(),
        }
    }

    /// Nothing to do: exit code 3.
    pub fn nothing(message: impl fmt::Display) -> Self {
        Self {
            code: NOTHING_SELECTED,
            message: message.to_string(),
        }
    }

    /// A job that could not be done: exit code 4.
    pub fn job(message: impl fmt::Display) -> Self {
        Self {
            code: SOME_FAILED,
            message: message.to_string(),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// Everything that stops a verb before a job is wrong input or a place that cannot be written.
impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::usage(error)
    }
}
