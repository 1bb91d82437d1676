//! How many lights, or samples, a budget of seconds pays for: processor seconds of all threads, so that the count does not
//! depend on how many threads there are and hardly on what else the machine does.
//!
//! Whole images are rendered, so that making lights, upsampling and all else that a contender is
//! charged with is in the time. Two counts give a line, cost = a + b · count, whose count for the budget is
//! rendered in turn, until an image takes the time. What the image shows depends on its count alone:
//! the same experiment with that many `lights` shows it again.

use crate::technique::{Rendered, Search};

/// The found parameter that tells the count.
pub const FOUND: &str = "lights_in_time";
/// Where the search starts.
const FIRST: u64 = 8;
/// A count is at most this many times the one before.
const STRIDE: f64 = 8.0;
const MOST: u64 = 1 << 20;
/// An image that takes the budget within this share of it is taken.
const NEAR: f64 = 0.03;
/// Images that are rendered and timed at most.
const TRIALS: usize = 8;
/// A budget that is missed by more than this share gets a note.
const MISSED: f64 = 0.1;

/// What images of a count took.
#[derive(Clone, Copy)]
struct Cost {
    count: u64,
    /// The least of its images.
    seconds: f64,
    /// Whether it was rendered more than once.
    again: bool,
}

/// The images of all viewers whose cost is nearest to `seconds` of processor time an image of those that were rendered, the first with
/// the count in `found`; what the others took is its search.
///
/// # Errors
/// Those of `render`.
pub fn render_within(
    seconds: f64,
    render: impl Fn(u64) -> Result<Vec<Rendered>, String>,
) -> Result<Vec<Rendered>, String> {
    let mut search = Search::default();
    let mut passed_over = |images: &[Rendered]| {
        for image in images {
            search.add(Search {
                seconds: image.stages.total().wall,
                rays: image.rays,
            });
            search.add(image.search);
        }
    };
    passed_over(&render(FIRST)?); // The first image finds cold caches: its time is not looked at.
    let mut costs: Vec<Cost> = Vec::new();
    let mut best: Option<(f64, Vec<Rendered>)> = None;
    let mut count = FIRST;
    for _ in 0..TRIALS {
        let mut images = render(count)?;
        let cost = cost_of(&images);
        let missed = (cost - seconds).abs() / seconds;
        match costs.iter_mut().find(|known| known.count == count) {
            // What disturbs a measurement only adds to it.
            Some(known) => {
                known.seconds = known.seconds.min(cost);
                known.again = true;
            }
            None => costs.push(Cost {
                count,
                seconds: cost,
                again: false,
            }),
        }
        if best.as_ref().is_none_or(|(least, _)| missed < *least) {
            if let Some(first) = images.first_mut() {
                first.found.push((FOUND, count as f64));
            }
            if let Some((_, before)) = best.replace((missed, images)) {
                passed_over(&before);
            }
        } else {
            passed_over(&images);
        }
        count = next(seconds, &costs);
        let seen_again = costs
            .iter()
            .any(|known| known.count == count && known.again);
        if missed <= NEAR || seen_again {
            break;
        }
    }
    let Some((missed, mut images)) = best.filter(|(_, images)| !images.is_empty()) else {
        return Err("no image was rendered".into());
    };
    let cost = cost_of(&images);
    let first = &mut images[0];
    first.search.add(search);
    if missed > MISSED {
        first.notes.push(format!(
            "no count of lights or samples came within {:.0} % of {seconds} processor seconds: this one takes {cost:.3} s",
            100.0 * MISSED
        ));
    }
    Ok(images)
}

/// Processor seconds an image, in the mean of all viewers; wall time where the system tells no other.
fn cost_of(images: &[Rendered]) -> f64 {
    let seconds = images.iter().map(|image| {
        let total = image.stages.total();
        if total.cpu > 0.0 {
            total.cpu
        } else {
            total.wall
        }
    });
    seconds.sum::<f64>() / images.len().max(1) as f64
}

