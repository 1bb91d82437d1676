//! The tiles of fast hierarchical importance sampling (Ostromoukhov, Donohue & Jodoin 2004):
//! Robinson triangles of a Penrose tiling that are subdivided where importance asks for it, and the
//! points they carry with their thresholds in the Fibonacci number system.

use glam::DVec2;

const GOLDEN: f64 = 1.618_033_988_749_895;
/// Subdivisions of the whole plane before importance is looked at.
const UNIFORM_LEVELS: u32 = 6;
/// 2 bits a level in a code of 32.
const MOST_LEVELS: u32 = 16;

/// Two of them carry a point and are infinitely small; two are skinny and two fat triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    PointA,
    PointB,
    SkinnyC,
    SkinnyD,
    FatE,
    FatF,
}

#[derive(Clone, Copy, Debug)]
struct Tile {
    kind: Kind,
    level: u32,
    /// Direction in units of π/10.
    turn: u32,
    corner: DVec2,
    scale: f64,
    code: u32,
}

/// A point with the importance from which on it is a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub position: DVec2,
    pub threshold: f64,
}

/// What the tiling asks of the importance.
pub(super) trait Importance {
    /// At a point.
    fn at(&self, position: DVec2) -> f64;
    /// The largest value in a rectangle, or more.
    fn most_within(&self, low: DVec2, high: DVec2) -> f64;
}

fn unit(turn: u32) -> DVec2 {
    let (sin, cos) = (f64::from(turn % 20) * std::f64::consts::PI / 10.0).sin_cos();
    DVec2::new(-sin, cos)
}

impl Tile {
    /// All three corners; those of a point coincide.
    fn corners(&self) -> [DVec2; 3] {
        let edge = |turn: u32, length: f64| self.corner + unit(turn) * (length * self.scale);
        let [second, third] = match self.kind {
            Kind::PointA | Kind::PointB => [self.corner; 2],
            Kind::SkinnyC | Kind::SkinnyD => [edge(self.turn, 1.0), edge(self.turn + 4, GOLDEN)],
            Kind::FatE | Kind::FatF => [
                edge(self.turn, GOLDEN * GOLDEN),
                edge(self.turn + 2, GOLDEN),
            ],
        };
        [self.corner, second, third]
    }

    fn child(&self, kind: Kind, bits: u32, corner: DVec2, rotation: u32) -> Self {
        Self {
            kind,
            level: self.level + 1,
            turn: (self.turn + rotation) % 20,
            corner,
            scale: self.scale / GOLDEN,
            code: (self.code << 2) ^ bits,
        }
    }

    /// Replaces the tile by its parts. Codes 00, 10 and 01 of the literature are 0, 1 and 2.
    fn divide(&self, out: &mut Vec<Self>) {
        let [p1, p2, p3] = self.corners();
        match self.kind {
            Kind::PointA => out.push(self.child(Kind::PointB, 0, p1, 0)),
            Kind::PointB => out.push(self.child(Kind::PointA, 0, p1, 10)),
            Kind::SkinnyC => {
                let first = self.child(Kind::FatF, 0, p3, 14);
                let end = first.corners()[2];
                out.push(first);
                out.push(self.child(Kind::SkinnyC, 1, p2, 6));
                out.push(self.child(Kind::PointA, 1, end, 1));
            }
            Kind::SkinnyD => {
                let first = self.child(Kind::FatE, 0, p2, 6);
                let end = first.corners()[2];
                out.push(first);
                out.push(self.child(Kind::SkinnyD, 1, end, 14));
            }
            Kind::FatE => {
                let first = self.child(Kind::SkinnyC, 1, p3, 12);
                let end = first.corners()[1];
                out.push(first);
                out.push(self.child(Kind::FatE, 2, p2, 8));
                out.push(self.child(Kind::FatF, 0, p1, 0));
                out.push(self.child(Kind::PointA, 1, end, 7));
            }
            Kind::FatF => {
                let first = self.child(Kind::FatF, 2, p3, 12);
                let end = first.corners()[2];
                let second = self.child(Kind::FatE, 0, end, 0);
                let second_end = second.corners()[2];
                out.push(first);
                out.push(second);
                out.push(self.child(Kind::SkinnyD, 1, second_end, 8));
                out.push(self.child(Kind::PointA, 2, end, 15));
            }
        }
    }

