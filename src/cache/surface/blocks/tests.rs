use glam::{Vec2, Vec3};

use super::*;
use crate::cache::surface::Surface;

const GRID: Grid = Grid { finest: 1.0 };
const FLOOR: Surface = Surface {
    island: 0,
    back: false,
};

fn charts() -> Charts {
    let positions = [Vec3::ZERO, Vec3::X * 100.0, Vec3::Y * 100.0];
    Charts::new(&positions, &[[0, 1, 2]], std::slice::from_ref(&(0..1)))
}

/// Asks for a texel of each of the blocks `blocks` of a row.
fn row(blocks: impl IntoIterator<Item = u32>) -> Requests {
    let mut requests = Requests::default();
    for block in blocks {
        let place = Vec2::new((8 * block + 2) as f32, 3.0);
        requests.ask(GRID.nearest(FLOOR, place, 0));
    }
    Requests::merged(vec![requests])
}

fn pool(blocks: usize, frames: u32) -> Blocks {
    Blocks::new(Limits { blocks, frames }, Layout { texel: 2, block: 1 })
}

/// Which blocks of a row are there.
fn there(pool: &Blocks) -> Vec<u32> {
    let mut columns: Vec<u32> = pool.slot_of.keys().map(|key| key.place()[0]).collect();
    columns.sort_unstable();
    columns
}

#[test]
fn blocks_are_kept_until_nobody_asks_for_long() {
    let charts = charts();
    let mut pool = pool(100, 2);
    let asked = pool.begin(&row([0, 1, 2]), &charts, &GRID);
    assert_eq!((asked.new, asked.evicted, asked.refused), (3, 0, 0));
    for _ in 0..2 {
        let asked = pool.begin(&row([1]), &charts, &GRID);
        assert_eq!((asked.new, asked.evicted), (0, 0));
    }
    let asked = pool.begin(&row([1, 5]), &charts, &GRID);
    assert_eq!((asked.new, asked.evicted), (1, 2));
    assert_eq!(there(&pool), [1, 5]);
    assert!(pool.active_bytes() < pool.allocated_bytes());
}

#[test]
fn a_full_pool_gives_up_the_oldest_and_refuses_the_rest() {
    let charts = charts();
    let mut pool = pool(3, 100);
    pool.begin(&row([0, 1]), &charts, &GRID);
    pool.begin(&row([1, 2]), &charts, &GRID);
    let asked = pool.begin(&row([2, 3, 4]), &charts, &GRID);
    assert_eq!((asked.new, asked.evicted, asked.refused), (2, 2, 0));
    assert_eq!(there(&pool), [2, 3, 4]);
    let asked = pool.begin(&row([5, 6, 7, 8]), &charts, &GRID);
    assert_eq!((asked.new, asked.refused), (3, 1));
    assert_eq!(there(&pool), [5, 6, 7]);
    let mut none = self::pool(0, 3);
    assert_eq!(none.begin(&row([0]), &charts, &GRID).refused, 1);
    assert!(none.is_empty());
}

#[test]
fn contents_stay_with_their_texels_and_new_blocks_are_empty() {
    let charts = charts();
    let mut pool = pool(3, 100);
    let texel = |block: u32| GRID.nearest(FLOOR, Vec2::new((8 * block + 2) as f32, 3.0), 0);
    pool.begin(&row([0, 1, 2]), &charts, &GRID);
    let found = pool.work(
        || (),
        |_, block| {
            assert_eq!(block.asked.count_ones(), 1);
            block.words.fill(block.key.place()[0] + 1);
            1
        },
    );
    assert_eq!(found.len(), 3);
    let read = |pool: &Blocks, block| pool.texel(texel(block)).map(|(_, words)| words[1]);
    assert_eq!(
        [0, 1, 2].map(|b| read(&pool, b)),
        [Some(1), Some(2), Some(3)]
    );
    pool.texel_mut(texel(1)).expect("there")[1] = 9;
    pool.begin(&row([1, 2, 4]), &charts, &GRID);
    assert_eq!(
        [0, 1, 2, 4].map(|b| read(&pool, b)),
        [None, Some(9), Some(3), Some(0)]
    );
    let (point, _) = pool.texel(texel(4)).expect("there");
    let place = charts.place(point.triangle, [point.u, point.v]).place;
    assert_eq!(place, GRID.centre(texel(4)));
}

