use super::*;
use crate::sample::{Frame, Rng};

fn at(degrees: f32) -> Vec3 {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    Vec3::new(sine, 0.0, cosine)
}

fn cone(degrees: f32, half_angle_deg: f32) -> Cone {
    Cone {
        axis: at(degrees),
        half_angle: half_angle_deg.to_radians(),
        light: Vec3::ONE,
    }
}

/// Where cones are (degrees from z, half angle) after a sample was added to some.
fn added(cones: &[Cone], degrees: f32) -> Vec<[i32; 2]> {
    let rules = Rules::default();
    let mut update = Update::of(Entry::of(cones, 10.0), &rules, 8);
    update.add(at(degrees), Vec3::ONE);
    let place = |cone: &Cone| {
        let angle = cone.axis.x.atan2(cone.axis.z);
        [angle, cone.half_angle].map(|a| a.to_degrees().round() as i32)
    };
    update.cones().iter().map(place).collect()
}

#[test]
fn a_sample_inside_a_cone_changes_none() {
    assert_eq!(added(&[cone(0.0, 10.0)], 9.0), [[0, 10]]);
    // Of two cones around it the one that it is deeper in may take it.
    let rules = Rules {
        inside: Inside::Deepest,
        ..Rules::default()
    };
    let both = Entry::of(&[cone(0.0, 30.0), cone(30.0, 10.0)], 0.0);
    let mut update = Update::of(both, &rules, 8);
    update.add(at(27.0), Vec3::ONE);
    assert_eq!(update.lit[..2], [false, true]);
}

#[test]
fn a_sample_outside_makes_a_cone_while_there_is_room() {
    assert_eq!(added(&[], 5.0), [[5, 1]]);
    let two = [cone(0.0, 10.0), cone(40.0, 5.0)];
    assert_eq!(added(&two, -30.0), [[0, 10], [40, 5], [-30, 1]]);
}

#[test]
fn a_sample_near_a_cone_widens_it_when_all_are_taken() {
    let three = [cone(-60.0, 5.0), cone(0.0, 5.0), cone(60.0, 5.0)];
    assert_eq!(added(&three, 15.0), [[-60, 5], [5, 10], [60, 5]]);
}

#[test]
fn otherwise_the_closest_cones_are_merged() {
    let three = [cone(-60.0, 5.0), cone(0.0, 5.0), cone(16.0, 5.0)];
    assert_eq!(added(&three, 60.0), [[-60, 5], [8, 13], [60, 1]]);
    let rules = Rules::default();
    let mut update = Update::of(Entry::of(&three, 10.0), &rules, 8);
    update.add(at(60.0), Vec3::ONE);
    assert_eq!(update.cones()[1].light, Vec3::splat(2.0));
}

/// The sun in the middle of a wide weak sky, and two lamps close to each other.
#[test]
fn strong_narrow_cones_are_not_merged_with_wide_weak_ones() {
    let lit = |cone: Cone, light: f32| Cone {
        light: Vec3::splat(light),
        ..cone
    };
    let entry = [
        lit(cone(0.0, 70.0), 1.0),
        lit(cone(30.0, 1.43), 20.0),
        lit(cone(-80.0, 1.43), 0.5),
    ];
    let widths = |comparison: Comparison| {
        let rules = Rules {
            comparison,
            ..Rules::default()
        };
        let mut update = Update::of(Entry::of(&entry, 10.0), &rules, 8);
        update.add(at(86.0), Vec3::splat(0.2));
        let degrees = |cone: &Cone| cone.half_angle.to_degrees().round() as i32;
        update.cones().iter().map(degrees).collect::<Vec<_>>()
    };
    assert_eq!(
        widths(Comparison::Gaps),
        [70, 1, 1],
        "the sun is in the sky"
    );
    assert_eq!(widths(Comparison::Light), [78, 1, 1], "the sky is widened");
}

