//! Means, spreads and intervals over repeats of a job.

use std::sync::OnceLock;

/// Coverage of the intervals.
const CONFIDENCE: f64 = 0.95;
/// Beyond this many degrees of freedom Student's t equals the normal distribution to 4 digits.
const LARGEST_DEGREES: usize = 20_000;

/// What repeats of one measurement say.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Summary {
    /// Finite values that went in; at least 1.
    pub count: usize,
    /// Their arithmetic mean.
    pub mean: f64,
    /// Sample standard deviation; `None` for a single value.
    pub deviation: Option<f64>,
    /// Half the width of the 95 % confidence interval of the mean (Student's t); `None` for a single
    /// value.
    pub half_width: Option<f64>,
}

impl Summary {
    /// Summarises finite values; `None` when there are none.
    ///
    /// Non-finite values are left out: a job with such a result has failed and is counted elsewhere.
    pub fn of(values: &[f64]) -> Option<Self> {
        let finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        let count = finite.len();
        if count == 0 {
            return None;
        }
        let mean = finite.iter().sum::<f64>() / count as f64;
        let deviation = (count > 1).then(|| {
            let squares: f64 = finite.iter().map(|value| (value - mean).powi(2)).sum();
            (squares / (count - 1) as f64).sqrt()
        });
        let half_width =
            deviation.map(|d| student_t_quantile(count - 1) * d / (count as f64).sqrt());
        Some(Self {
            count,
            mean,
            deviation,
            half_width,
        })
    }

    /// The bounds of the 95 % confidence interval of the mean; `None` for a single value.
    pub fn interval(&self) -> Option<[f64; 2]> {
        self.half_width
            .map(|half| [self.mean - half, self.mean + half])
    }
}

/// Summarises `second[i] - first[i]` over repeats that share a seed; `None` when the lists differ in
/// length or no pair is finite.
///
/// Sharing seeds cancels the noise that both contenders have in common.
pub fn paired_difference(first: &[f64], second: &[f64]) -> Option<Summary> {
    if first.len() != second.len() {
        return None;
    }
    let differences: Vec<f64> = first.iter().zip(second).map(|(a, b)| b - a).collect();
    Summary::of(&differences)
}

/// The two-sided 95 % quantile of Student's t: 12.706 for one degree of freedom, 1.960 for many;
/// infinite for none.
pub fn student_t_quantile(degrees_of_freedom: usize) -> f64 {
    if degrees_of_freedom == 0 {
        return f64::INFINITY;
    }
    let degrees = degrees_of_freedom.min(LARGEST_DEGREES);
    match KNOWN.get(degrees) {
        Some(known) => *known.get_or_init(|| searched_quantile(degrees)),
        None => searched_quantile(degrees),
    }
}

/// Quantiles for few degrees of freedom, which tables of many cells ask for again and again.
static KNOWN: [OnceLock<f64>; 64] = [const { OnceLock::new() }; 64];

fn searched_quantile(degrees: usize) -> f64 {
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if central_probability(middle, degrees) < CONFIDENCE {
            low = middle;
        } else {
            high = middle;
        }
    }
    (0.5 * (low + high)).tan() * (degrees as f64).sqrt()
}

/// The probability that |t| stays below `tan(angle) sqrt(degrees)`, by the finite series for a whole
/// number of degrees of freedom (Abramowitz & Stegun 26.7.3 and 26.7.4).
fn central_probability(angle_rad: f64, degrees: usize) -> f64 {
    let (sin, cos) = angle_rad.sin_cos();
    let odd = degrees % 2 == 1;
    let mut power = if odd { cos } else { 1.0 };
    let mut sum = 0.0;
    for k in (degrees % 2..degrees).step_by(2) {
        // Terms are c_k cos^k with c_(k+2) = c_k (k+1)/(k+2): 1, 1/2, 3/8, … or 1, 2/3, 8/15, …
        sum += power;
        power *= cos * cos * (k + 1) as f64 / (k + 2) as f64;
        if power < 1e-18 * sum {
            break;
        }
    }
    if odd {
        let tail = if degrees > 1 { sin * sum } else { 0.0 };
        (angle_rad + tail) * std::f64::consts::FRAC_2_PI
    } else {
        sin * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use statrs::distribution::{ContinuousCDF, StudentsT};

    #[test]
    fn quantiles_agree_with_an_independent_implementation() {
        for degrees in [1, 2, 3, 4, 5, 9, 10, 31, 100, 1001] {
            let t = StudentsT::new(0.0, 1.0, degrees as f64).unwrap();
            let expected = t.inverse_cdf(0.975);
            assert_relative_eq!(student_t_quantile(degrees), expected, max_relative = 1e-6);
        }
        assert_relative_eq!(student_t_quantile(1), 12.7062, max_relative = 1e-5);
        assert_relative_eq!(student_t_quantile(10_000_000), 1.95996, max_relative = 1e-4);
    }

    #[test]
    fn summary_of_known_values() {
        let summary = Summary::of(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]).unwrap();
        assert_eq!((summary.count, summary.mean), (8, 5.0));
        let deviation = (32.0_f64 / 7.0).sqrt();
        assert_relative_eq!(summary.deviation.unwrap(), deviation);
        let half = 2.364_624 * deviation / 8.0_f64.sqrt();
        assert_relative_eq!(summary.half_width.unwrap(), half, max_relative = 1e-6);
        assert_relative_eq!(
            summary.interval().unwrap()[0],
            5.0 - half,
            max_relative = 1e-6
        );
    }

    #[test]
    fn one_value_has_no_interval_and_none_no_summary() {
        let single = Summary::of(&[3.0, f64::NAN]).unwrap();
        assert_eq!((single.count, single.mean), (1, 3.0));
        assert_eq!((single.deviation, single.interval()), (None, None));
        assert_eq!(Summary::of(&[]), None);
        assert_eq!(Summary::of(&[f64::INFINITY]), None);
    }

    #[test]
    fn pairing_cancels_common_noise() {
        let first = [1.0, 9.0, 5.0, 3.0];
        let second = [1.5, 9.5, 5.5, 3.5];
        let difference = paired_difference(&first, &second).unwrap();
        assert_eq!((difference.mean, difference.half_width), (0.5, Some(0.0)));
        assert_eq!(paired_difference(&first, &second[..3]), None);
    }
}
