//! Samples in, looks out.

use glam::Vec3;

use crate::cache::hash::{HashCells, Look, MapKind, Options, Precision, Sample, Update};
use crate::sample::Rng;

pub(in crate::cache::hash) const HALF: Options = Options {
    levels: 5,
    map: MapKind::Cuckoo,
    precision: Precision::Half,
};

pub(in crate::cache::hash) const SINGLE: Options = Options {
    precision: Precision::Single,
    ..HALF
};

/// A floor at z = 0 and a wall at x = 0 that stands on it, both four wide.
pub(in crate::cache::hash) fn corner() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let at = |x, y, z| Vec3::new(x, y, z);
    let positions = vec![
        at(0.0, 0.0, 0.0),
        at(4.0, 0.0, 0.0),
        at(4.0, 4.0, 0.0),
        at(0.0, 4.0, 0.0),
        at(0.0, 0.0, 4.0),
        at(0.0, 4.0, 4.0),
    ];
    let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 5], [0, 5, 4]];
    (positions, triangles)
}

pub(in crate::cache::hash) fn cells(options: Options) -> HashCells {
    let (positions, triangles) = corner();
    HashCells::new(&positions, &triangles, options).expect("few cells")
}

fn sample(position: Vec3, normal: Vec3, value: f32) -> Sample {
    let value = Vec3::splat(value);
    Sample {
        position,
        normal,
        value,
    }
}

/// Samples all over both walls, on both sides.
pub(in crate::cache::hash) fn random_samples(seed: u64, count: usize) -> Vec<Sample> {
    let mut rng = Rng::new(seed, 0, 0, 0);
    (0..count)
        .map(|_| {
            let [a, b, side] = [0; 3].map(|_: u32| rng.next_f32());
            let sign = if side < 0.3 { -1.0 } else { 1.0 };
            let value = rng.next_f32() * 4.0;
            if rng.below(2) == 0 {
                sample(Vec3::new(4.0 * a, 4.0 * b, 0.0), sign * Vec3::Z, value)
            } else {
                sample(Vec3::new(0.0, 4.0 * a, 4.0 * b), sign * Vec3::X, value)
            }
        })
        .collect()
}

/// The samples on both sides of a level.
fn samples_of(cells: &HashCells, level: u32) -> u64 {
    let count = cells.levels().nth(level as usize).expect("a level").cells;
    (0..count as u32)
        .flat_map(|index| cells.cell(level, index).sides)
        .map(|side| u64::from(side.samples))
        .sum()
}

