//! `ref status` and `ref extend`.

use super::args::{RefExtendArgs, RefStatusArgs};
use super::exit::{self, Failure};
use super::out::say;
use crate::experiment::{Loaded, Reference, ReferenceStore, Store, build_technique};

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
        let mut exposure = None;
        for frame in job.sequence.measured() {
            let time_s = job.sequence.time_s(frame);
            let declared = job.sequence.views(&loaded.declared, time_s);
            let views = loaded.views(job, frame).map_err(Failure::job)?;
            for (view, declared) in views.iter().zip(declared.unwrap_or_default()) {
                let key = job.reference_of(&declared, time_s);
                let mut shot = loaded.shot((job, frame), view, technique.as_ref());
                shot.exposure = *exposure.get_or_insert(shot.exposure);
                let contents = (technique.as_ref(), &shot);
                let mut reference = store.obtain(&key, contents, &|_, _| {})?;
                let shown = |done, all| eprintln!("{}: {done}/{all}", job.scene);
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
