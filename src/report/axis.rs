//! An axis of a plot: linear, or logarithmic where the data spans a factor of ten.

/// A range of values and its ticks.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    low: f64,
    high: f64,
    logarithmic: bool,
    ticks: Vec<f64>,
}

impl Axis {
    /// An axis that shows all finite values with a margin. Logarithmic when all are positive and the
    /// largest is at least ten times the smallest; otherwise linear, and from zero if `from_zero`.
    pub fn over(values: impl Iterator<Item = f64>, from_zero: bool) -> Self {
        let (low, high) = values
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (v.min(l), v.max(h))
            });
        if low > high {
            return Self::linear(0.0, 1.0);
        }
        if low > 0.0 && high >= 10.0 * low {
            let margin = (high / low).powf(0.06);
            return Self::logarithmic(low / margin, high * margin);
        }
        let low = if from_zero && low > 0.0 { 0.0 } else { low };
        let span = if high > low {
            high - low
        } else {
            high.abs().max(1.0)
        };
        let below = if from_zero && low == 0.0 {
            0.0
        } else {
            0.06 * span
        };
        Self::linear(low - below, high + 0.06 * span)
    }

    /// A linear axis from end to end with a small margin, whose ticks are at least `step` apart.
    pub fn between([low, high]: [f64; 2], step: f64) -> Self {
        let margin = match high > low {
            true => 0.02 * (high - low),
            false => 0.5,
        };
        let mut axis = Self::linear(low - margin, high + margin);
        axis.ticks
            .retain(|t| step == 0.0 || (t / step).fract() == 0.0);
        axis
    }

    fn linear(low: f64, high: f64) -> Self {
        let rough = (high - low) / 6.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|m| m * power)
            .into_iter()
            .find(|s| *s >= rough);
        let step = step.unwrap_or(10.0 * power);
        let first = (low / step).ceil();
        let ticks = (0..12)
            .map(|i| (first + f64::from(i)) * step)
            .take_while(|t| *t <= high);
        Self {
            low,
            high,
            logarithmic: false,
            ticks: ticks.collect(),
        }
    }

    fn logarithmic(low: f64, high: f64) -> Self {
        let decades = (high / low).log10();
        let factors: &[f64] = match decades {
            d if d < 2.2 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        let stride = (decades / 6.0).ceil().max(1.0) as usize;
        let powers = (low.log10().floor() as i32..=high.log10().ceil() as i32).step_by(stride);
        let all = powers.flat_map(|p| factors.iter().map(move |f| f * 10f64.powi(p)));
        Self {
            low,
            high,
            logarithmic: true,
            ticks: all.filter(|t| (low..=high).contains(t)).collect(),
        }
    }

    /// Ranks from the last to 1, the best, in the direction of the axis.
    pub fn ranks(count: usize) -> Self {
        Self {
            low: count as f64 + 0.5,
            high: 0.5,
            logarithmic: false,
            ticks: (1..=count).rev().map(|rank| rank as f64).collect(),
        }
    }

    /// Places 0, 1, … of things that have names.
    pub fn places(count: usize) -> Self {
        Self {
            low: -0.5,
            high: count as f64 - 0.5,
            logarithmic: false,
            ticks: (0..count).map(|place| place as f64).collect(),
        }
    }

    /// How far along the axis a value stands, from 0 to 1; values far outside are moved nearer.
    pub fn share(&self, value: f64) -> f32 {
        let scaled = |v: f64| match self.logarithmic {
            true => v.max(f64::MIN_POSITIVE).ln(),
            false => v,
        };
        let (low, high) = (scaled(self.low), scaled(self.high));
        ((scaled(value) - low) / (high - low)).clamp(-0.5, 1.5) as f32
    }

    /// Where the grid is.
    pub fn ticks(&self) -> &[f64] {
        &self.ticks
    }

    /// A tick as it is written.
    pub fn label(&self, tick: f64) -> String {
        short(tick)
    }

    /// As many ticks, evenly chosen and zero among them, as can be labelled: all neighbours must fit beside one another.
    pub fn labelled(&self, fit: impl Fn(f64, f64) -> bool) -> Vec<f64> {
        let mut choices = vec![self.ticks.clone()];
        if self.logarithmic {
            let is_power = |t: &f64| (t.log10() - t.log10().round()).abs() < 1e-9;
            let powers: Vec<f64> = self.ticks.iter().copied().filter(is_power).collect();
            choices.extend((powers.len() > 1).then_some(powers));
        }
        let zero = self.ticks.iter().position(|t| *t == 0.0).unwrap_or(0);
        choices.extend((2..=self.ticks.len()).map(|step| {
            let ticks = self.ticks.iter().enumerate();
            let every = ticks.filter(|(i, _)| i.abs_diff(zero).is_multiple_of(step));
            every.map(|(_, tick)| *tick).collect()
        }));
        let fits = |ticks: &Vec<f64>| ticks.windows(2).all(|pair| fit(pair[0], pair[1]));
        choices.into_iter().find(fits).unwrap_or_default()
    }

    /// The lowest value that is shown.
    pub fn low(&self) -> f64 {
        self.low
    }

    /// The highest value that is shown.
    pub fn high(&self) -> f64 {
        self.high
    }
}

