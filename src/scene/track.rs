//! Values keyed over time.

use std::ops::{Add, Mul};

use glam::{DQuat, DVec3};
use serde::Serialize;

/// How values go from one key to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Interpolation {
    /// At constant speed; rotations along the shorter great circle.
    Linear,
    /// Without corners at the keys, and without leaving the range of two neighbouring keys.
    Smooth,
    /// The value of the key before.
    Step,
}

/// A kind of value that has keys.
pub trait Keyed: Copy + Add<Output = Self> + Mul<f64, Output = Self> {
    /// On the way from here (`share` 0) to another value (1).
    fn towards(self, other: Self, share: f64) -> Self;

    /// A sum of weighted values as a value of its kind.
    fn regular(self) -> Self {
        self
    }
}

impl Keyed for f64 {
    fn towards(self, other: Self, share: f64) -> Self {
        self + (other - self) * share
    }
}

impl Keyed for DVec3 {
    fn towards(self, other: Self, share: f64) -> Self {
        self.lerp(other, share)
    }
}

impl Keyed for DQuat {
    fn towards(self, other: Self, share: f64) -> Self {
        self.slerp(other, share)
    }

    fn regular(self) -> Self {
        self.normalize()
    }
}

/// A value keyed over time. Before the first key and after the last one it is that of the key.
#[derive(Clone, Debug, Serialize)]
pub struct Track<T> {
    /// Seconds, ascending, at least one.
    times_s: Vec<f64>,
    /// Parallel to the times.
    values: Vec<T>,
    between: Between<T>,
}

/// What is between the keys.
#[derive(Clone, Debug, Serialize)]
enum Between<T> {
    Step,
    Straight,
    /// Change per second on arrival at each key and on departure from it.
    Cubic(Vec<[T; 2]>),
}

impl<T: Keyed> Track<T> {
    /// Values that jump at their keys. Times are in seconds and ascend; there is a value for each, and one
    /// at least.
    pub fn step(times_s: Vec<f64>, values: Vec<T>) -> Self {
        Self::new(times_s, values, Between::Step)
    }

    /// As [`Track::step`], going straight from key to key.
    pub fn linear(times_s: Vec<f64>, values: Vec<T>) -> Self {
        Self::new(times_s, values, Between::Straight)
    }

    /// As [`Track::step`], along cubic Hermite splines with the change per second on arrival at each key and on
    /// departure from it.
    pub fn cubic(times_s: Vec<f64>, values: Vec<T>, slopes: Vec<[T; 2]>) -> Self {
        Self::new(times_s, values, Between::Cubic(slopes))
    }

    fn new(times_s: Vec<f64>, values: Vec<T>, between: Between<T>) -> Self {
        debug_assert!(!values.is_empty() && times_s.len() == values.len());
        Self {
            times_s,
            values,
            between,
        }
    }

    /// Times of the keys, s.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Values of the keys.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// The value at a time.
    pub fn at(&self, time_s: f64) -> T {
        let next = self.times_s.partition_point(|&t| t <= time_s);
        if next == 0 || next == self.times_s.len() {
            return self.values[next.saturating_sub(1)];
        }
        let before = next - 1;
        let duration = self.times_s[next] - self.times_s[before];
        let share = (time_s - self.times_s[before]) / duration;
        let [from, to] = [self.values[before], self.values[next]];
        match &self.between {
            Between::Step => from,
            Between::Straight => from.towards(to, share),
            Between::Cubic(slopes) => {
                let slopes = [slopes[before][1] * duration, slopes[next][0] * duration];
                hermite([from, to], slopes, share).regular()
            }
        }
    }
}

impl Track<f64> {
    /// As [`Track::step`], with an interpolation.
    pub fn keyed(times_s: Vec<f64>, values: Vec<f64>, interpolation: Interpolation) -> Self {
        match interpolation {
            Interpolation::Linear => Self::linear(times_s, values),
            Interpolation::Step => Self::step(times_s, values),
            Interpolation::Smooth => {
                let slopes = smooth_slopes(&times_s, &values);
                Self::cubic(times_s, values, slopes.iter().map(|&s| [s; 2]).collect())
            }
        }
    }
}

impl Track<DVec3> {
    /// As [`Track::step`], with an interpolation; smooth values are so in each coordinate.
    pub fn keyed(times_s: Vec<f64>, values: Vec<DVec3>, interpolation: Interpolation) -> Self {
        match interpolation {
            Interpolation::Linear => Self::linear(times_s, values),
            Interpolation::Step => Self::step(times_s, values),
            Interpolation::Smooth => {
                let [x, y, z] = [0, 1, 2].map(|axis| {
                    let along: Vec<f64> = values.iter().map(|v| v[axis]).collect();
                    smooth_slopes(&times_s, &along)
                });
                let slopes = (0..values.len()).map(|i| [DVec3::new(x[i], y[i], z[i]); 2]);
                let slopes = slopes.collect();
                Self::cubic(times_s, values, slopes)
            }
        }
    }
}