fn found(look: Look) -> (f32, u32) {
    match look {
        Look::Found { value, samples } => (value.x, samples),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_look_is_absent_then_empty_then_found() {
    for options in [HALF, SINGLE] {
        let mut cells = cells(options);
        let on = Vec3::new(2.0, 2.0, 0.0);
        let off = Vec3::new(2.0, 2.0, 2.0);
        for level in 0..=5 {
            assert_eq!(cells.look(level, on, Vec3::Z), Look::Empty);
        }
        assert_eq!(cells.look(5, off, Vec3::Z), Look::Absent);
        assert_eq!(cells.look(5, Vec3::splat(99.0), Vec3::Z), Look::Absent);
        assert_eq!(cells.look(5, Vec3::NAN, Vec3::Z), Look::Absent);
        assert_eq!(cells.look(6, on, Vec3::Z), Look::Absent);
        let update = cells.update(vec![
            sample(on, Vec3::Z, 1.0),
            sample(on, Vec3::Z, 0.0),
            sample(off, Vec3::Z, 7.0),
            sample(Vec3::NAN, Vec3::Z, 7.0),
            sample(on, Vec3::NAN, 7.0),
            sample(on, Vec3::Z, f32::NAN),
            sample(on, Vec3::Z, f32::INFINITY),
        ]);
        let expected = Update {
            stored: 2,
            dropped: 1,
            non_finite: 4,
            cells: 6,
        };
        assert_eq!(update, expected);
        for level in 0..=5 {
            assert_eq!(found(cells.look(level, on, Vec3::Z)), (0.5, 2));
            assert_eq!(cells.look(level, on, -Vec3::Z), Look::Empty);
        }
        cells.update(vec![sample(on, Vec3::Z, 3.5)]);
        assert_eq!(found(cells.look(3, on, Vec3::Z)), (1.5, 3));
    }
}

#[test]
fn black_samples_are_samples() {
    let mut cells = cells(HALF);
    let on = Vec3::new(1.0, 1.0, 0.0);
    cells.update(vec![sample(on, Vec3::Z, 0.0); 3]);
    assert_eq!(found(cells.look(5, on, Vec3::Z)), (0.0, 3));
}

#[test]
fn a_thin_sheet_keeps_the_light_of_either_side() {
    let mut cells = cells(HALF);
    let on = Vec3::new(3.0, 1.0, 0.0);
    cells.update(vec![sample(on, -Vec3::Z, 1.0), sample(on, Vec3::Z, 8.0)]);
    cells.update(vec![sample(on, Vec3::Z, 4.0)]);
    for level in 0..=5 {
        assert_eq!(found(cells.look(level, on, Vec3::Z)), (6.0, 2));
        assert_eq!(found(cells.look(level, on, -Vec3::Z)), (1.0, 1));
    }
}

#[test]
fn walls_in_one_cell_share_the_front_of_the_first_normal() {
    let mut cells = cells(SINGLE);
    let [floor, wall] = [Vec3::new(0.01, 2.0, 0.0), Vec3::new(0.0, 2.0, 0.01)];
    assert_eq!(cells.grid().key(floor), cells.grid().key(wall));
    // Perpendicular: a product of 0, which is the front.
    cells.update(vec![
        sample(floor, Vec3::Z, 2.0),
        sample(wall, Vec3::X, 4.0),
    ]);
    assert_eq!(found(cells.look(5, floor, Vec3::Z)), (3.0, 2));
    let leaning = Vec3::new(1.0, 0.0, -0.1).normalize();
    cells.update(vec![sample(wall, leaning, 9.0)]);
    assert_eq!(found(cells.look(5, floor, -Vec3::Z)), (9.0, 1));
    assert_eq!(found(cells.look(5, floor, Vec3::Z)), (3.0, 2));
}

#[test]
fn every_level_has_all_samples_and_their_mean() {
    for map in [
        MapKind::Blocks,
        MapKind::Cuckoo,
        MapKind::CuckooThree,
        MapKind::OpenAddressing,
    ] {
        let mut cells = cells(Options { map, ..SINGLE });
        let samples = random_samples(2, 20_000);
        let update = cells.update(samples.clone());
        assert_eq!(update.stored, 20_000);
        for level in 0..=5 {
            assert_eq!(samples_of(&cells, level), update.stored, "level {level}");
        }
        let mean = samples.iter().map(|s| f64::from(s.value.x)).sum::<f64>() / 20_000.0;
        let root = cells.cell(0, 0).sides;
        let total: f64 = root
            .iter()
            .map(|s| f64::from(s.mean.x) * f64::from(s.samples))
            .sum();
        assert!((total / 20_000.0 - mean).abs() < 1e-5);
    }
}

#[test]
fn the_mean_of_a_cell_is_that_of_its_samples() {
    let mut cells = cells(SINGLE);
    let frames: Vec<Vec<Sample>> = (0..5).map(|seed| random_samples(seed, 5_000)).collect();
    for frame in &frames {
        cells.update(frame.clone());
    }
    // All floor samples, apart from the wall: away from cells that both touch.
    let floor = |s: &&Sample| s.position.x > 0.5 && s.normal.z != 0.0;
    for probe in frames[0].iter().filter(floor).take(200) {
        let level = 4;
        let key = cells.grid().key_at(level, probe.position);
        let same =
            |s: &&Sample| cells.grid().key_at(level, s.position) == key && s.normal == probe.normal;
        let values: Vec<f64> = frames
            .iter()
            .flatten()
            .filter(same)
            .map(|s| f64::from(s.value.x))
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let (value, samples) = found(cells.look(level, probe.position, probe.normal));
        assert_eq!(samples as usize, values.len());
        assert!((f64::from(value) - mean).abs() < 1e-5);
    }
}

#[test]
fn the_result_is_the_same_for_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        pool.install(|| {
            let mut cells = cells(HALF);
            let updates = [0, 1, 2].map(|seed| cells.update(random_samples(seed, 30_000)));
            let words: Vec<Vec<u32>> = cells.levels.iter().map(|l| l.words.clone()).collect();
            (updates, words)
        })
    };
    let one = run(1);
    for threads in [2, 3, 8] {
        assert!(run(threads) == one, "{threads} threads");
    }
}

