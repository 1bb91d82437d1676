//! What a method has over what the first one has, where its curve over the swept budgets costs, or errs, as much.

use std::collections::BTreeSet;

use super::data::{Asked, Data, SceneOf};
use super::estimate::Estimate;
use crate::experiment::{Case, Swept};

/// The columns of a curve: what is held equal (`None`: the budget) and what is compared.
#[derive(Clone, Copy)]
pub struct Axes<'a> {
    pub held: Option<&'a str>,
    pub compared: &'a str,
}

/// A method against the first.
pub struct Ratio {
    /// Of what is compared, for each seed.
    pub logarithm: Estimate,
    /// The first method's budgets that the method's curves of all seeds reach, of all scenes together.
    pub budgets: usize,
    /// How many it has.
    pub of_budgets: usize,
}

/// Why there is no ratio.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoRatio {
    /// What is held equal is less at all budgets than at any of the first method.
    Below,
    /// It is more at all budgets.
    Above,
    /// A job is missing or failed, or the curves do not overlap.
    NoData,
}

/// What is held equal and what is compared, of a method at each swept budget, as logarithms.
type Curve = Vec<(f64, f64)>;

/// A method and the first one with one seed.
struct Pair {
    seed: u64,
    /// At each budget of the first one; `None` where the method's curve does not reach it.
    ratios: Vec<Option<f64>>,
    /// Where the method's curve lies wholly beside that of the first.
    beside: Option<NoRatio>,
}

/// The mean over the first method's budgets that the method's curves of all seeds reach, then over scenes. Between
/// budgets curves are interpolated linearly in logarithms, and nothing is extrapolated. Over several scenes there is
/// none where one of them has none, or lacks a seed.
pub fn mean_ratio(
    data: &Data,
    scenes: &[SceneOf],
    label: &str,
    axes: Axes,
) -> Result<Ratio, NoRatio> {
    if let [scene] = scenes {
        return ratio(data, scene, label, axes);
    }
    let ratios = scenes.iter().map(|scene| ratio(data, scene, label, axes));
    let ratios: Vec<Ratio> = ratios
        .collect::<Result<_, _>>()
        .map_err(|_| NoRatio::NoData)?;
    let logarithms: Vec<Estimate> = ratios.iter().map(|r| r.logarithm.clone()).collect();
    Ok(Ratio {
        logarithm: Estimate::mean_of(&logarithms).ok_or(NoRatio::NoData)?,
        budgets: ratios.iter().map(|r| r.budgets).sum(),
        of_budgets: ratios.iter().map(|r| r.of_budgets).sum(),
    })
}

fn ratio(data: &Data, scene: &SceneOf, label: &str, axes: Axes) -> Result<Ratio, NoRatio> {
    let first = data.labels().first().ok_or(NoRatio::NoData)?;
    let seeds = seeds(data, scene, [first, label]);
    let pair = |seed: &u64| {
        let base = curve(data, scene, first, *seed, axes)?;
        let own = curve(data, scene, label, *seed, axes)?;
        Some(Pair::new(*seed, &base, own))
    };
    let pairs: Vec<Pair> = seeds.iter().filter_map(pair).collect();
    let budgets = pairs.first().ok_or(NoRatio::NoData)?.ratios.len();
    let reached = |budget: &usize| pairs.iter().all(|pair| pair.ratios[*budget].is_some());
    let reached: Vec<usize> = (0..budgets).filter(reached).collect();
    if reached.is_empty() {
        let beside = pairs[0].beside.filter(|_| pairs.len() == seeds.len());
        let beside = beside.filter(|side| pairs.iter().all(|pair| pair.beside == Some(*side)));
        return Err(beside.unwrap_or(NoRatio::NoData));
    }
    let mean = |pair: &Pair| {
        let ratios = reached.iter().filter_map(|budget| pair.ratios[*budget]);
        (pair.seed, ratios.sum::<f64>() / reached.len() as f64)
    };
    let logarithm = Estimate::new(pairs.iter().map(mean).collect()).ok_or(NoRatio::NoData)?;
    Ok(Ratio {
        logarithm: logarithm.of_expected(seeds.len()),
        budgets: reached.len(),
        of_budgets: budgets,
    })
}

