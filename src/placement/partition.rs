//! Splitting the members of a cluster in two, in place.

/// Clusters of this many members fit a core's cache.
const CACHED: usize = 1 << 14;

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

/// Moves members below `plane` to the front and returns how many there are.
pub(super) fn partition<M: Coordinates>(members: &mut [M], axis: usize, plane: f32) -> usize {
    if is_large(members) {
        return partition_large(members, (axis, plane), [(); 2], |(), _| ()).0;
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
    (axis, plane): (usize, f32),
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

/// Moves the lower half along an axis to the front and returns its size.
pub(super) fn halve<M: Coordinates>(members: &mut [M], axis: usize) -> usize {
    let middle = members.len() / 2;
    members.select_nth_unstable_by(middle, |a, b| {
        let order = a.coordinate(axis).total_cmp(&b.coordinate(axis));
        order.then(a.index().cmp(&b.index()))
    });
    middle
}
