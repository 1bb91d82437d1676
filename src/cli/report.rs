//! `report`: tables, figures and HTML from rows, without rendering.

use super::args::FolderArgs;
use super::exit::{self, Failure};
use super::out;
use crate::standard_error::tell;

pub fn run(args: &FolderArgs) -> Result<u8, Failure> {
    let written = crate::report::write(&args.folder)?;
    out::write(written.summary);
    for file in &written.files {
        tell!("{}", file.display());
    }
    Ok(exit::OK)
}