impl Pair {
    fn new(seed: u64, base: &Curve, mut own: Curve) -> Self {
        own.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ratio = |(at, value): &(f64, f64)| Some(interpolate(&own, *at)? - value);
        Self {
            seed,
            ratios: base.iter().map(ratio).collect(),
            beside: beside(&own, base),
        }
    }
}

/// On which side of another curve one lies wholly.
fn beside(own: &Curve, base: &Curve) -> Option<NoRatio> {
    let held = |curve: &Curve| {
        let held = curve.iter().map(|(held, _)| *held);
        held.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        })
    };
    let ((low, high), (base_low, base_high)) = (held(own), held(base));
    match (high < base_low, low > base_high) {
        (true, _) => Some(NoRatio::Below),
        (_, true) => Some(NoRatio::Above),
        _ => None,
    }
}

/// The seeds that are expected of two methods in a scene.
fn seeds(data: &Data, scene: &SceneOf, labels: [&str; 2]) -> BTreeSet<u64> {
    let points = expected(data, scene);
    let cases = points.flat_map(|(_, point)| labels.map(|label| case(data, scene, label, point)));
    cases
        .flat_map(|case| data.cases.seeds_of(&case).collect::<Vec<_>>())
        .collect()
}

fn case(data: &Data, scene: &SceneOf, label: &str, point: &Swept) -> Case {
    data.case(Asked {
        scene,
        label,
        point,
    })
}

/// The swept budgets of a scene with their places.
fn expected<'a>(
    data: &'a Data,
    scene: &'a SceneOf,
) -> impl Iterator<Item = (usize, &'a Swept)> + 'a {
    let points = data.points().iter().enumerate();
    points.filter(|(_, point)| data.cases.expects(&scene.place, point))
}

/// A method's curve with one seed, in the order of the budgets; `None` where a budget has no result.
fn curve(data: &Data, scene: &SceneOf, label: &str, seed: u64, axes: Axes) -> Option<Curve> {
    let place = |(budget, point): (usize, &Swept)| {
        let case = case(data, scene, label, point);
        let logarithm = |column: &str| {
            let value = data.cases.value(&case, seed, column)?;
            (value > 0.0).then(|| value.ln())
        };
        let held = match axes.held {
            Some(column) => logarithm(column)?,
            None => budget as f64,
        };
        Some((held, logarithm(axes.compared)?))
    };
    expected(data, scene).map(place).collect()
}

/// The value of a curve, `None` outside of it.
fn interpolate(curve: &[(f64, f64)], at: f64) -> Option<f64> {
    if let Some((_, value)) = curve.iter().find(|(held, _)| *held == at) {
        return Some(*value);
    }
    let after = curve.iter().position(|(held, _)| *held > at)?;
    let ((a, from), (b, to)) = (*curve.get(after.checked_sub(1)?)?, curve[after]);
    Some(from + (to - from) * (at - a) / (b - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_read_between_their_ends_only() {
        let curve = vec![(0.0, 4.0), (1.0, 2.0), (3.0, 1.0)];
        assert_eq!(interpolate(&curve, 1.0), Some(2.0));
        assert_eq!(interpolate(&curve, 2.0), Some(1.5));
        assert_eq!(interpolate(&curve, -0.1), None);
        assert_eq!(interpolate(&curve, 3.1), None);
        assert_eq!(interpolate(&[], 0.0), None);
    }

    #[test]
    fn curves_beside_one_another_are_told() {
        let curve = |held: [f64; 2]| held.map(|at| (at, 1.0)).to_vec();
        let base = curve([2.0, 1.0]);
        for (own, expected) in [
            ([0.1, 0.9], Some(NoRatio::Below)),
            ([3.0, 2.1], Some(NoRatio::Above)),
            ([0.5, 1.0], None),
            ([0.0, 9.0], None),
        ] {
            assert_eq!(beside(&curve(own), &base), expected);
        }
    }
}
