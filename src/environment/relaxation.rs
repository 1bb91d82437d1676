//! Lloyd's relaxation of Voronoi cells on the sphere. Items near each other are looked at together:
//! a group whose ball lies in one cell goes there as a whole, and the others compare only with the
//! centres whose cells their group's ball reaches (the filtering of Kanungo et al. 2002, with one level
//! of groups in place of a tree). The result is that of the plain algorithm.

use std::ops::Range;

use glam::DVec3;

use super::halving::{bounds, halve};

/// What is clustered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// Unit: which cell it belongs to.
    pub direction: DVec3,
    /// Weight · direction, summed over what it stands for: how it pulls the centre of its cell.
    pub moment: DVec3,
}

/// Items in the cells of centres.
#[derive(Clone, Debug)]
pub(super) struct Cells<'a> {
    items: &'a [Item],
    pub centres: Vec<DVec3>,
    /// The nearest centre of each item, of equally near ones the first.
    pub labels: Vec<u32>,
    /// Σ moment of the items of each centre, as far as they are within reach of it.
    moments: Vec<DVec3>,
    /// Chord beyond which an item does not pull its centre.
    reach: f64,
    groups: Vec<Group>,
    /// Indices of the items, group by group.
    members: Vec<u32>,
}

/// Items near each other.
#[derive(Clone, Debug)]
struct Group {
    /// Within [`Cells::members`].
    members: Range<usize>,
    /// A ball around all of them.
    middle: DVec3,
    radius: f64,
    moment: DVec3,
    /// The cell that all of them are in, if they were assigned together.
    label: Option<u32>,
}

/// Most members of a group.
const MOST_MEMBERS: usize = 32;
/// More items than this are divided by all threads.
const PARALLEL: usize = 1 << 11;
/// Covers the rounding of squared distances.
const SLACK: f64 = 1e-12;

impl<'a> Cells<'a> {
    /// Assigns every item; there must be a centre.
    pub fn new(items: &'a [Item], centres: Vec<DVec3>) -> Self {
        let mut members: Vec<u32> = (0..items.len() as u32).collect();
        let groups = divide(items, &mut members, 0);
        let mut cells = Self {
            items,
            centres,
            labels: vec![0; items.len()],
            moments: Vec::new(),
            reach: f64::INFINITY,
            groups,
            members,
        };
        cells.assign();
        cells
    }

    /// Lets only items within a chord of their centre pull it: a centre then stays with some of them, instead of
    /// going between those that are far apart.
    pub fn pulled_within(mut self, chord: f64) -> Self {
        self.reach = chord;
        self.assign();
        self
    }

    /// Whether an item is within reach of its centre.
    pub fn is_reached(&self, item: usize) -> bool {
        let centre = self.centres[self.labels[item] as usize];
        self.reaches(centre, self.items[item].direction)
    }

    /// Whether a direction is within reach of a centre.
    pub fn reaches(&self, centre: DVec3, direction: DVec3) -> bool {
        (direction - centre).length_squared() <= self.reach * self.reach
    }

    /// Puts centres elsewhere and assigns again.
    pub fn put(&mut self, moved: &[(usize, DVec3)]) {
        moved
            .iter()
            .for_each(|&(cell, centre)| self.centres[cell] = centre);
        self.assign();
    }

    /// Direction of an item.
    pub fn direction(&self, item: usize) -> DVec3 {
        self.items[item].direction
    }

    /// Adds a centre and gives it the items that are nearer to it than to any other.
    pub fn insert(&mut self, centre: DVec3) {
        self.centres.push(centre);
        self.assign();
    }

    /// Moves centres to the centroids of their cells and assigns again, until nothing changes, no centre
    /// moves as far as `least` or `most` rounds have passed; returns the number of rounds. Centres of
    /// cells without a centroid (empty, or balanced) stay.
    pub fn relax(&mut self, most: usize, least: f64) -> usize {
        for round in 0..most {
            let farthest = self.move_centres();
            let changed = self.assign() || self.reach.is_finite();
            if !changed || farthest < least || farthest == 0.0 {
                return round + 1;
            }
        }
        most
    }

    /// Moves every centre to its centroid; the farthest that one of them went.
    fn move_centres(&mut self) -> f64 {
        let mut farthest = 0.0f64;
        for (centre, moment) in self.centres.iter_mut().zip(&self.moments) {
            if let Some(centroid) = moment.try_normalize() {
                farthest = farthest.max((centroid - *centre).length());
                *centre = centroid;
            }
        }
        farthest
    }

