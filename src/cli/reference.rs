//! `ref status` and `ref extend`.

use super::args::{RefExtendArgs, RefStatusArgs};
use super::exit::{self, Failure};
use super::out::say;
use crate::experiment::{Loaded, Reference, ReferenceStore, Store, build_technique};
use crate::standard_error::tell;

/// One line a stored reference.
pub fn status(args: &RefStatusArgs) -> Result<u8, Failure> {
    let store = ReferenceStore {
        folder: args.folder.clone(),
    };
    let found = store.list()?;
    if found.is_empty() {
        return Err(Failure::nothing(format!(
            "no reference in {}",
            args.folder.display()
        )));
    }
    say!("key               size       samples        floor (RMSE)  seconds");
    for (key, path) in found {
        let r = Reference::read(&path)?;
        let floor = r
            .floor()
            .map_or("unknown".to_owned(), |f| format!("{f:.3e}"));
        say!(
            "{key}  {:>4}x{:<4}  {:>6}/{:<6}  {floor:>12}  {:>8.1}{}",
            r.mean.width,
            r.mean.height,
            r.samples,
            r.wanted,
            r.seconds,
            if r.samples < r.wanted {
                "  unfinished"
            } else {
                ""
            }
        );
    }
    Ok(exit::OK)
}

/// Adds passes to every reference of a results folder.
pub fn extend(args: &RefExtendArgs) -> Result<u8, Failure> {
    let plan = Store::open(&args.folder)?.plan()?;
    let store = ReferenceStore::beside(&args.folder);
    let mut done: Vec<&str> = Vec::new();
    for job in &plan.jobs {
        if done.contains(&job.reference.as_str()) {
            continue;
        }
        done.push(&job.reference);
        let technique = build_technique(job)?;
        if !technique.reference_is_random() {
            say!(
                "{}: {} is exact at its {} sub-pixel samples; nothing to add",
                job.scene,
                job.technique,
                job.spp
            );
            continue;
        }
        let mut loaded = Loaded::new(job, technique.as_ref())?;
        let first = loaded
            .views(job, job.sequence.frames[0])
            .map_err(Failure::job)?;
        let exposures: Vec<f32> = first
            .iter()
            .map(|view| {
                let begun = (job, job.sequence.frames[0]);
                loaded.shot(begun, view, technique.as_ref()).exposure
            })
            .collect();
        for frame in job.sequence.measured() {
            let keys = job.references_of(frame, &loaded.declared);
            let views = loaded.views(job, frame).map_err(Failure::job)?;
            let views = views.iter().zip(keys.unwrap_or_default());
            for ((view, key), exposure) in views.zip(&exposures) {
                let mut shot = loaded.shot((job, frame), view, technique.as_ref());
                shot.exposure = *exposure;
                let contents = (technique.as_ref(), &shot);
                let mut reference = store.obtain(&key, contents, &|_, _| {})?;
                let shown = |done, all| tell!("{}: {done}/{all}", job.scene);
                let extended = (store.path(&key), args.samples);
                store.extend(&mut reference, (&extended.0, extended.1), contents, &shown)?;
                say!(
                    "{}, frame {frame}: {} samples",
                    job.scene,
                    reference.samples
                );
            }
        }
    }
    Ok(exit::OK)
}
