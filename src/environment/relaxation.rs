//! Lloyd's relaxation of Voronoi cells on the sphere, with bounds that skip most distances (Hamerly
//! 2010). The result is that of the plain algorithm.

use glam::DVec3;

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
    /// The nearest centre of each item; of equally near ones the first, or the one it had before.
    pub labels: Vec<u32>,
    /// Σ moment of the items of each centre, kept up to date as they move.
    moments: Vec<DVec3>,
    /// Whether a moment lost so much at once that rounding shows in what is left.
    rounded: bool,
    bounds: Vec<Bounds>,
    drift: Drift,
}

/// Chords of an item, as if no centre had ever moved: those that [`Drift`] keeps are added.
#[derive(Clone, Copy, Debug, Default)]
struct Bounds {
    /// At least the chord to the own centre.
    own: f64,
    /// At most the chord to any other.
    other: f64,
}

/// How far the centres have moved in all.
#[derive(Clone, Debug)]
struct Drift {
    /// Each of them.
    own: Vec<f64>,
    /// Sum of the farthest moves of all rounds.
    farthest: f64,
}

/// Covers the rounding of distances.
const SLACK: f64 = 1e-12;

impl Drift {
    /// Bounds of an item in a cell, from chords of now.
    fn bounds(&self, label: u32, [own, other]: [f64; 2]) -> Bounds {
        Bounds {
            own: own - self.own[label as usize],
            other: other + self.farthest,
        }
    }

    /// Bounds of now on the chords of an item in a cell.
    fn chords(&self, label: u32, bounds: &Bounds) -> [f64; 2] {
        [
            bounds.own + self.own[label as usize],
            bounds.other - self.farthest,
        ]
    }
}

impl<'a> Cells<'a> {
    /// Assigns every item; there must be a centre.
    pub fn new(items: &'a [Item], centres: Vec<DVec3>) -> Self {
        let drift = Drift {
            own: vec![0.0; centres.len()],
            farthest: 0.0,
        };
        let mut moments = vec![DVec3::ZERO; centres.len()];
        let (labels, bounds) = items
            .iter()
            .map(|item| {
                let (label, chords) = nearest(&centres, item.direction);
                moments[label as usize] += item.moment;
                (label, drift.bounds(label, chords))
            })
            .unzip();
        Self {
            items,
            centres,
            labels,
            moments,
            rounded: false,
            bounds,
            drift,
        }
    }

    /// Direction of an item.
    pub fn direction(&self, item: usize) -> DVec3 {
        self.items[item].direction
    }

    /// Adds a centre and gives it the items that are nearer to it than to their own.
    pub fn insert(&mut self, centre: DVec3) {
        let new = self.centres.len() as u32;
        self.centres.push(centre);
        self.moments.push(DVec3::ZERO);
        self.drift.own.push(0.0);
        for index in 0..self.items.len() {
            let direction = self.items[index].direction;
            let label = self.labels[index];
            let [own, other] = self.drift.chords(label, &self.bounds[index]);
            let distance = (direction - centre).length();
            if distance >= own {
                let chords = [own, other.min(distance)];
                self.bounds[index] = self.drift.bounds(label, chords);
                continue;
            }
            let exact = (direction - self.centres[label as usize]).length();
            if distance < exact {
                self.assign(index, new, [distance, exact.min(other)]);
            } else {
                self.assign(index, label, [exact, other.min(distance)]);
            }
        }
    }

    /// Puts an item into a cell, with chords of now.
    fn assign(&mut self, index: usize, label: u32, chords: [f64; 2]) {
        let old = std::mem::replace(&mut self.labels[index], label);
        if old != label {
            let moment = self.items[index].moment;
            let left = self.moments[old as usize] - moment;
            self.rounded |= left.length_squared() < 1e-8 * moment.length_squared();
            self.moments[old as usize] = left;
            self.moments[label as usize] += moment;
        }
        self.bounds[index] = self.drift.bounds(label, chords);
    }

    /// Moves centres to the centroids of their cells and assigns again, until nothing changes, no centre
    /// moves as far as `least` or `most` rounds have passed; returns the number of rounds. Centres of
    /// cells without a centroid (empty, or balanced) stay.
    pub fn relax(&mut self, (most, least): (usize, f64)) -> usize {
        for round in 0..most {
            let farthest = self.move_centres();
            if !self.assign_again() || farthest < least {
                return round + 1;
            }
        }
        most
    }

    /// Moves every centre to its centroid; the farthest that one of them went.
    pub fn move_centres(&mut self) -> f64 {
        if std::mem::take(&mut self.rounded) {
            self.moments.fill(DVec3::ZERO);
            for (item, &label) in self.items.iter().zip(&self.labels) {
                self.moments[label as usize] += item.moment;
            }
        }
        let mut farthest = 0.0f64;
        let drifts = &mut self.drift.own;
        for ((centre, moment), drift) in self.centres.iter_mut().zip(&self.moments).zip(drifts) {
            if let Some(centroid) = moment.try_normalize() {
                let moved = (centroid - *centre).length();
                *centre = centroid;
                *drift += moved;
                farthest = farthest.max(moved);
            }
        }
        self.drift.farthest += farthest;
        farthest
    }

    /// Whether any item changed its cell.
    fn assign_again(&mut self) -> bool {
        let mut changed = false;
        for index in 0..self.items.len() {
            let label = self.labels[index];
            let [own, other] = self.drift.chords(label, &self.bounds[index]);
            if own + SLACK < other {
                continue;
            }
            let direction = self.items[index].direction;
            let own = (direction - self.centres[label as usize]).length();
            if own + SLACK < other {
                self.assign(index, label, [own, other]);
                continue;
            }
            let (new, exact) = nearest(&self.centres, direction);
            if new != label && exact[0] < own {
                self.assign(index, new, exact);
                changed = true;
            } else {
                let other = if new == label { exact[1] } else { exact[0] };
                self.assign(index, label, [own, other]);
            }
        }
        changed
    }
}

/// The nearest centre and the chords to it and to the next one.
fn nearest(centres: &[DVec3], direction: DVec3) -> (u32, [f64; 2]) {
    let (mut best, mut squared) = (0, [f64::INFINITY; 2]);
    for (index, centre) in centres.iter().enumerate() {
        let d = (direction - *centre).length_squared();
        if d < squared[0] {
            squared = [d, squared[0]];
            best = index as u32;
        } else if d < squared[1] {
            squared[1] = d;
        }
    }
    (best, squared.map(f64::sqrt))
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
        items
            .iter()
            .map(|item| nearest(centres, item.direction).0)
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
            if !cells.assign_again() {
                assert!(round > 3);
                break;
            }
        }
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
        cells.relax((10, 0.0));
        let expected = (items[1].moment + items[2].moment + items[3].moment).normalize();
        assert!(
            (cells.centres[0] - expected).length() < 1e-12,
            "{}",
            cells.centres[0]
        );
    }

    #[test]
    fn inserted_centres_take_their_items() {
        let items = items(1000);
        let mut rng = Rng::new(5, 0, 0, 0);
        let mut cells = Cells::new(&items, vec![direction(&mut rng)]);
        for _ in 0..10 {
            cells.insert(direction(&mut rng));
            assert_eq!(cells.labels, plain_labels(&items, &cells.centres));
            cells.relax((3, 0.0));
        }
        // A centre on top of another takes nothing.
        cells.insert(cells.centres[2]);
        assert!(cells.labels.iter().all(|&l| l != 11));
    }
}
