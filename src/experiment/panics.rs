//! Panics of a job become its reason of failure, so that one job's defect ends no run.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// The result of `work`, or what its panic said. What `work` was changing is not to be used again.
pub fn with_panics_as_errors<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic
            .downcast_ref::<&str>()
            .map(|text| (*text).to_owned())
            .or_else(|| panic.downcast_ref::<String>().cloned());
        let text = text.unwrap_or_else(|| "no message".into());
        Err(format!("a defect of this program: {text}"))
    })
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::with_panics_as_errors;

    #[test]
    fn panics_of_any_thread_become_reasons() {
        assert_eq!(with_panics_as_errors(|| Ok(3)), Ok(3));
        assert_eq!(
            with_panics_as_errors::<()>(|| Err("no".into())),
            Err("no".into())
        );
        let numbers = [1usize, 2, 3];
        let failed =
            with_panics_as_errors(|| Ok(numbers.par_iter().map(|&i| numbers[i]).sum::<usize>()));
        let reason = failed.expect_err("index 3 is out of bounds");
        assert!(reason.contains("index"), "{reason}");
    }
}
