//! How much of a technique's unit a budget pays for that is spent rather than counted out: processor seconds an image, or
//! rays a pixel and image.
//!
//! The whole job is rendered, all its frames and without measuring, so that making lights, filling caches, upsampling and all
//! else that a contender is charged with is in what it spends. Two counts give a line, spent = a + b · count, whose count for
//! the budget is rendered in turn. Seconds, which differ from time to time, are met as nearly as may be; rays are never
//! exceeded, unless by the least count. What the images show depends on the count alone: the same experiment with that many
//! `lights` or `samples` shows them again.

use super::budget::Budget;
use crate::technique::{Rendered, Search, Spending};

/// The found parameter that tells the count.
pub const FOUND: &str = "affordable";
/// Where the search starts for what is timed; what is counted is the same each time, and starts with one.
const FIRST: u64 = 8;
/// A count is at most this many times the largest before.
const STRIDE: f64 = 8.0;
const MOST: u64 = 1 << 20;
/// Images that spend the budget within this share of it are taken.
const NEAR: f64 = 0.03;
/// Times that the job is rendered at most.
const TRIALS: usize = 8;
/// A budget that is missed by more than this share gets a note.
const MISSED: f64 = 0.1;

/// A job that is rendered with a count.
pub struct Trial<'a> {
    /// Lights or samples.
    pub count: u64,
    spending: &'a Spending,
    /// What all images spent, and their number.
    spent: f64,
    images: usize,
    /// What it adds to the search where it is passed over.
    search: Search,
    /// Those of all viewers, of a job of one frame.
    kept: Vec<Rendered>,
}

/// What a budget pays for.
#[derive(Debug)]
pub struct Afforded {
    /// Lights or samples.
    pub count: u64,
    /// The images of a job of one frame with this count; those of more frames are to be rendered again.
    pub images: Vec<Rendered>,
    search: Search,
    note: Option<String>,
}

/// What images of a count spent.
#[derive(Clone, Copy)]
struct Cost {
    count: u64,
    /// An image, in the mean; of a count that was rendered more than once the least.
    spent: f64,
    again: bool,
}

impl<'a> Trial<'a> {
    /// Of no image yet.
    fn new(count: u64, spending: &'a Spending) -> Self {
        Self {
            count,
            spending,
            spent: 0.0,
            images: 0,
            search: Search::default(),
            kept: Vec::new(),
        }
    }

    /// Adds the images of a frame, each of so many pixels. They are kept if no other frame is added.
    pub fn add(&mut self, images: Vec<Rendered>, pixels: usize) {
        for image in &images {
            self.spent += (self.spending.of)(image, pixels as f64);
            self.search.add(Search {
                seconds: image.stages.total(),
                rays: image.rays,
            });
            self.search.add(image.search);
        }
        let is_first = self.images == 0;
        self.images += images.len();
        self.kept = if is_first { images } else { Vec::new() };
    }

    fn mean(&self) -> f64 {
        self.spent / self.images.max(1) as f64
    }
}

impl Afforded {
    /// Tells in the images of the first frame what was found, and what finding it took.
    pub fn tell(&self, images: &mut [Rendered]) {
        let Some(first) = images.first_mut() else {
            return;
        };
        first.found.push((FOUND, self.count as f64));
        first.search.add(self.search);
        first.notes.extend(self.note.clone());
    }
}