/// The cubic with these ends and these slopes there (change over the whole), at a share of its way.
pub(super) fn hermite<T: Keyed>([from, to]: [T; 2], [leaving, arriving]: [T; 2], share: f64) -> T {
    let (x, x2) = (share, share * share);
    let x3 = x2 * x;
    from * (2.0 * x3 - 3.0 * x2 + 1.0)
        + leaving * (x3 - 2.0 * x2 + x)
        + to * (3.0 * x2 - 2.0 * x3)
        + arriving * (x3 - x2)
}

/// Slopes at keys so that cubics between them neither overshoot nor have corners: harmonic means of the
/// neighbouring secants, 0 where those differ in sign (Fritsch & Butland 1984); at the ends the secant, but with two
/// keys 0, for a gentle start and stop.
pub(super) fn smooth_slopes(times_s: &[f64], values: &[f64]) -> Vec<f64> {
    let secant = |i: usize| (values[i + 1] - values[i]) / (times_s[i + 1] - times_s[i]);
    let last = values.len() - 1;
    (0..=last)
        .map(|i| match i {
            _ if last < 2 => 0.0,
            0 => secant(0),
            _ if i == last => secant(last - 1),
            _ => {
                let [before, after] = [secant(i - 1), secant(i)];
                let product = before * after;
                if product <= 0.0 {
                    return 0.0;
                }
                let [h0, h1] = [times_s[i] - times_s[i - 1], times_s[i + 1] - times_s[i]];
                let weight = (1.0 + h1 / (h0 + h1)) / 3.0;
                product / (weight * after + (1.0 - weight) * before)
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_outside_the_keys_hold_the_ends() {
        for interpolation in [
            Interpolation::Linear,
            Interpolation::Smooth,
            Interpolation::Step,
        ] {
            let track =
                Track::<f64>::keyed(vec![1.0, 2.0, 4.0], vec![5.0, 7.0, 6.0], interpolation);
            assert_eq!(
                [-9.0, 1.0, 4.0, 1e9].map(|t| track.at(t)),
                [5.0, 5.0, 6.0, 6.0]
            );
            assert_eq!(track.at(2.0), 7.0);
        }
        let one = Track::<f64>::keyed(vec![3.0], vec![2.5], Interpolation::Smooth);
        assert_eq!([0.0, 3.0, 4.0].map(|t| one.at(t)), [2.5; 3]);
    }

    #[test]
    fn steps_and_straight_lines() {
        let step = Track::step(vec![0.0, 1.0], vec![2.0, 4.0]);
        assert_eq!([0.999, 1.0].map(|t| step.at(t)), [2.0, 4.0]);
        let line = Track::linear(
            vec![0.0, 2.0],
            vec![DVec3::ZERO, DVec3::new(4.0, -2.0, 1.0)],
        );
        assert_eq!(line.at(0.5), DVec3::new(1.0, -0.5, 0.25));
    }

    #[test]
    fn smooth_values_have_no_corner_and_do_not_overshoot() {
        let (times, values) = (vec![0.0, 1.0, 1.5, 4.0, 5.0], vec![0.0, 1.0, 4.0, 4.0, 3.0]);
        let track = Track::<f64>::keyed(times.clone(), values.clone(), Interpolation::Smooth);
        for i in 0..=5000 {
            let time = f64::from(i) * 1e-3;
            let next = times.partition_point(|&t| t <= time).clamp(1, 4);
            let (low, high) = (
                values[next - 1].min(values[next]),
                values[next - 1].max(values[next]),
            );
            let value = track.at(time);
            assert!(
                (low - 1e-12..=high + 1e-12).contains(&value),
                "{time}: {value}"
            );
        }
        for time in &times[1..4] {
            let step = 1e-6;
            let slopes = [
                track.at(*time) - track.at(time - step),
                track.at(time + step) - track.at(*time),
            ];
            assert!((slopes[0] - slopes[1]).abs() < 1e-4 * step, "{slopes:?}");
        }
        let gentle = Track::<f64>::keyed(vec![0.0, 1.0], vec![0.0, 1.0], Interpolation::Smooth);
        assert_eq!([0.25, 0.5].map(|t| gentle.at(t)), [0.15625, 0.5]);
    }

    /// The formulas of the glTF 2.0 specification, appendix C.
    #[test]
    fn rotations_take_the_shorter_way_and_cubics_are_normalised() {
        let quarter = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
        let track = Track::linear(vec![0.0, 1.0], vec![DQuat::IDENTITY, -quarter]);
        let expected = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_8 * 0.5);
        assert!(track.at(0.125).dot(expected).abs() > 1.0 - 1e-12);
        let flat = [[DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0); 2]; 2];
        let cubic = Track::cubic(
            vec![0.0, 2.0],
            vec![DQuat::IDENTITY, quarter],
            flat.to_vec(),
        );
        let raw = DQuat::IDENTITY * 0.84375 + quarter * 0.15625;
        assert!(cubic.at(0.5).dot(raw.normalize()) > 1.0 - 1e-12);
        assert!(cubic.at(0.5).is_normalized());
    }
}
