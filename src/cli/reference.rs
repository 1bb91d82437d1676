//! `ref status` and `ref extend`.

use super::args::{RefExtendArgs, RefStatusArgs};
use super::exit::{self, Failure};
use super::out::say;
use super::run::references_beside;
use crate::experiment::{Reference, ReferenceStore, Store, build_technique, load_world, shot_of};

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
    let store = ReferenceStore {
        folder: references_beside(&args.folder),
    };
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
        let mut world = load_world(job, technique.as_ref())?;
        let shot = shot_of(job, world.at(0.0))?;
        let mut reference =
            store.obtain(&job.reference, (technique.as_ref(), &shot), &|_, _| {})?;
        let path = store.path(&job.reference);
        store.extend(
            &mut reference,
            (&path, args.samples),
            (technique.as_ref(), &shot),
            &|done, all| {
                eprintln!("{}: {done}/{all}", job.scene);
            },
        )?;
        say!("{}: {} samples", job.scene, reference.samples);
    }
    Ok(exit::OK)
}