/// The count whose images spend what is nearest to a budget of those that were rendered, and no more if it is counted;
/// `None` of a budget that is counted out. `render` renders all frames with the count of a trial, and adds them to it.
///
/// # Errors
/// Those of `render`.
pub fn afford(
    budget: Budget,
    mut render: impl FnMut(&mut Trial) -> Result<(), String>,
) -> Result<Option<Afforded>, String> {
    let Budget { unit, amount } = budget;
    let Some(spending) = &unit.spending else {
        return Ok(None);
    };
    let mut rendered = |count| {
        let mut trial = Trial::new(count, spending);
        render(&mut trial)?;
        Ok::<Trial, String>(trial)
    };
    let mut search = Search::default();
    let mut count = match spending.is_counted {
        true => 1,
        false => FIRST,
    };
    if !spending.is_counted {
        search.add(rendered(count)?.search); // The first image finds cold caches: its time is not looked at.
    }
    let mut costs: Vec<Cost> = Vec::new();
    let mut best: Option<Trial> = None;
    for _ in 0..TRIALS {
        let tried = rendered(count)?;
        let spent = tried.mean();
        match costs.iter_mut().find(|known| known.count == count) {
            // What disturbs a measurement only adds to it.
            Some(known) => {
                known.spent = known.spent.min(spent);
                known.again = true;
            }
            None => costs.push(Cost {
                count,
                spent,
                again: spending.is_counted,
            }),
        }
        let missed = spending.missed(spent, amount);
        let is_nearer = |best: &Trial| missed < spending.missed(best.mean(), amount);
        let passed_over = match best.as_ref().is_none_or(is_nearer) {
            true => best.replace(tried),
            false => Some(tried),
        };
        if let Some(passed_over) = passed_over {
            search.add(passed_over.search);
        }
        count = next(amount, spending, &costs);
        let seen_again = costs
            .iter()
            .any(|known| known.count == count && known.again);
        if missed <= NEAR || seen_again {
            break;
        }
    }
    let best = best
        .filter(|best| best.images > 0)
        .ok_or("no image was rendered")?;
    let spent = best.mean();
    let is_missed = (spent - amount).abs() / amount > MISSED;
    let note = is_missed.then(|| {
        format!(
            "no count of lights or samples comes within {:.0} % of {amount} {}: with {} it is {spent:.4}",
            100.0 * MISSED,
            unit.heading,
            best.count
        )
    });
    if best.kept.is_empty() {
        search.add(best.search);
    }
    Ok(Some(Afforded {
        count: best.count,
        images: best.kept,
        search,
        note,
    }))
}