#[test]
fn half_means_freeze_and_single_ones_do_not() {
    let drift = |options: Options| {
        let mut cells = cells(options);
        let on = Vec3::new(2.0, 2.0, 0.0);
        let mut rng = Rng::new(1, 0, 0, 0);
        // A dim beginning, then light that is 25 % brighter, a sample a frame.
        for frame in 0..100_000 {
            let bright = if frame < 10_000 { 0.8 } else { 1.0 };
            cells.update(vec![sample(on, Vec3::Z, 2.0 * bright * rng.next_f32())]);
        }
        found(cells.look(5, on, Vec3::Z))
    };
    let truth = 0.8 * 0.1 + 1.0 * 0.9;
    let (single, samples) = drift(SINGLE);
    assert_eq!(samples, 100_000);
    assert!((single - truth).abs() < 0.01, "{single}");
    let (half, samples) = drift(HALF);
    println!("half {half}, single {single}, true {truth}");
    assert_eq!(samples, 65_535);
    // Once a sample's share is under half a unit in the last place, 1/2048 of the mean, it moves nothing.
    assert!((half - truth).abs() > 0.03, "{half} did not freeze");
    assert!((half - truth).abs() < 0.25, "{half}");
}

#[test]
fn half_means_of_many_samples_a_frame_are_good_to_their_last_places() {
    let run = |options: Options| {
        let mut cells = cells(options);
        for seed in 0..10 {
            cells.update(random_samples(seed, 10_000));
        }
        cells
    };
    let [half, single] = [run(HALF), run(SINGLE)];
    for probe in random_samples(99, 500) {
        let [(a, n), (b, m)] =
            [&half, &single].map(|c| found(c.look(2, probe.position, probe.normal)));
        assert_eq!(n, m);
        assert!((a - b).abs() < 10.0 * b / 2048.0, "{a} {b}");
    }
}

#[test]
fn what_is_wiped_is_empty_and_forgotten() {
    let mut cells = cells(HALF);
    let [on, other] = [Vec3::new(2.0, 2.0, 0.0), Vec3::new(3.0, 3.0, 0.0)];
    cells.update(vec![sample(on, Vec3::Z, 5.0), sample(other, Vec3::Z, 5.0)]);
    cells.wipe();
    for level in 0..=5 {
        assert_eq!(cells.look(level, on, Vec3::Z), Look::Empty);
        assert_eq!(samples_of(&cells, level), 0);
    }
    cells.update(vec![sample(on, -Vec3::Z, 1.0)]);
    for level in 0..=5 {
        assert_eq!(found(cells.look(level, on, -Vec3::Z)), (1.0, 1));
        assert_eq!(cells.look(level, on, Vec3::Z), Look::Empty);
    }
    assert_eq!(cells.look(5, other, Vec3::Z), Look::Empty);
    // Stamps that come round again do not bring anything back.
    cells.stamp = u32::MAX;
    cells.update(vec![sample(on, Vec3::Z, 1.0)]);
    cells.wipe();
    cells.stamp = 0;
    assert_eq!(cells.look(5, on, Vec3::Z), Look::Empty);
}

