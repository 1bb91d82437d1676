//! Many rays of one origin, 64 at a time: a tile of neighbouring directions descends the tree
//! together, so that nodes and triangles are fetched and prepared once for all of them.
//!
//! - A stack entry is a child with a mask of the rays that enter it; rays that are answered meanwhile
//!   drop out when it is popped.
//! - A node's boxes, taken relative to the origin, are first culled at once against the cone
//!   around the tile (its slopes along the main axis) and against `t_max`; each box left is tested
//!   against groups of rays, one a lane.
//! - A leaf prepares its triangles once ([`Seen`]); a ray then costs three dot products.
//! - When few rays are left, they go on alone with the single-ray kernel.
//!
//! Which path a ray takes never changes its answer: box tests lose no hit, and the triangle tests are
//! the same operations in the same order.

use super::Hit;
use super::lanes::Floats;
use super::query::{Bundle, Scratch, Waiting};
use super::single::{self, nearest_lane};
use super::tile::{Order, Relative, TILE, Tile, bits, reach_squared};
use super::triangle::{Seen, Vectors};
use super::wide::{LEAF, WideTree};

/// With this many rays or fewer, rays go on alone.
const FEW: u32 = 5;

/// See [`super::Caster::occluded_bundle`].
#[inline(always)]
pub fn occluded<F: Floats, const TIGHT: bool>(
    tree: &WideTree<F, TIGHT>,
    bundle: &Bundle,
    scratch: &mut Scratch,
    occluded: &mut [u64],
) {
    let order = Order::new(bundle.directions.len());
    for start in (0..bundle.directions.len()).step_by(TILE) {
        let mut tile = Tile::new(tree.present, bundle, order, start);
        if bundle.continues {
            for k in bits(tile.rays) {
                let i = order.index(start + k);
                tile.rays ^= (occluded[i / 64] >> (i % 64) & 1) << k;
            }
        }
        let blocked = occluded_tile(tree, &tile, scratch);
        for k in bits(blocked) {
            let i = order.index(start + k);
            occluded[i / 64] |= 1 << (i % 64);
        }
    }
}

/// See [`super::Caster::closest_bundle`].
#[inline(always)]
pub fn closest<F: Floats, const TIGHT: bool>(
    tree: &WideTree<F, TIGHT>,
    bundle: &Bundle,
    scratch: &mut Scratch,
    hits: &mut [Option<Hit>],
) {
    let order = Order::new(bundle.directions.len());
    for start in (0..bundle.directions.len()).step_by(TILE) {
        let mut tile = Tile::new(tree.present, bundle, order, start);
        let mut best = [None; TILE];
        if bundle.continues {
            for k in bits(tile.rays) {
                best[k] = hits[order.index(start + k)];
            }
        }
        let found = closest_tile(tree, &mut tile, best, scratch);
        for k in bits(tile.rays) {
            hits[order.index(start + k)] = found[k];
        }
    }
}

/// The rays of a tile that are blocked.
#[inline(always)]
fn occluded_tile<F: Floats, const TIGHT: bool>(
    tree: &WideTree<F, TIGHT>,
    tile: &Tile<F>,
    scratch: &mut Scratch,
) -> u64 {
    let present = tree.present;
    let origin = Vectors::splat(present, tile.origin);
    let reach = reach_squared(tile.bundle.t_max);
    let (t_min, t_max) = (F::splat(present, 0.0), F::splat(present, tile.bundle.t_max));
    let mut alive = tile.rays;
    let stack = &mut scratch.tiles;
    stack[0] = Waiting {
        rays: alive,
        ..Waiting::default()
    };
    let mut waiting = 1;
    while waiting > 0 {
        waiting -= 1;
        let Waiting { rays, child, .. } = stack[waiting];
        let rays = rays & alive;
        if child & LEAF != 0 {
            let seen = Seen::<F, TIGHT>::new(present, tree.block(child), origin);
            for k in bits(rays) {
                let crossing = seen.cross(tile.direction(k));
                if crossing.hits(present, t_min, t_max) != 0 {
                    alive ^= 1 << k;
                }
            }
        } else if rays.count_ones() <= FEW {
            for k in bits(rays) {
                let beam = tile.beam(k);
                if single::occluded(tree, &beam, child, &mut scratch.children) {
                    alive ^= 1 << k;
                }
            }
        } else {
            let node = tree.node(child);
            let planes = Relative::new(present, node, &tile.origin);
            let mut boxes = planes.within(present, reach);
            if let Some(cone) = &tile.cone {
                boxes &= cone.reaches(present, &planes);
            }
            while boxes != 0 {
                let lane = 31 - boxes.leading_zeros() as usize;
                boxes ^= 1 << lane;
                let entering = tile.entering(&planes, lane, rays);
                if entering != 0 {
                    tree.prefetch(node.children[lane]);
                    stack[waiting] = Waiting {
                        rays: entering,
                        child: node.children[lane],
                        distance_squared: 0.0,
                    };
                    waiting += 1;
                }
            }
        }
    }
    tile.rays & !alive
}

