//! `report`: tables, figures and HTML from rows, without rendering.

use super::args::ReportArgs;
use super::exit::{self, Failure};
use super::out;
use crate::standard_error::tell;

pub fn run(args: &ReportArgs) -> Result<u8, Failure> {
    let write = match args.single_file {
        true => crate::report::write_single_file,
        false => crate::report::write,
    };
    let written = write(&args.folder)?;
    out::write(written.summary);
    for file in &written.files {
        tell!("{}", file.display());
    }
    Ok(exit::OK)
}