    /// Puts every item into the cell of the nearest centre; whether any changed its cell.
    fn assign(&mut self) -> bool {
        let mut changed = false;
        let mut squared = vec![0.0; self.centres.len()];
        let mut reached = Vec::with_capacity(self.centres.len());
        self.moments.clear();
        self.moments.resize(self.centres.len(), DVec3::ZERO);
        for group in &mut self.groups {
            cells_reached(&self.centres, group, &mut squared, &mut reached);
            let members = &self.members[group.members.clone()];
            let (items, centres, reach) = (self.items, &self.centres, self.reach);
            let pulls = |item: u32, centre: u32| {
                let apart = items[item as usize].direction - centres[centre as usize];
                apart.length_squared() <= reach * reach
            };
            if let [only] = reached[..] {
                let distance = squared[only as usize].sqrt();
                let moment = &mut self.moments[only as usize];
                if distance + group.radius <= reach {
                    *moment += group.moment;
                } else if distance - group.radius <= reach {
                    let near = members.iter().filter(|&&item| pulls(item, only));
                    near.for_each(|&item| *moment += items[item as usize].moment);
                }
                if group.label != Some(only) {
                    for &item in members {
                        let old = std::mem::replace(&mut self.labels[item as usize], only);
                        changed |= old != only;
                    }
                    group.label = Some(only);
                }
                continue;
            }
            group.label = None;
            for &item in members {
                let Item { direction, moment } = self.items[item as usize];
                let label = nearest(centres, &reached, direction);
                if pulls(item, label) {
                    self.moments[label as usize] += moment;
                }
                let old = std::mem::replace(&mut self.labels[item as usize], label);
                changed |= old != label;
            }
        }
        changed
    }
}

/// Groups of items: they are halved along the longest side of their box until they are few.
fn divide(items: &[Item], members: &mut [u32], first: usize) -> Vec<Group> {
    let mut groups = Vec::with_capacity(2 * members.len() / MOST_MEMBERS + 1);
    if members.len() <= PARALLEL {
        append_groups(items, members, first, &mut groups);
        return groups;
    }
    let half = halve(members, |member| items[member as usize].direction);
    let (left, right) = members.split_at_mut(half);
    let (left, right) = rayon::join(
        || divide(items, left, first),
        || divide(items, right, first + half),
    );
    groups.extend(left);
    groups.extend(right);
    groups
}

fn append_groups(items: &[Item], members: &mut [u32], first: usize, groups: &mut Vec<Group>) {
    let direction = |member: u32| items[member as usize].direction;
    if members.len() > MOST_MEMBERS {
        let half = halve(members, direction);
        let (left, right) = members.split_at_mut(half);
        append_groups(items, left, first, groups);
        append_groups(items, right, first + half, groups);
        return;
    }
    let directions = || members.iter().map(|&member| direction(member));
    let [low, high] = bounds(directions());
    let middle = 0.5 * (low + high);
    let radius = directions()
        .map(|d| (d - middle).length())
        .fold(0.0, f64::max);
    groups.push(Group {
        members: first..first + members.len(),
        middle,
        radius,
        moment: members.iter().map(|&m| items[m as usize].moment).sum(),
        label: None,
    });
}

/// The centres that can be the nearest of a point in the group's ball, in ascending order. A point `x`
/// is nearer to `b` than to `a` beyond their bisector, of which the ball reaches no further than
/// `|m − a|² − |m − b|² + 2 r |a − b|`.
fn cells_reached(centres: &[DVec3], group: &Group, squared: &mut [f64], reached: &mut Vec<u32>) {
    let mut best = 0;
    for (index, centre) in centres.iter().enumerate() {
        squared[index] = (group.middle - *centre).length_squared();
        if squared[index] < squared[best] {
            best = index;
        }
    }
    reached.clear();
    for (index, centre) in centres.iter().enumerate() {
        let ahead = squared[index] - squared[best] - SLACK;
        let apart = (*centre - centres[best]).length_squared();
        if ahead <= 0.0 || ahead * ahead <= 4.0 * group.radius * group.radius * apart {
            reached.push(index as u32);
        }
    }
}