#[test]
fn what_is_remembered_goes_on_the_same() {
    let charts = charts();
    let mut before = pool(4, 2);
    for blocks in [0..3, 1..4, 3..5] {
        before.begin(&row(blocks), &charts, &GRID);
        before.work(
            || (),
            |_, block| block.words.iter_mut().for_each(|w| *w += 1),
        );
    }
    let mut after = pool(4, 2);
    after.recall(before.memory(), &charts, &GRID).expect("fits");
    assert_eq!(after.memory(), before.memory());
    for blocks in [4..6, 5..8, 0..4] {
        let asked = before.begin(&row(blocks.clone()), &charts, &GRID);
        assert_eq!(after.begin(&row(blocks), &charts, &GRID), asked);
        assert_eq!(after.memory(), before.memory());
    }
    let mut small = pool(1, 2);
    assert!(small.recall(before.memory(), &charts, &GRID).is_err());
    let mut wide = Blocks::new(before.limits, Layout { texel: 5, block: 1 });
    assert!(wide.recall(before.memory(), &charts, &GRID).is_err());
}

#[test]
fn a_texel_begins_once_and_keeps_the_point_it_was_moved_to() {
    let charts = charts();
    let mut pool = pool(10, 2);
    pool.begin(&row([0, 1]), &charts, &GRID);
    let [moved, stays] = [2.0, 10.0].map(|x| GRID.nearest(FLOOR, Vec2::new(x, 3.0), 0));
    let point = SurfacePoint {
        triangle: 0,
        u: 0.25,
        v: 0.5,
    };
    let (before, _) = pool.texel(stays).expect("its block is there");
    assert!(pool.begins(moved) && pool.begins(stays));
    pool.begin_texels(&[(moved, Some(point)), (stays, None)], |&begun| begun);
    let check = |pool: &Blocks| {
        assert!(!pool.begins(moved) && !pool.begins(stays));
        assert_eq!(pool.texel(moved).map(|(point, _)| point), Some(point));
        assert_eq!(pool.texel(stays).map(|(point, _)| point), Some(before));
    };
    check(&pool);
    let mut again = self::pool(10, 2);
    again
        .recall(pool.memory(), &charts, &GRID)
        .expect("recalls");
    check(&again);
    // A block that comes back begins anew.
    for _ in 0..3 {
        pool.begin(&row([5]), &charts, &GRID);
    }
    assert!(!pool.begins(moved), "its block is gone");
    pool.begin(&row([0]), &charts, &GRID);
    assert!(pool.begins(moved));
    assert_ne!(pool.texel(moved).map(|(point, _)| point), Some(point));
}

#[test]
fn what_missed_a_change_is_forgotten_where_it_is_asked_for_at_rest() {
    let charts = charts();
    let texel = |block: u32| GRID.nearest(FLOOR, Vec2::new((8 * block + 2) as f32, 3.0), 0);
    for forgetting in [false, true] {
        let mut pool = pool(3, 100);
        pool.begin(&row([0, 1]), &charts, &GRID);
        for block in [0, 1] {
            pool.texel_mut(texel(block)).expect("there").fill(7);
        }
        // Nobody looks at the second one when something changes.
        pool.begin(&row([0]), &charts, &GRID);
        pool.miss();
        assert_eq!([0, 1].map(|b| pool.has_missed(texel(b))), [false, true]);
        pool.begin(&row([0, 1]), &charts, &GRID);
        pool.catch_up(forgetting);
        assert!(!pool.has_missed(texel(0)) && !pool.has_missed(texel(1)));
        let words = [0, 1].map(|b| pool.texel(texel(b)).expect("there").1[0]);
        assert_eq!(words, [7, if forgetting { 0 } else { 7 }]);
    }
}
