//! Every reader of files that others wrote, of bytes: one place for fuzzing (`fuzz/`) and for the tests that mutate
//! sound files (`tests/readers.rs`).

use std::path::Path;

use crate::experiment::{Config, Override, Source};
use crate::scene::{READERS, Reader};

/// Readers beside those of scenes.
const OTHERS: &[Reader] = &[
    ("config", |bytes| {
        let source = Source {
            file: "config.toml".into(),
            text: String::from_utf8_lossy(bytes).into_owned(),
        };
        let config = source.parse::<Config>().map_err(|e| e.to_string())?;
        Config::check(&source, &config).map_err(|e| e.to_string())
    }),
    ("override", |bytes| {
        let parsed = Override::parse(&String::from_utf8_lossy(bytes));
        parsed.map(|_| ()).map_err(|error| error.to_string())
    }),
    // EXR, Radiance HDR, PNG and JPEG.
    ("image", |bytes| {
        let picture = crate::image::decode_bytes(Path::new("bytes"), None, bytes);
        picture.map(|_| ()).map_err(|error| error.to_string())
    }),
];

/// The names of the formats.
pub fn formats() -> impl Iterator<Item = &'static str> {
    READERS.iter().chain(OTHERS).map(|(name, _)| *name)
}

/// Reads bytes as a file of a format; an error is what a user would be told.
///
/// # Panics
/// On names that [`formats`] does not give.
pub fn read(format: &str, bytes: &[u8]) -> Result<(), String> {
    let mut all = READERS.iter().chain(OTHERS);
    let (_, reader) = all
        .find(|(name, _)| *name == format)
        .unwrap_or_else(|| panic!("no reader is called `{format}`"));
    reader(bytes)
}