/// The nearest of some centres, of equally near ones the first.
fn nearest(centres: &[DVec3], among: &[u32], direction: DVec3) -> u32 {
    let (mut best, mut least) = (0, f64::INFINITY);
    for &index in among {
        let squared = (direction - centres[index as usize]).length_squared();
        if squared < least {
            (best, least) = (index, squared);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    fn direction(rng: &mut Rng) -> DVec3 {
        loop {
            let d = DVec3::new(rng.next_f64(), rng.next_f64(), rng.next_f64()) * 2.0 - 1.0;
            if d.length() < 1.0 && d.length() > 0.1 {
                return d.normalize();
            }
        }
    }

    fn items(count: usize) -> Vec<Item> {
        let mut rng = Rng::new(3, 0, 0, 0);
        (0..count)
            .map(|_| {
                let direction = direction(&mut rng);
                let moment = direction * rng.next_f64().powi(4);
                Item { direction, moment }
            })
            .collect()
    }

    fn plain_labels(items: &[Item], centres: &[DVec3]) -> Vec<u32> {
        let all: Vec<u32> = (0..centres.len() as u32).collect();
        items
            .iter()
            .map(|item| nearest(centres, &all, item.direction))
            .collect()
    }

    #[test]
    fn skipped_distances_change_nothing() {
        let items = items(2000);
        let mut rng = Rng::new(4, 0, 0, 0);
        let centres: Vec<DVec3> = (0..12).map(|_| direction(&mut rng)).collect();
        let mut cells = Cells::new(&items, centres.clone());
        let mut plain = centres;
        for round in 0..100 {
            assert_eq!(cells.labels, plain_labels(&items, &plain), "round {round}");
            cells.move_centres();
            let mut moments = vec![DVec3::ZERO; plain.len()];
            for (item, label) in items.iter().zip(plain_labels(&items, &plain)) {
                moments[label as usize] += item.moment;
            }
            plain = moments.iter().map(|m| m.normalize()).collect();
            for (centre, plain) in cells.centres.iter().zip(&plain) {
                assert!((*centre - *plain).length() < 1e-12, "{centre} {plain}");
            }
            if !cells.assign() {
                assert!(round > 3);
                break;
            }
        }
    }

    #[test]
    fn coincident_items_and_opposite_centres_have_their_cells() {
        let item = Item {
            direction: DVec3::Z,
            moment: DVec3::Z,
        };
        let items = [item; 100];
        let mut cells = Cells::new(&items, vec![-DVec3::Z, DVec3::X, DVec3::Y]);
        // Both are equally near: the first has them, and moves there.
        assert!(cells.labels.iter().all(|&label| label == 1));
        assert_eq!(cells.relax(10, 0.0), 1);
        assert_eq!(cells.centres, [-DVec3::Z, DVec3::Z, DVec3::Y]);
        assert_eq!(Cells::new(&[], vec![DVec3::X]).relax(10, 0.0), 1);
    }

    #[test]
    fn a_cell_that_loses_a_sun_keeps_an_exact_centroid() {
        let sun = Item {
            direction: DVec3::X,
            moment: DVec3::X * 1e20,
        };
        let dim = |y: f64| {
            let direction = DVec3::new(0.6, y, 0.0).normalize();
            Item {
                direction,
                moment: direction,
            }
        };
        let items = [sun, dim(0.7), dim(0.8), dim(0.9)];
        let mut cells = Cells::new(&items, vec![dim(0.8).direction]);
        cells.insert(DVec3::X);
        cells.relax(10, 0.0);
        let expected = (items[1].moment + items[2].moment + items[3].moment).normalize();
        assert!(
            (cells.centres[0] - expected).length() < 1e-12,
            "{}",
            cells.centres[0]
        );
    }

    #[test]
    fn what_is_out_of_reach_does_not_pull() {
        let lamp = |degrees: f64| {
            let (y, x) = degrees.to_radians().sin_cos();
            let direction = DVec3::new(x, y, 0.0);
            Item {
                direction,
                moment: direction,
            }
        };
        let items = [lamp(0.0), lamp(1.0), lamp(40.0)];
        let mut cells = Cells::new(&items, vec![items[0].direction]).pulled_within(0.1);
        cells.relax(10, 0.0);
        let expected = (items[0].direction + items[1].direction).normalize();
        assert!((cells.centres[0] - expected).length() < 1e-12);
        assert_eq!([0, 1, 2].map(|i| cells.is_reached(i)), [true, true, false]);
        cells.put(&[(0, items[2].direction)]);
        assert!(cells.is_reached(2));
    }

    #[test]
    fn inserted_centres_take_their_items() {
        let items = items(1000);
        let mut rng = Rng::new(5, 0, 0, 0);
        let mut cells = Cells::new(&items, vec![direction(&mut rng)]);
        for _ in 0..10 {
            cells.insert(direction(&mut rng));
            assert_eq!(cells.labels, plain_labels(&items, &cells.centres));
            cells.relax(3, 0.0);
        }
        // A centre on top of another takes nothing.
        cells.insert(cells.centres[2]);
        assert!(cells.labels.iter().all(|&l| l != 11));
    }
}