/// The count that the line through the two costs on either side of the budget, or else the two
/// nearest ones, gives; proportional to the cost where there is no rising line. Of what is counted it lies between the
/// largest known count within the budget and the smallest one beyond, until they are neighbours.
fn next(amount: f64, spending: &Spending, costs: &[Cost]) -> u64 {
    let mut near = costs.to_vec();
    let missed = |c: &Cost| (c.spent - amount).abs();
    near.sort_by(|a, b| missed(a).total_cmp(&missed(b)));
    let nearest = near[0];
    let beyond = |c: &&Cost| (c.spent > amount) != (nearest.spent > amount);
    let other = near.iter().find(beyond).or(near.get(1));
    let slope = other.map_or(f64::NAN, |o| {
        (o.spent - nearest.spent) / (o.count as f64 - nearest.count as f64)
    });
    let wanted = if slope > 0.0 && slope.is_finite() {
        nearest.count as f64 + (amount - nearest.spent) / slope
    } else {
        nearest.count as f64 * amount / nearest.spent.max(1e-9)
    };
    let largest = costs.iter().map(|c| c.count).max().unwrap_or(FIRST);
    let most = STRIDE * largest as f64;
    if !spending.is_counted {
        return (wanted.round().clamp(1.0, most) as u64).min(MOST);
    }
    let is_within = |c: &&Cost| c.spent <= amount;
    let within = costs.iter().filter(is_within).map(|c| c.count).max();
    let beyond = costs.iter().filter(|c| !is_within(c)).map(|c| c.count);
    let beyond = beyond.min().unwrap_or(most as u64 + 1);
    match within {
        // Neighbours, or not even the least count.
        None => 1,
        Some(within) if within + 1 >= beyond => within,
        Some(within) => (wanted as u64).clamp(within + 1, beyond - 1).min(MOST),
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::technique::{RAYS_PER_PIXEL, SECONDS, Seconds, Stages, Unit};
    use crate::trace::RayCounts;

    fn within(
        amount: f64,
        unit: &'static Unit,
        render: impl FnMut(&mut Trial) -> Result<(), String>,
    ) -> Result<Afforded, String> {
        let found = afford(Budget { unit, amount }, render)?;
        Ok(found.expect("spent"))
    }

    /// A still that takes `cost(count)` seconds and a thousand times as many rays, of a thousand pixels.
    fn costing(cost: impl Fn(u64) -> f64) -> impl Fn(&mut Trial) -> Result<(), String> {
        move |trial| {
            let mut stages = Stages::default();
            let cpu = cost(trial.count);
            stages.add(
                "rendering",
                Seconds {
                    // However long it took beside other programs.
                    wall: 7.0,
                    cpu,
                    ..Seconds::default()
                },
            );
            let images = vec![Rendered {
                stages,
                rays: RayCounts {
                    closest: (1000.0 * cpu) as u64,
                    ..RayCounts::default()
                },
                ..Rendered::default()
            }];
            trial.add(images, 1000);
            Ok(())
        }
    }

    fn told(afforded: &Afforded) -> Rendered {
        let mut images = vec![Rendered::default()];
        afforded.tell(&mut images);
        images.remove(0)
    }

    #[test]
    fn a_line_is_found_in_few_images() {
        for (constant, slope, count) in [(0.5, 0.01, 50.0), (0.0, 1e-4, 10_000.0), (0.9, 0.1, 1.0)]
        {
            let images = Cell::new(0);
            let line = costing(|n| constant + slope * n as f64);
            let counted = |trial: &mut Trial| {
                images.set(images.get() + 1);
                line(trial)
            };
            let afforded = within(1.0, &SECONDS, counted).expect("renders");
            let missed = (afforded.images[0].stages.total().cpu - 1.0).abs();
            assert!(missed <= NEAR, "{count}: {missed}");
            assert!((afforded.count as f64 / count - 1.0).abs() <= 0.1);
            assert!(images.get() <= 7, "{}", images.get());
            let told = told(&afforded);
            assert_eq!(told.found, [(FOUND, afforded.count as f64)]);
            assert!(told.notes.is_empty());
            assert_eq!(told.search.seconds.wall, 7.0 * (images.get() - 1) as f64);
        }
    }

    #[test]
    fn rays_are_never_exceeded_but_by_the_least_count() {
        for (constant, slope, count) in [(0.5, 0.01, 50), (0.0, 0.32, 3), (0.95, 0.04, 1)] {
            let line = costing(|n| constant + slope * n as f64);
            let afforded = within(1.0 + 1e-9, &RAYS_PER_PIXEL, line).expect("renders");
            assert_eq!(afforded.count, count);
            assert!(told(&afforded).notes.is_empty());
        }
        let bent = costing(|n| 0.1 * (n as f64).powf(1.5));
        let bent = within(10.0, &RAYS_PER_PIXEL, bent).expect("renders");
        assert_eq!(bent.count, 21, "21^1.5 is 96, 22^1.5 is 103");
        let fixed = costing(|n| 9.9 + 0.5 * n as f64);
        let fixed = within(16.0, &RAYS_PER_PIXEL, fixed).expect("renders");
        assert_eq!(fixed.count, 12, "most of it does not follow the count");
        let dear = within(1.0, &RAYS_PER_PIXEL, costing(|n| 3.0 * n as f64));
        let dear = dear.expect("renders");
        let note = told(&dear).notes.remove(0);
        assert!(dear.count == 1 && note.contains("with 1 it is 3"), "{note}");
    }

    #[test]
    fn a_job_of_several_frames_is_rendered_again_and_all_trials_are_search() {
        let trials = Cell::new(0);
        let line = costing(|n| n as f64);
        let two_frames = |trial: &mut Trial| {
            trials.set(trials.get() + 1);
            line(trial)?;
            line(trial)
        };
        let afforded = within(5.0, &RAYS_PER_PIXEL, two_frames).expect("renders");
        assert_eq!((afforded.count, afforded.images.len()), (5, 0));
        assert_eq!(
            told(&afforded).search.seconds.wall,
            14.0 * f64::from(trials.get())
        );
    }

    #[test]
    fn a_budget_out_of_reach_gets_the_nearest_image_and_a_note() {
        let of = |cost: fn(u64) -> f64| within(1.0, &SECONDS, costing(cost)).expect("renders");
        let slow = of(|n| 3.0 + n as f64);
        assert_eq!((slow.count, told(&slow).notes.len()), (1, 1));
        assert_eq!(told(&of(|_| 0.25)).notes.len(), 1);
        let bent = of(|n| 0.1 + 0.01 * (n.min(60)) as f64);
        let cpu = bent.images[0].stages.total().cpu;
        assert!((cpu - 0.7).abs() < 1e-9, "fewer lights than asked");
    }

    #[test]
    fn a_cold_start_does_not_mislead() {
        let images = Cell::new(0);
        let disturbed = |trial: &mut Trial| {
            images.set(images.get() + 1);
            let disturbance = if images.get() == 1 { 5.0 } else { 0.0 };
            costing(move |n| 0.1 * n as f64 + disturbance)(trial)
        };
        let afforded = within(1.0, &SECONDS, disturbed).expect("renders");
        assert_eq!((afforded.count, told(&afforded).notes.len()), (10, 0));
    }

    #[test]
    fn errors_end_the_search() {
        for unit in [&SECONDS, &RAYS_PER_PIXEL] {
            let result = within(1.0, unit, |_| Err("no map".into()));
            assert_eq!(result.err().as_deref(), Some("no map"));
        }
    }
}