#[test]
fn empty_scenes_and_single_triangles() {
    let mut empty = HashCells::new(&[], &[], HALF).expect("no cells");
    let update = empty.update(random_samples(1, 10));
    assert_eq!((update.stored, update.dropped), (0, 10));
    assert_eq!(empty.look(0, Vec3::splat(0.5), Vec3::Z), Look::Absent);
    assert_eq!(empty.update(Vec::new()), Update::default());
    assert!(empty.levels().all(|level| level.cells == 0));
    let memory = empty.memory();
    empty.recall(&memory).expect("nothing");

    let (positions, triangles) = corner();
    let mut one = HashCells::new(&positions, &triangles[..1], HALF).expect("few cells");
    let on = Vec3::new(3.0, 1.0, 0.0);
    one.update(vec![sample(on, Vec3::Z, 2.0)]);
    assert_eq!(found(one.look(5, on, Vec3::Z)), (2.0, 1));
    let mut root =
        HashCells::new(&positions, &triangles, Options { levels: 0, ..HALF }).expect("one cell");
    root.update(random_samples(1, 10));
    assert_eq!(samples_of(&root, 0), 10);
}

#[test]
fn sizes_are_those_of_the_papers_table() {
    let cells = cells(HALF);
    let sizes: Vec<_> = cells.levels().collect();
    assert_eq!(sizes.len(), 6);
    assert_eq!((sizes[0].cells, sizes[0].bytes_data), (1, 24));
    assert_eq!(sizes[0].density, 1.0);
    assert!((sizes[0].bytes_map_paper - 4.4).abs() < 1e-9);
    // Two walls touch 6 of 8 cells.
    assert_eq!((sizes[1].cells, sizes[1].density), (6, 0.75));
    assert_eq!(sizes[5].cells, 2 * 32 * 32 - 32);
    let bytes: usize = sizes.iter().map(|l| l.bytes_data + l.bytes_map).sum();
    assert_eq!(cells.bytes(), bytes);
    assert!(sizes.iter().all(|l| l.load > 0.0 && l.load <= 1.0 / 1.1));
}

#[test]
fn too_many_cells_are_refused_at_once() {
    let (positions, triangles) = corner();
    let error = |levels| {
        HashCells::new(&positions, &triangles, Options { levels, ..HALF })
            .err()
            .expect("refused")
    };
    assert!(error(17).contains("take fewer levels"));
    assert!(error(20).contains("take fewer levels"));
    assert!(error(21).contains("20"));
}

#[test]
fn ten_million_cells_are_told_apart() {
    let (positions, triangles) = corner();
    let options = Options {
        levels: 11,
        map: MapKind::Blocks,
        ..HALF
    };
    let mut cells = HashCells::new(&positions, &triangles, options).expect("fewer than indices");
    assert!(cells.levels().map(|level| level.cells).sum::<usize>() > 10_000_000);
    // Points of as many different cells, each with a value of its own.
    let step = 4.0 / 2048.0;
    let place = |i: u32| Vec3::new((7 * i % 2047) as f32 + 0.5, i as f32 + 0.5, 0.0) * step;
    let samples = (1..2000)
        .map(|i| sample(place(i), Vec3::Z, i as f32))
        .collect();
    assert_eq!(cells.update(samples).stored, 1999);
    for i in 1..2000 {
        assert_eq!(
            found(cells.look(11, place(i), Vec3::Z)),
            (i as f32, 1),
            "{i}"
        );
    }
    assert_eq!(samples_of(&cells, 0), 1999);
    assert_eq!(
        cells.look(11, place(1) + step * Vec3::X, Vec3::Z),
        Look::Empty
    );
}
