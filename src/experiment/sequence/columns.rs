//! The numbers of `frames.csv`, as figures name them.

use super::super::columns::{Column, is_declared};
use super::frame::{FrameRecord, line};

/// Columns of `frames.csv` that say which frame it is rather than what came of it.
const PLACES: [&str; 5] = ["frame", "viewer", "time_s", "measured", "reference"];

/// Names of the numbers of a frame but those of its stages. `all_rays` follows from two of them.
pub fn frame_columns() -> Vec<String> {
    let line = line(&FrameRecord::default(), &[]);
    let numbers = line.into_iter().map(|(key, _)| key);
    numbers
        .filter(|key| !PLACES.contains(&key.as_str()))
        .chain(["all_rays".to_owned()])
        .collect()
}

/// Whether frames have a number of this name; `seconds_<stage>` and `cpu_seconds_<stage>` of any stage are.
pub fn is_frame_column(key: &str) -> bool {
    let stage = ["seconds_", "cpu_seconds_"].iter().any(|start| {
        let stage = key.strip_prefix(start);
        stage.is_some_and(|stage| !stage.is_empty())
    });
    key == "flip" || (stage && is_declared(key)) || frame_columns().iter().any(|known| known == key)
}

/// A number of frames as plots show it. Where rows have it too, it is called and scaled alike.
pub fn frame_column(key: &str) -> Column {
    let (like, heading) = match key {
        "records" => ("caches", "records"),
        "error_change" => ("rmse", "change of the error"),
        _ => return Column::of(key),
    };
    Column {
        key: key.to_owned(),
        heading: heading.to_owned(),
        ..Column::of(like)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_stages_are_columns_and_places_are_not() {
        for key in ["rmse", "flip", "error_change", "all_rays", "bytes_cache"] {
            assert!(is_frame_column(key), "{key}");
        }
        for key in ["seconds_total", "seconds_placement", "cpu_seconds_any"] {
            assert!(is_frame_column(key), "{key}");
        }
        for key in ["frame", "reference", "seconds_", "rmse_worst", "flicker"] {
            assert!(!is_frame_column(key), "{key}");
        }
        assert_eq!(frame_column("error_change").heading, "change of the error");
        for key in frame_columns() {
            let heading = frame_column(&key).heading;
            assert!(heading != key || !key.contains('_'), "{key} has no heading");
        }
    }
}
