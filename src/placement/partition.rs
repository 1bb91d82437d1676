//! Splitting the members of a cluster in two, in place.

use rayon::prelude::*;

/// Clusters of this many members fit a core's cache.
const CACHED: usize = 1 << 14;
/// Clusters of more members are split by all threads.
const SHARED: usize = 1 << 17;
/// Members that one thread looks at in a row, where all threads look.
pub(super) const PART: usize = 1 << 14;

/// A member that can be split along axes.
pub(super) trait Coordinates: Copy + Send + Sync {
    fn coordinate(&self, axis: usize) -> f32;
    /// Which shading point it is.
    fn index(&self) -> u32;
}

/// Whether [`partition_large`] is the faster way.
pub(super) fn is_large<M>(members: &[M]) -> bool {
    members.len() > CACHED
}

/// Whether all threads split the members, and sum them up.
pub(super) fn is_shared<M>(members: &[M]) -> bool {
    members.len() > SHARED
}

/// Moves members below `plane` to the front and returns how many there are.
pub(super) fn partition<M: Coordinates>(members: &mut [M], axis: usize, plane: f32) -> usize {
    if is_shared(members) {
        return partition_shared(members, axis, plane);
    }
    if is_large(members) {
        return partition_large(members, axis, plane, [(); 2], |(), _| ()).0;
    }
    let mut low = 0;
    for i in 0..members.len() {
        // Swapping members that both belong above does no harm and saves a branch. Copies stay in
        // registers, unlike in `swap`, as long as nothing looks into them.
        let below = members[i].coordinate(axis) < plane;
        let (member, other) = (members[i], members[low]);
        members[low] = member;
        members[i] = other;
        low += usize::from(below);
    }
    low
}

/// The same for clusters that are bound by memory: only what is on the wrong side is moved, and
/// each member is added to the summary of its side while it is at hand.
pub(super) fn partition_large<M: Coordinates, S>(
    members: &mut [M],
    axis: usize,
    plane: f32,
    [mut below, mut above]: [S; 2],
    add: impl Fn(&mut S, &M),
) -> (usize, [S; 2]) {
    let (mut low, mut high) = (0, members.len());
    loop {
        while low < high && members[low].coordinate(axis) < plane {
            add(&mut below, &members[low]);
            low += 1;
        }
        while low < high && members[high - 1].coordinate(axis) >= plane {
            high -= 1;
            add(&mut above, &members[high]);
        }
        if low >= high {
            return (low, [below, above]);
        }
        members.swap(low, high - 1);
    }
}

/// As [`partition_large`], by all threads and without summaries: the members end in the same order, since the first
/// member on the wrong side always changes places with the last one.
fn partition_shared<M: Coordinates>(members: &mut [M], axis: usize, plane: f32) -> usize {
    let is_below = |member: &M| member.coordinate(axis) < plane;
    let parts = members.par_chunks(PART);
    let below: usize = parts
        .map(|part| part.iter().filter(|m| is_below(m)).count())
        .sum();
    let misplaced = |side: &[M], wanted: bool| -> Vec<u32> {
        let parts = side.par_chunks(PART).enumerate();
        parts
            .flat_map_iter(|(part, own)| {
                let wrong = move |&(_, m): &(usize, &M)| is_below(m) != wanted;
                let place = move |(i, _)| (part * PART + i) as u32;
                own.iter().enumerate().filter(wrong).map(place)
            })
            .collect()
    };
    let (low, high) = members.split_at_mut(below);
    let too_high = misplaced(low, true);
    let too_low = misplaced(high, false);
    let going_down: Vec<M> = too_low.par_iter().map(|&i| high[i as usize]).collect();
    let going_up: Vec<M> = too_high.par_iter().map(|&i| low[i as usize]).collect();
    put(low, &too_high, |i| going_down[going_down.len() - 1 - i]);
    put(high, &too_low, |i| going_up[going_up.len() - 1 - i]);
    below
}

/// Puts `member(i)` at the `i`-th of ascending places.
fn put<M: Coordinates>(members: &mut [M], places: &[u32], member: impl Fn(usize) -> M + Sync) {
    let parts = members.par_chunks_mut(PART).enumerate();
    parts.for_each(|(part, own)| {
        let start = part * PART;
        let before = |end: usize| places.partition_point(|&place| (place as usize) < end);
        for i in before(start)..before(start + own.len()) {
            own[places[i] as usize - start] = member(i);
        }
    });
}

/// Moves the lower half along an axis to the front and returns its size.
pub(super) fn halve<M: Coordinates>(members: &mut [M], axis: usize) -> usize {
    let middle = members.len() / 2;
    members.select_nth_unstable_by(middle, |a, b| {
        let order = a.coordinate(axis).total_cmp(&b.coordinate(axis));
        order.then(a.index().cmp(&b.index()))
    });
    middle
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::placement::members::Spot;
    use crate::sample::Rng;

    #[test]
    fn all_threads_leave_the_order_of_one() {
        let mut rng = Rng::new(7, 0, 0, 0);
        for (count, plane) in [
            (3 * PART + 5, 0.5),
            (2 * PART, 0.01),
            (PART + 1, 0.0),
            (70_000, 1.0),
        ] {
            let spot = |index| Spot {
                lanes: [rng.next_f32(), 0.0, 0.0, 0.0],
                index,
            };
            let mut alone: Vec<Spot> = (0..count as u32).map(spot).collect();
            let mut shared = alone.clone();
            let none = ([(); 2], |(): &mut (), _: &Spot| ());
            let (below, _) = partition_large(&mut alone, 0, plane, none.0, none.1);
            assert_eq!(partition_shared(&mut shared, 0, plane), below);
            let order = |spots: &[Spot]| spots.iter().map(|s| s.index).collect::<Vec<_>>();
            assert_eq!(
                order(&alone),
                order(&shared),
                "{count} members, plane {plane}"
            );
        }
    }
}
