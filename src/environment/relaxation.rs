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
    /// Chords: at least the one to the own centre, at most the one to any other.
    bounds: Vec<[f64; 2]>,
}

impl<'a> Cells<'a> {
    /// Assigns every item; there must be a centre.
    pub fn new(items: &'a [Item], centres: Vec<DVec3>) -> Self {
        let mut cells = Self {
            items,
            centres,
            labels: vec![0; items.len()],
            bounds: vec![[0.0; 2]; items.len()],
        };
        for (index, item) in items.iter().enumerate() {
            (cells.labels[index], cells.bounds[index]) = nearest(&cells.centres, item.direction);
        }
        cells
    }

    /// Direction of an item.
    pub fn direction(&self, item: usize) -> DVec3 {
        self.items[item].direction
    }

    /// Adds a centre and gives it the items that are nearer to it than to their own.
    pub fn insert(&mut self, centre: DVec3) {
        let new = self.centres.len() as u32;
        self.centres.push(centre);
        for (index, item) in self.items.iter().enumerate() {
            let distance = (item.direction - centre).length();
            let own = self.centres[self.labels[index] as usize];
            let bounds = &mut self.bounds[index];
            if distance >= bounds[0] {
                bounds[1] = bounds[1].min(distance);
                continue;
            }
            let exact = (item.direction - own).length();
            if distance < exact {
                *bounds = [distance, exact.min(bounds[1])];
                self.labels[index] = new;
            } else {
                *bounds = [exact, bounds[1].min(distance)];
            }
        }
    }

    /// Moves centres to the centroids of their cells and assigns again, until nothing changes or
    /// `most` rounds have passed; returns the number of rounds. Centres of cells without a centroid
    /// (empty, or balanced) stay.
    pub fn relax(&mut self, most: usize) -> usize {
        for round in 0..most {
            let moved = self.move_centres();
            if !self.assign_again(&moved) {
                return round + 1;
            }
        }
        most
    }

    /// Moves every centre to its centroid; returns how far.
    pub fn move_centres(&mut self) -> Vec<f64> {
        let mut moments = vec![DVec3::ZERO; self.centres.len()];
        for (item, &label) in self.items.iter().zip(&self.labels) {
            moments[label as usize] += item.moment;
        }
        let mut moved = vec![0.0; self.centres.len()];
        for ((centre, moment), moved) in self.centres.iter_mut().zip(moments).zip(&mut moved) {
            if let Some(centroid) = moment.try_normalize() {
                *moved = (centroid - *centre).length();
                *centre = centroid;
            }
        }
        moved
    }

    /// Whether any item changed its cell.
    fn assign_again(&mut self, moved: &[f64]) -> bool {
        /// Covers the rounding of distances.
        const SLACK: f64 = 1e-12;
        let largest = moved.iter().copied().fold(0.0, f64::max);
        let mut changed = false;
        for (index, item) in self.items.iter().enumerate() {
            let label = self.labels[index];
            let bounds = &mut self.bounds[index];
            bounds[0] += moved[label as usize];
            bounds[1] -= largest;
            if bounds[0] + SLACK < bounds[1] {
                continue;
            }
            bounds[0] = (item.direction - self.centres[label as usize]).length();
            if bounds[0] + SLACK < bounds[1] {
                continue;
            }
            let (new, exact) = nearest(&self.centres, item.direction);
            if new != label && exact[0] < bounds[0] {
                self.labels[index] = new;
                *bounds = exact;
                changed = true;
            } else {
                bounds[1] = if new == label { exact[1] } else { exact[0] };
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
            let moved = cells.move_centres();
            let mut moments = vec![DVec3::ZERO; plain.len()];
            for (item, label) in items.iter().zip(plain_labels(&items, &plain)) {
                moments[label as usize] += item.moment;
            }
            plain = moments.iter().map(|m| m.normalize()).collect();
            assert_eq!(cells.centres, plain);
            if !cells.assign_again(&moved) {
                assert!(round > 3);
                break;
            }
        }
    }

    #[test]
    fn inserted_centres_take_their_items() {
        let items = items(1000);
        let mut rng = Rng::new(5, 0, 0, 0);
        let mut cells = Cells::new(&items, vec![direction(&mut rng)]);
        for _ in 0..10 {
            cells.insert(direction(&mut rng));
            assert_eq!(cells.labels, plain_labels(&items, &cells.centres));
            cells.relax(3);
        }
        // A centre on top of another takes nothing.
        cells.insert(cells.centres[2]);
        assert!(cells.labels.iter().all(|&l| l != 11));
    }
}
