//! `ref status` and `ref extend`.

use std::collections::HashSet;

use super::args::{RefExtendArgs, RefStatusArgs};
use super::exit::{self, Failure};
use super::out::say;
use crate::experiment::{Loaded, Reference, ReferenceStore, Store, build_technique};
use crate::standard_error::tell;

/// One line a stored reference; damaged ones are told, and decide the exit code.
pub fn status(args: &RefStatusArgs) -> Result<u8, Failure> {
    let store = ReferenceStore {
        folder: args.folder.clone(),
    };
    let found = store.list()?;
    if found.references.is_empty() && found.set_aside.is_empty() {
        return Err(Failure::nothing(format!(
            "no reference in {}",
            args.folder.display()
        )));
    }
    say!("key               size       samples        floor (RMSE)  seconds");
    let mut damaged = 0;
    for (key, path) in found.references {
        match Reference::read(&path) {
            Ok(reference) => say!("{}", line(&key, &reference)),
            Err(error) => {
                damaged += 1;
                say!("{key}  damaged: {error}");
            }
        }
    }
    for path in &found.set_aside {
        say!("{}  was damaged and is set aside", path.display());
    }
    match damaged {
        0 => Ok(exit::OK),
        count => Err(Failure::usage(format!(
            "{count} damaged in {}: `lightbench run` renders those again that it needs, `lightbench ref extend DIR` \
             all of a results folder",
            args.folder.display()
        ))),
    }
}

fn line(key: &str, reference: &Reference) -> String {
    let floor = reference
        .floor()
        .map_or("unknown".to_owned(), |f| format!("{f:.3e}"));
    let unfinished = match reference.samples < reference.wanted {
        true => "  unfinished",
        false => "",
    };
    format!(
        "{key}  {:>4}x{:<4}  {:>6}/{:<6}  {floor:>12}  {:>8.1}{unfinished}",
        reference.mean.width,
        reference.mean.height,
        reference.samples,
        reference.wanted,
        reference.seconds,
    )
}

/// Adds passes to every reference of a results folder, and renders those that are absent or damaged.
pub fn extend(args: &RefExtendArgs) -> Result<u8, Failure> {
    let plan = Store::open(&args.folder)?.plan()?;
    let store = ReferenceStore::beside(&args.folder);
    let mut done: HashSet<&str> = HashSet::new();
    for job in &plan.jobs {
        if !done.insert(&job.reference) {
            continue;
        }
        let technique = build_technique(job)?;
        let wanted = match technique.reference_is_random() {
            true => args.samples,
            false => None,
        };
        if args.samples.is_some() && wanted.is_none() {
            say!(
                "{}: {} is exact at its {} sub-pixel samples; nothing to add",
                job.scene,
                job.technique,
                job.spp
            );
        }
        let mut loaded = Loaded::new(job, technique.as_ref())?;
        let first = loaded
            .views(job, job.sequence.frames[0])
            .map_err(Failure::job)?;
        let exposures: Vec<f32> = first
            .iter()
            .map(|view| {
                let begun = job.sequence.frames[0];
                loaded.shot(job, begun, view, technique.as_ref()).exposure
            })
            .collect();
        for frame in job.sequence.measured() {
            let keys = job.references_of(frame, &loaded.declared);
            let views = loaded.views(job, frame).map_err(Failure::job)?;
            let views = views.iter().zip(keys.unwrap_or_default());
            for ((view, key), exposure) in views.zip(&exposures) {
                let mut shot = loaded.shot(job, frame, view, technique.as_ref());
                shot.exposure = *exposure;
                let mut reference = store.obtain(&key, technique.as_ref(), &shot, &|_, _| {})?;
                if let Some(samples) = wanted {
                    let shown = |done, all| tell!("{}: {done}/{all}", job.scene);
                    let path = store.path(&key);
                    let technique = technique.as_ref();
                    store.extend(&mut reference, &path, samples, technique, &shot, &shown)?;
                }
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