/// The closest hits of a tile, which also become the limits of its rays; `best` comes in with those of
/// another tree.
#[inline(always)]
fn closest_tile<F: Floats, const TIGHT: bool>(
    tree: &WideTree<F, TIGHT>,
    tile: &mut Tile<F>,
    mut best: [Option<Hit>; TILE],
    scratch: &mut Scratch,
) -> [Option<Hit>; TILE] {
    let present = tree.present;
    let origin = Vectors::splat(present, tile.origin);
    let mut reach = match tile.bundle.continues {
        true => tile.shorten(&best, tile.rays),
        false => reach_squared(tile.bundle.t_max),
    };
    let stack = &mut scratch.tiles;
    stack[0] = Waiting {
        rays: tile.rays,
        ..Waiting::default()
    };
    let mut waiting = 1;
    while waiting > 0 {
        waiting -= 1;
        let Waiting {
            rays,
            child,
            distance_squared,
        } = stack[waiting];
        let rays = tile.reaching(distance_squared, rays);
        if rays == 0 {
            continue;
        }
        if child & LEAF != 0 {
            let block = tree.block(child);
            let seen = Seen::<F, TIGHT>::new(present, block, origin);
            let mut nearer = 0;
            for k in bits(rays) {
                let crossing = seen.cross(tile.direction(k));
                let limits = [0.0, tile.t_max[k / F::LANES][k % F::LANES]];
                let found = nearest_lane(present, &crossing, block, limits, &mut best[k]);
                nearer |= u64::from(found) << k;
            }
            if nearer != 0 {
                reach = tile.shorten(&best, nearer);
            }
        } else if rays.count_ones() <= FEW {
            for k in bits(rays) {
                let beam = tile.beam(k);
                single::closest(tree, &beam, child, &mut scratch.sorted, &mut best[k]);
            }
            reach = tile.shorten(&best, rays);
        } else {
            let node = tree.node(child);
            let planes = Relative::new(present, node, &tile.origin);
            let mut boxes = planes.within(present, reach);
            if let Some(cone) = &tile.cone {
                boxes &= cone.reaches(present, &planes);
            }
            let first = waiting;
            while boxes != 0 {
                let lane = boxes.trailing_zeros() as usize % F::LANES;
                boxes &= boxes - 1;
                let entering = tile.entering(&planes, lane, rays);
                if entering == 0 {
                    continue;
                }
                tree.prefetch(node.children[lane]);
                let entry = Waiting {
                    rays: entering,
                    child: node.children[lane],
                    distance_squared: planes.distance_squared[lane],
                };
                insert(&mut stack[first..=waiting], entry);
                waiting += 1;
            }
        }
    }
    best
}

/// Puts an entry into its place in a run sorted from far to near, whose last place is free.
fn insert(run: &mut [Waiting], entry: Waiting) {
    let mut at = run.len() - 1;
    while at > 0 && run[at - 1].distance_squared < entry.distance_squared {
        run[at] = run[at - 1];
        at -= 1;
    }
    run[at] = entry;
}
