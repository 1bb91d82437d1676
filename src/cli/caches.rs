//! `caches`: where a cached method has its records.

use super::args::CachesArgs;
use super::exit::{self, Failure};
use super::render::Prepared;
use crate::standard_error::tell;

/// Writes `x,y,z,nx,ny,nz,px,py,stage`: scene units in the scene's own frame, pixels from the top
/// left, stage 0 for the first stage and 1 for the refinement.
pub fn run(args: &CachesArgs) -> Result<u8, Failure> {
    let mut prepared = Prepared::new(&args.contender)?;
    if prepared.is_exact() {
        return Err(Failure::usage(
            "the reference has no records; name a method that has",
        ));
    }
    let rendered = prepared.render()?;
    if rendered.records.is_empty() {
        return Err(Failure::usage(
            "this method made no records; name one that does with --method, such as VGC, or on-demand with --technique irradiance-caching",
        ));
    }
    let width = prepared.job.width as u32;
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["x", "y", "z", "nx", "ny", "nz", "px", "py", "stage"])?;
    for record in &rendered.records {
        let p = record.site.position.as_dvec3() + prepared.scene().origin;
        let n = record.site.normal;
        let mut cells: Vec<String> = [p.x, p.y, p.z].map(|v| v.to_string()).to_vec();
        cells.extend([n.x, n.y, n.z].map(|v| v.to_string()));
        cells.push((record.pixel % width).to_string());
        cells.push((record.pixel / width).to_string());
        cells.push(record.stage.to_string());
        writer.write_record(&cells)?;
    }
    let bytes = writer.into_inner()?;
    crate::files::write(&args.out, bytes)?;
    tell!("{} records", rendered.records.len());
    Ok(exit::OK)
}