    fn is_point(&self) -> bool {
        matches!(self.kind, Kind::PointA | Kind::PointB)
    }

    /// Value of the code: its bits, the oldest first, weigh 1, 2, 3, 5, 8, …
    fn threshold(&self) -> f64 {
        let bits = 2 * self.level;
        let (mut weight, mut next, mut sum) = (1u64, 2u64, 0u64);
        for bit in (0..bits).rev() {
            if self.code >> bit & 1 == 1 {
                sum += weight;
            }
            (weight, next) = (next, weight + next);
        }
        sum as f64
    }
}

/// The level at which the thresholds of all points of this importance are told apart.
fn level_for(importance: f64) -> u32 {
    let digits = (5f64.sqrt() * importance + 1.0).ln() / GOLDEN.ln();
    let bits = (digits.floor() - 1.0).max(1.0);
    (bits / 2.0).ceil().min(f64::from(MOST_LEVELS)) as u32
}

/// The points within `[0, size.x) × [0, size.y)` whose importance reaches their threshold.
pub(super) fn points(size: DVec2, importance: &dyn Importance) -> Vec<Candidate> {
    let scale = 2.0 * size.max_element();
    let mut open = vec![Tile {
        kind: Kind::FatF,
        level: 0,
        turn: 15,
        corner: -DVec2::new(0.5 * GOLDEN * GOLDEN - 0.25, 0.125) * scale,
        scale,
        code: 0,
    }];
    let mut found = Vec::new();
    while let Some(tile) = open.pop() {
        let corners = tile.corners();
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        if low.cmpge(size).any() || high.cmplt(DVec2::ZERO).any() {
            continue;
        }
        let required = level_for(importance.most_within(low, high)).max(UNIFORM_LEVELS);
        if tile.level < required.min(MOST_LEVELS) {
            tile.divide(&mut open);
        } else if tile.is_point() {
            let own = importance.at(tile.corner);
            if own > 0.0 && own >= tile.threshold() {
                found.push(Candidate {
                    position: tile.corner,
                    threshold: tile.threshold(),
                });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Constant(f64);

    impl Importance for Constant {
        fn at(&self, _: DVec2) -> f64 {
            self.0
        }

        fn most_within(&self, _: DVec2, _: DVec2) -> f64 {
            self.0
        }
    }

    #[test]
    fn points_grow_in_proportion_to_importance_and_keep_apart() {
        let count = |importance: f64| points(DVec2::ONE, &Constant(importance)).len() as f64;
        for importance in [400.0, 930.0, 2500.0, 9000.0] {
            let ratio = count(2.0 * importance) / count(importance);
            assert!((1.7..2.3).contains(&ratio), "{importance}: {ratio}");
        }
        let found = points(DVec2::ONE, &Constant(3000.0));
        let nearest = |p: DVec2| {
            found
                .iter()
                .map(|q| (q.position - p).length())
                .filter(|d| *d > 0.0)
                .fold(f64::INFINITY, f64::min)
        };
        // Blue noise: most points keep a good part of the distance of a hexagonal lattice.
        let lattice = (2.0 / (3f64.sqrt() * found.len() as f64)).sqrt();
        let apart = found
            .iter()
            .filter(|c| nearest(c.position) > 0.45 * lattice)
            .count();
        assert!(apart * 10 > found.len() * 9, "{apart} of {}", found.len());
    }

    #[test]
    fn points_of_lower_importance_remain_when_it_rises() {
        let low = points(DVec2::ONE, &Constant(1000.0));
        let high = points(DVec2::ONE, &Constant(1020.0));
        let kept = |c: &&Candidate| {
            high.iter()
                .any(|h| (h.position - c.position).length() < 1e-9)
        };
        assert!(low.iter().filter(kept).count() * 10 >= low.len() * 9);
    }
}
