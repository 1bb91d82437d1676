//! The bound of gains, and where the next record goes.

use super::*;
use crate::cache::Gradient;
use crate::sample::Rng;

#[test]
fn the_threshold_lets_at_least_as_many_through_and_few_more() {
    let mut rng = Rng::new(3, 0, 0, 0);
    let mut values: Vec<f32> = (0..5000)
        .map(|_| 10f32.powf(rng.next_f32() * 12.0 - 6.0))
        .collect();
    values.extend([0.0; 500]);
    let reaching = |least: f32| values.iter().filter(|v| **v >= least).count();
    for most in [1, 10, 1000, 4999, 5000] {
        let count = reaching(threshold(&values, most));
        assert!(
            (most..=most + most / 50 + 40).contains(&count),
            "{most}: {count}"
        );
    }
    assert_eq!(
        reaching(threshold(&values, 6000)),
        5000,
        "all that are positive"
    );
    assert_eq!(threshold(&[], 1), f32::MIN_POSITIVE);
}

/// Points of a plane, a pixel apart, seen from above.
fn plane(width: usize, height: usize) -> ShadingPoints {
    let count = width * height;
    let at = |i: usize| Vec3::new((i % width) as f32, 0.0, (i / width) as f32);
    ShadingPoints {
        position: (0..count).map(at).collect(),
        normal: vec![Vec3::Y; count],
        geometric_normal: vec![Vec3::Y; count],
        depth: vec![1.0; count],
        pixel: (0..count as u32).collect(),
        sight: Vec::new(),
        width,
        height,
        point_of_pixel: (0..count as u32).collect(),
        diagonal: 100.0,
        metres_per_unit: 1.0,
        unit_is_assumed: false,
    }
}

/// What is known when the probes, all white fields, have these variances.
fn known(points: &ShadingPoints, variance: impl Fn(usize) -> f32) -> Disagreement<'_> {
    let white = |i: &u32| {
        let (x, y) = (*i as usize % points.width, *i as usize / points.width);
        (x + y).is_multiple_of(2)
    };
    let probes: Vec<u32> = (0..points.len() as u32).filter(white).collect();
    let mut probe_of_pixel = vec![NO_POINT; points.len()];
    for (probe, &point) in probes.iter().enumerate() {
        probe_of_pixel[point as usize] = probe as u32;
    }
    let predictions = probes.iter().map(|&point| Prediction {
        variance: variance(point as usize),
        distance: 2.0,
    });
    Disagreement {
        points,
        predictions: predictions.collect(),
        probe_of_pixel,
        metric: Gradient::default().rule(1.0).metric,
        least_cosine: 0.5,
        used: 4,
        nearest: vec![[NONE; MOST_USED]; probes.len()],
        count: 0,
        stale: vec![false; probes.len()],
        probes,
        floods: Vec::new(),
    }
}

#[test]
fn the_window_bounds_the_gain_so_that_none_of_the_best_is_missed() {
    let points = plane(37, 23);
    let noise = |i: usize| Rng::new(9, 0, i as u64, 0).next_f32().powi(8);
    let disagreement = known(&points, noise);
    let bounds = disagreement.window_sums();
    for (probe, &point) in disagreement.probes.iter().enumerate() {
        let (gain, bound) = (disagreement.gain(probe), bounds[point as usize]);
        assert!(
            gain <= bound * (1.0 + 1e-5),
            "{point}: {gain} above {bound}"
        );
    }
    let free = vec![true; points.len()];
    let all = disagreement.by_gain(&free, points.len());
    let some = disagreement.by_gain(&free, 200);
    assert!(some.len() < all.len(), "{} of {}", some.len(), all.len());
    assert_eq!(some[..10], all[..10]);
}

#[test]
fn a_lone_disagreement_draws_the_next_record_to_itself() {
    let points = plane(31, 31);
    let place = 12 * 31 + 14;
    let disagreement = known(&points, |i| if i == place { 1.0 } else { 0.0 });
    let free = vec![true; points.len()];
    let order = disagreement.by_gain(&free, 1);
    assert_eq!(order[0], place as u32);
    let far = |i: &u32| points.position[*i as usize].distance(points.position[place]) > 3.0;
    assert!(!order.iter().any(far), "{order:?}");
    let taken = vec![false; points.len()];
    assert!(disagreement.by_gain(&taken, 1).is_empty());
}
