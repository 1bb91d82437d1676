//! Random choices without repetition, and what all first stages do when points are few.

use rayon::prelude::*;

use super::Placement;
use super::members::usable;
use crate::cache::ShadingPoints;
use crate::sample::Rng;

/// Streams of random numbers, one for each use.
pub(super) const STREAM_UNIFORM: u64 = 0x706c_0001;
pub(super) const STREAM_CELLS: u64 = 0x706c_0002;
pub(super) const STREAM_MEMBER: u64 = 0x706c_0003;
pub(super) const STREAM_TRIM: u64 = 0x706c_0004;
pub(super) const STREAM_FILL: u64 = 0x706c_0005;
pub(super) const STREAM_MAP: u64 = 0x706c_0006;

/// The points that can be placed on, or all of them as a placement if there are no more than
/// `count`.
pub(super) fn choice(points: &ShadingPoints, count: usize) -> Result<Vec<u32>, Placement> {
    let usable = usable(points);
    if count > 0 && count < usable.len() {
        return Ok(usable);
    }
    let mut notes = Vec::new();
    if count > usable.len() {
        let message = "only {} usable shading points for {} records: every point is a record";
        notes.push(
            message
                .replacen("{}", &usable.len().to_string(), 1)
                .replacen("{}", &count.to_string(), 1),
        );
    }
    let sites = if count == 0 { Vec::new() } else { usable };
    Err(Placement {
        sites,
        notes,
        ..Placement::default()
    })
}

/// Moves `count` distinct random entries to the front (partial Fisher–Yates) and drops the rest.
pub(super) fn keep_random(entries: &mut Vec<u32>, count: usize, rng: &mut Rng) {
    let count = count.min(entries.len());
    for i in 0..count {
        let other = i + rng.below(entries.len() - i);
        entries.swap(i, other);
    }
    entries.truncate(count);
}

/// Brings `sites` to `count` distinct entries of `usable`: surplus ones leave at random, missing
/// ones are drawn uniformly from the rest. Returns how many were added (negative: removed).
pub(super) fn adjust(sites: &mut Vec<u32>, usable: &[u32], count: usize, seed: u64) -> isize {
    let before = sites.len();
    if before > count {
        keep_random(sites, count, &mut Rng::new(seed, STREAM_TRIM, 0, 0));
    } else if before < count {
        let mut taken = sites.clone();
        taken.par_sort_unstable();
        let mut free: Vec<u32> = usable
            .par_iter()
            .copied()
            .filter(|i| taken.binary_search(i).is_err())
            .collect();
        let mut rng = Rng::new(seed, STREAM_FILL, 0, 0);
        keep_random(&mut free, count - before, &mut rng);
        sites.extend(free);
    }
    sites.len() as isize - before as isize
}