#[test]
fn the_narrowest_cone_around_a_sample_may_take_it() {
    let rules = Rules {
        inside: Inside::Narrowest,
        ..Rules::default()
    };
    let both = Entry::of(&[cone(0.0, 80.0), cone(9.0, 10.0)], 0.0);
    let mut update = Update::of(both, &rules, 8);
    update.add(at(1.0), Vec3::ONE);
    assert_eq!(update.lit[..2], [false, true]);
}

#[test]
fn a_single_cone_takes_everything() {
    let rules = Rules {
        cones: 1,
        ..Rules::default()
    };
    let mut update = Update::of(Entry::default(), &rules, 4);
    for degrees in [0.0, 50.0, -20.0] {
        update.add(at(degrees), Vec3::splat(0.25));
    }
    assert_eq!(update.cones().len(), 1);
    let gaps = [0.0, 50.0, -20.0].map(|d| update.cones()[0].gap_to(at(d)));
    assert!(gaps.iter().all(|gap| *gap < 1e-4), "{gaps:?}");
    update.average();
    assert!((update.finish().light() - 0.75).length() < 1e-6);
}

/// Whatever becomes of the cones, all light together is the mean of all samples.
#[test]
fn light_is_the_mean_of_all_samples_however_cones_merge() {
    for cones in [1, 3, 8] {
        let rules = Rules {
            cones,
            turn_count: 256.0,
            negligible: 0.0,
            most_count: 255.0,
            ..Rules::default()
        };
        let mut rng = Rng::new(1, 0, cones as u64, 0);
        let mut entry = Entry::default();
        let mut sum = 0.0f64;
        let updates = 30;
        for _ in 0..updates {
            let mut update = Update::of(entry, &rules, 8);
            for _ in 0..8 {
                let light = rng.next_f32() * 2.0 - 1.0;
                let frame = Frame::from_normal(Vec3::Z);
                let half = cone(0.0, 90.0);
                let direction = half.direction(&frame, [rng.next_f32(), rng.next_f32()]);
                if light > 0.0 {
                    update.add(direction, Vec3::splat(light / 8.0));
                    sum += f64::from(light);
                }
            }
            update.average();
            entry = update.finish();
            assert!(entry.cones().len() <= cones);
            let sound = |c: &Cone| c.axis.is_normalized() && c.half_angle <= 1.571;
            assert!(entry.cones().iter().all(sound));
        }
        let mean = sum / f64::from(8 * updates);
        let found = f64::from(entry.light().x);
        assert!((found / mean - 1.0).abs() < 1e-4, "{found} {mean}");
    }
}

#[test]
fn a_turn_lowers_the_count_once() {
    let rules = Rules::default();
    let full = [cone(-60.0, 1.43), cone(0.0, 10.0), cone(60.0, 1.43)];
    let mut update = Update::of(Entry::of(&full, 100.0), &rules, 8);
    update.add(at(30.0), Vec3::ONE);
    // By 10°: 1.5 times.
    update.average();
    let count = update.entry.count;
    assert!((count - (100.0 / 1.5 + 8.0)).abs() < 1e-2, "{count}");
    assert_eq!(update.finish().count, count);
    // Very far: 3 times; and never below 1.
    let mut update = Update::of(Entry::of(&full, 5.0), &rules, 1);
    update.turn = 2.0;
    update.average();
    assert!((update.entry.count - (5.0 / 3.0 + 1.0)).abs() < 1e-4);
}

#[test]
fn light_that_is_gone_fades() {
    let rules = Rules::default();
    let mut entry = Entry::of(&[cone(0.0, 5.0)], 0.0);
    for _ in 0..200 {
        let mut update = Update::of(entry, &rules, 8);
        update.average();
        entry = update.finish();
    }
    assert_eq!(entry.cones().len(), 0, "{entry:?}");
    let stays = Rules {
        unlit: Unlit::Stays,
        ..rules
    };
    let mut update = Update::of(Entry::of(&[cone(0.0, 5.0)], 20.0), &stays, 8);
    update.average();
    assert_eq!(update.finish().light(), Vec3::ONE);
}