/// A tick in few characters: `0.05`, `20k`, `1.5M`, `1e-7`.
fn short(value: f64) -> String {
    let plain = |v: f64| {
        let text = format!("{v:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    match value.abs() {
        0.0 => "0".into(),
        v if v < 1e-3 => format!("{value:.0e}"),
        v if v < 1e4 => plain(value),
        v if v < 1e6 => format!("{}k", plain(value / 1e3)),
        v if v < 1e9 => format!("{}M", plain(value / 1e6)),
        v if v < 1e12 => format!("{}G", plain(value / 1e9)),
        _ => format!("{value:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_spans_are_logarithmic() {
        let axis = Axis::over([10_000.0, 200_000.0].into_iter(), true);
        assert!(axis.logarithmic);
        assert_eq!(
            axis.ticks,
            [10_000.0, 20_000.0, 50_000.0, 100_000.0, 200_000.0]
        );
        assert!(!Axis::over([0.0, 200.0].into_iter(), true).logarithmic);
        assert_eq!((axis.share(axis.low), axis.share(axis.high)), (0.0, 1.0));
        assert!(Axis::over([1e-9, 1e9].into_iter(), true).ticks.len() < 12);
    }

    #[test]
    fn degenerate_data_still_has_an_axis() {
        for values in [
            vec![],
            vec![0.0],
            vec![5.0; 3],
            vec![f64::NAN],
            vec![-1.0, 1.0],
            vec![1e-300],
        ] {
            let axis = Axis::over(values.iter().copied(), true);
            assert!(
                axis.high > axis.low && axis.ticks.len() > 1,
                "{values:?} {axis:?}"
            );
        }
    }

    #[test]
    fn ticks_of_frames_are_whole() {
        assert_eq!(Axis::between([0.0, 3.0], 1.0).ticks, [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(Axis::between([7.0, 7.0], 1.0).ticks, [7.0]);
        assert_eq!(Axis::between([1.0, 300.0], 1.0).ticks.len(), 4);
        assert!(Axis::between([0.0, 1.0], 0.0).ticks.len() > 4);
    }

    #[test]
    fn fewer_ticks_are_labelled_where_there_is_no_room() {
        let axis = Axis::over([0.0, 50.0].into_iter(), true);
        assert_eq!(axis.labelled(|_, _| true), axis.ticks);
        assert_eq!(axis.labelled(|a, b| b - a > 15.0), [0.0, 20.0, 40.0]);
        let axis = Axis::over([10_000.0, 200_000.0].into_iter(), true);
        assert_eq!(axis.labelled(|a, b| b >= 9.0 * a), [10_000.0, 100_000.0]);
        assert_eq!(axis.labelled(|_, _| false).len(), 1);
        assert_eq!(Axis::ranks(3).share(3.5), 0.0);
        assert_eq!(Axis::places(2).share(1.5), 1.0);
    }

    #[test]
    fn ticks_are_short() {
        let texts = [0.0, 0.05, 2.5, 20_000.0, 1.5e6, 2e-7].map(short);
        assert_eq!(texts, ["0", "0.05", "2.5", "20k", "1.5M", "2e-7"]);
    }
}