/// The count that the line through the two costs on either side of the budget, or else the two
/// nearest ones, gives; proportional to the cost where there is no rising line.
fn next(seconds: f64, costs: &[Cost]) -> u64 {
    let mut near = costs.to_vec();
    let missed = |c: &Cost| (c.seconds - seconds).abs();
    near.sort_by(|a, b| missed(a).total_cmp(&missed(b)));
    let nearest = near[0];
    let beyond = |c: &&Cost| (c.seconds > seconds) != (nearest.seconds > seconds);
    let other = near.iter().find(beyond).or(near.get(1));
    let slope = other.map_or(f64::NAN, |o| {
        (o.seconds - nearest.seconds) / (o.count as f64 - nearest.count as f64)
    });
    let wanted = if slope > 0.0 && slope.is_finite() {
        nearest.count as f64 + (seconds - nearest.seconds) / slope
    } else {
        nearest.count as f64 * seconds / nearest.seconds.max(1e-9)
    };
    let largest = costs.iter().map(|c| c.count).max().unwrap_or(FIRST) as f64;
    let wanted = wanted.round().clamp(1.0, STRIDE * largest);
    (wanted as u64).min(MOST)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::technique::{Seconds, Stages};

    /// An image that takes `cost(count)` seconds.
    fn costing(cost: impl Fn(u64) -> f64) -> impl Fn(u64) -> Result<Vec<Rendered>, String> {
        move |count| {
            let mut stages = Stages::default();
            let cpu = cost(count);
            stages.add(
                "rendering",
                Seconds {
                    // However long it took beside other programs.
                    wall: 7.0,
                    cpu,
                    ..Seconds::default()
                },
            );
            Ok(vec![Rendered {
                stages,
                ..Rendered::default()
            }])
        }
    }

    fn found(images: &[Rendered]) -> f64 {
        let found = images[0].found.iter().find(|(key, _)| *key == FOUND);
        found.expect("recorded").1
    }

    #[test]
    fn a_line_is_found_in_few_images() {
        for (constant, slope, count) in [(0.5, 0.01, 50.0), (0.0, 1e-4, 10_000.0), (0.9, 0.1, 1.0)]
        {
            let images = Cell::new(0);
            let line = costing(|n| constant + slope * n as f64);
            let counted = |n| {
                images.set(images.get() + 1);
                line(n)
            };
            let rendered = render_within(1.0, counted).expect("renders");
            let missed = (rendered[0].stages.total().cpu - 1.0).abs();
            assert!(missed <= NEAR, "{count}: {missed}");
            assert!((found(&rendered) / count - 1.0).abs() <= 0.1);
            assert!(images.get() <= 7, "{}", images.get());
            assert!(rendered[0].notes.is_empty());
        }
    }

    #[test]
    fn a_budget_out_of_reach_gets_the_nearest_image_and_a_note() {
        let slow = render_within(1.0, costing(|n| 3.0 + n as f64)).expect("renders");
        assert_eq!((found(&slow), slow[0].notes.len()), (1.0, 1));
        let constant = render_within(1.0, costing(|_| 0.25)).expect("renders");
        assert_eq!(constant[0].notes.len(), 1);
        let bent = costing(|n| 0.1 + 0.01 * (n.min(60)) as f64);
        let bent = render_within(1.0, bent).expect("renders");
        assert!(
            (bent[0].stages.total().cpu - 0.7).abs() < 1e-9,
            "fewer lights than asked"
        );
    }

    #[test]
    fn a_cold_start_does_not_mislead() {
        let images = Cell::new(0);
        let disturbed = |n| {
            images.set(images.get() + 1);
            let disturbance = if images.get() == 1 { 5.0 } else { 0.0 };
            costing(move |n| 0.1 * n as f64 + disturbance)(n)
        };
        let rendered = render_within(1.0, disturbed).expect("renders");
        assert_eq!((found(&rendered), rendered[0].notes.len()), (10.0, 0));
    }

    #[test]
    fn errors_end_the_search() {
        let result = render_within(1.0, |_| Err("no map".into()));
        assert_eq!(result.err().as_deref(), Some("no map"));
    }
}
