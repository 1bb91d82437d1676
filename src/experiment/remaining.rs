//! How long a run will still take, by what its parts took so far.
//!
//! Work is counted in rays, but a ray of a path, of a record and of a reference cost differently in each scene. So seconds
//! are kept apart by reference or job, scene and method, and what is open is charged with the seconds per ray of what is
//! most like it: the same method in the same scene, the same method, the same scene, or what there is.
//!
//! The machine may be faster or slower than it was, because other programs come and go. What is done of a kind that was
//! timed before tells by how much; what was spent counts at the pace of its time, and what is open at that of now.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::Job;
use super::play::renders;
use super::progress::sweep_text;
use crate::technique::Started;

/// Metrics of one pixel take about as long as this many rays; they are most of a small job.
const RAYS_PER_COMPARED_PIXEL: f64 = 60.0;

/// What the report takes on two cores of 2.3 GHz, and what for each pixel of the image that it shows of a method in a scene.
const REPORT_SECONDS: f64 = 1.0;
const REPORT_SECONDS_PER_PIXEL: f64 = 1e-6;

/// The pace is that of about so long, and of a tenth of the run where that is longer.
const PACE_SECONDS: f64 = 10.0;

/// What a job costs beside its reference, in rays.
fn work(job: &Job, images: f64) -> f64 {
    let sequence = &job.sequence;
    let pixels = (job.width * job.height * sequence.viewers.len()) as f64;
    let rays = job.estimated_rays() as f64 / sequence.frames.len().max(1) as f64;
    let measured = sequence.measured().count() as f64;
    rays * images + RAYS_PER_COMPARED_PIXEL * pixels * measured
}

/// How many times what its budget grants an image a job takes, as its contender tells; no ray is cast for it.
fn images_worth(job: &Job) -> f64 {
    let sequence = &job.sequence;
    let places = 0..sequence.frames.len();
    let technique = job.built_technique();
    let choice = job.choice(job.budget.count().unwrap_or(1));
    let started = technique.as_ref().map(|t| choice.start(t.as_ref()));
    let Some(Ok(Started { contender, .. })) = started else {
        return places.len() as f64;
    };
    let rendered = places.filter(|place| renders(job, contender.as_ref(), *place));
    let without_memory = match sequence.cold && contender.remembers() {
        true => sequence.measured().count(),
        false => 0,
    };
    contender.times() * (rendered.count() + without_memory) as f64
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Kind {
    Reference,
    Job,
}

/// What costs about the same: kind, scene, and label of the method.
type Like = (Kind, String, String);

fn like_job(job: &Job) -> Like {
    (Kind::Job, job.scene.clone(), job.label.clone())
}

fn like_reference(job: &Job) -> Like {
    (Kind::Reference, job.scene.clone(), String::new())
}

#[derive(Clone, Copy, Debug, Default)]
struct Spent {
    /// Work that was timed.
    timed: f64,
    /// Of the time that it took, at a pace of one.
    seconds: f64,
}

/// No time is told while more than this share of it is of methods or references that were not timed in any scene.
const MOST_UNTIMED: f64 = 0.5;

/// How much longer things take than they did at first, of late.
#[derive(Clone, Copy, Debug, Default)]
struct Pace {
    /// What things took, and what they would have taken at first; old ones fade.
    took: f64,
    expected: f64,
    /// All seconds so far.
    whole: f64,
}

impl Pace {
    fn add(&mut self, took: f64, expected: f64) {
        self.whole += took;
        let fades = (-took / PACE_SECONDS.max(0.1 * self.whole)).exp();
        self.took = self.took * fades + took;
        self.expected = self.expected * fades + expected;
    }

    fn now(&self) -> f64 {
        match self.took > 0.0 && self.expected > 0.0 {
            true => self.took / self.expected,
            false => 1.0,
        }
    }
}

impl Spent {
    fn add(&mut self, other: Self) {
        self.timed += other.timed;
        self.seconds += other.seconds;
    }

    fn rate(&self) -> Option<f64> {
        (self.timed > 0.0).then(|| self.seconds / self.timed)
    }
}

/// A reference, or all of a sequence.
#[derive(Clone, Copy, Debug)]
struct Made {
    work: f64,
    images: f64,
    /// Images that are complete, and the share of the one at work.
    complete: f64,
    within: Option<f64>,
}

impl Made {
    fn share(&self) -> f64 {
        ((self.complete + self.within.unwrap_or(0.0)) / self.images).min(1.0)
    }
}

/// See the module.
#[derive(Debug, Default)]
pub(super) struct Remaining {
    /// Work that is open.
    open: BTreeMap<Like, f64>,
    spent: BTreeMap<Like, Spent>,
    references: HashMap<String, Made>,
    /// The job at work, and its share that is done.
    at_work: Option<(String, f64)>,
    /// What jobs take, in what their budgets grant an image, by method and scene, which play a sequence alike.
    images: HashMap<(Like, String), f64>,
    pace: Pace,
    report_seconds: f64,
}

impl Remaining {
    /// Of jobs that are all open; `is_stored` says of which keys the references are there.
    pub fn of(open: &[&Job], is_stored: impl Fn(&str) -> bool) -> Self {
        let mut remaining = Self {
            report_seconds: REPORT_SECONDS,
            ..Self::default()
        };
        for job in open {
            let work = remaining.work(job);
            if !remaining.open.contains_key(&like_job(job)) {
                let pixels = (job.width * job.height) as f64;
                remaining.report_seconds += REPORT_SECONDS_PER_PIXEL * pixels;
            }
            *remaining.open.entry(like_job(job)).or_default() += work;
            if remaining.references.contains_key(&job.reference) {
                continue;
            }
            let images = job.sequence.measured().count() * job.sequence.viewers.len();
            let made = Made {
                work: job.reference_rays() as f64,
                images: images.max(1) as f64,
                complete: match is_stored(&job.reference) {
                    true => images.max(1) as f64,
                    false => 0.0,
                },
                within: None,
            };
            let left = made.work * (1.0 - made.share());
            *remaining.open.entry(like_reference(job)).or_default() += left;
            remaining.references.insert(job.reference.clone(), made);
        }
        remaining
    }

    /// `done` of `all` passes of an image of a job's reference are there, `seconds` after whatever was told last.
    pub fn reference(&mut self, job: &Job, done: u32, all: u32, seconds: f64) {
        let Some(made) = self.references.get_mut(&job.reference) else {
            return;
        };
        let before = *made;
        // Of an image that begins, nothing was timed yet: it may have been taken up half-way.
        let is_timed = before.within.is_some();
        made.within = Some(f64::from(done) / f64::from(all.max(1)));
        if done >= all {
            made.complete = (made.complete + 1.0).min(made.images);
            made.within = None;
        }
        let gained = made.work * (made.share() - before.share());
        let like = like_reference(job);
        self.close(&like, gained);
        if is_timed {
            self.spend(like, gained, seconds);
        }
    }

    /// `share` of a job is done, `seconds` after whatever was told last.
    pub fn job(&mut self, job: &Job, share: f64, seconds: f64) {
        let before = match &self.at_work {
            Some((id, share)) if *id == job.id => *share,
            _ => 0.0,
        };
        let gained = self.work(job) * (share - before).max(0.0);
        self.at_work = Some((job.id.clone(), share));
        let like = like_job(job);
        self.close(&like, gained);
        self.spend(like, gained, seconds);
        if share >= 1.0
            && let Some(made) = self.references.get_mut(&job.reference)
        {
            // Whatever it was measured against is there now.
            let left = made.work * (1.0 - made.share());
            (made.complete, made.within) = (made.images, None);
            self.close(&like_reference(job), left);
        }
    }

    fn close(&mut self, like: &Like, work: f64) {
        if let Some(open) = self.open.get_mut(like) {
            *open = (*open - work).max(0.0);
        }
    }

    fn work(&mut self, job: &Job) -> f64 {
        let alike = (like_job(job), sweep_text(job));
        let images = self.images.entry(alike);
        work(job, *images.or_insert_with(|| images_worth(job)))
    }

    fn spend(&mut self, like: Like, timed: f64, seconds: f64) {
        if timed <= 0.0 {
            return;
        }
        let known = self.spent.get(&like).and_then(Spent::rate);
        // What was not timed before tells nothing of the pace.
        let expected = known.map_or_else(|| seconds / self.pace.now(), |rate| rate * timed);
        self.pace.add(seconds, expected);
        let seconds = seconds / self.pace.now();
        let spent = self.spent.entry(like).or_default();
        spent.add(Spent { timed, seconds });
    }

    /// Seconds until all is done, the report included; `None` while too little was timed to tell.
    pub fn seconds(&self) -> Option<f64> {
        let mut by_method: HashMap<(Kind, &str), Spent> = HashMap::new();
        let mut by_scene: HashMap<(Kind, &str), Spent> = HashMap::new();
        let mut by_kind: HashMap<Kind, Spent> = HashMap::new();
        let mut all = Spent::default();
        for ((kind, scene, label), spent) in &self.spent {
            by_method.entry((*kind, label)).or_default().add(*spent);
            by_scene.entry((*kind, scene)).or_default().add(*spent);
            by_kind.entry(*kind).or_default().add(*spent);
            all.add(*spent);
        }
        let rate = |like: &Like| {
            let (kind, scene, label) = like;
            let alike = [
                self.spent.get(like),
                by_method.get(&(*kind, label)),
                by_scene.get(&(*kind, scene)),
                by_kind.get(kind),
            ];
            let known = alike.into_iter().flatten().find_map(Spent::rate);
            known.or_else(|| all.rate())
        };
        // Whoever comes first may be much faster than all others.
        let jobs = self
            .open
            .iter()
            .filter(|((kind, ..), open)| *kind == Kind::Job && **open > 0.0);
        let methods: HashSet<&str> = jobs.map(|((.., label), _)| label.as_str()).collect();
        let timed = |label: &&&str| by_method.contains_key(&(Kind::Job, **label));
        if 2 * methods.iter().filter(timed).count() < methods.len() {
            return None;
        }
        let (mut at_first, mut untimed) = (self.report_seconds, 0.0);
        for (like, open) in self.open.iter().filter(|(_, open)| **open > 0.0) {
            let (kind, _, label) = like;
            let seconds = open * rate(like)?;
            at_first += seconds;
            if !by_method.contains_key(&(*kind, label)) {
                untimed += seconds;
            }
        }
        (untimed <= MOST_UNTIMED * at_first).then(|| at_first * self.pace.now())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::{Source, plan};

    fn jobs() -> Vec<Job> {
        planned(
            "name = 'n'\ntechnique = 'ambient-occlusion'\ncaches = 60\nsize = [48, 27]\nrepeats = 3\n\
                    [[scene]]\nname = 'statues'\n[[scene]]\nname = 'atrium'\n\
                    [[method]]\nid = 'IM'\n[[method]]\nid = 'VGC+DGS'\n",
        )
    }

    fn planned(text: &str) -> Vec<Job> {
        let source = Source {
            text: text.into(),
            ..Source::default()
        };
        plan(&source, &[]).expect("a plan").1.jobs
    }

    /// Whether a guess is within a factor of two of what it takes.
    fn is_near(guess: f64, true_seconds: f64) -> bool {
        guess <= 2.0 * true_seconds && guess >= 0.5 * true_seconds
    }

    #[test]
    fn nothing_is_told_while_most_methods_are_unknown() {
        let jobs = planned(
            "name = 'n'\ntechnique = 'ambient-occlusion'\ncaches = 60\nsize = [48, 27]\nrepeats = 3\n\
             [[scene]]\nname = 'statues'\n\
             [[method]]\nid = 'IM'\n[[method]]\nid = 'SD'\n[[method]]\nid = 'VGC'\n",
        );
        let jobs: Vec<&Job> = jobs.iter().collect();
        let mut remaining = Remaining::of(&jobs, |_| true);
        let of = |label: &str| jobs.iter().find(|job| job.label == label).expect("planned");
        remaining.job(of("IM"), 1.0, 1.0);
        assert_eq!(remaining.seconds(), None, "one of three methods");
        remaining.job(of("SD"), 1.0, 9.0);
        assert!(remaining.seconds().is_some());
    }

    #[test]
    fn a_job_takes_what_its_contender_renders() {
        let jobs = planned(
            "name = 'n'\ntechnique = 'radiance'\nsamples = 1\nsize = [16, 16]\n\
             [sequence]\nframes = '0..10'\nwarm_up = 5\nmeasure_every = 5\ncold = true\nskip_unmeasured = true\n\
             [[scene]]\nname = 'country-house'\npath = 'approach'\n\
             [[method]]\nid = 'paths'\n[[method]]\nid = 'paths'\nlabel = 'more'\ntimes = 8\n\
             [[method]]\nid = 'hash-cache'\n",
        );
        let looked_at = jobs[0].sequence.measured().count() as f64;
        assert!(looked_at > 0.0 && looked_at < 10.0, "{looked_at} frames");
        let images: Vec<f64> = jobs.iter().map(images_worth).collect();
        // Without memory only frames that are measured; with it all, and those once more without.
        assert_eq!(images, [looked_at, 8.0 * looked_at, 10.0 + looked_at]);
    }

    #[test]
    fn a_machine_that_becomes_slower_is_noticed() {
        let jobs = jobs();
        let open: Vec<&Job> = jobs.iter().collect();
        let mut remaining = Remaining::of(&open, |_| true);
        // All methods of both scenes at 4 s, then the machine does a third of that.
        let by_seed = |seed: usize| jobs.iter().skip(seed).step_by(3);
        for job in by_seed(0) {
            remaining.job(job, 1.0, 4.0);
        }
        let guess = remaining.seconds().expect("known");
        assert!(is_near(guess, 8.0 * 4.0), "{guess}");
        for job in by_seed(1) {
            remaining.job(job, 1.0, 12.0);
        }
        let guess = remaining.seconds().expect("known");
        let true_seconds = 4.0 * 12.0 + 3.0 * REPORT_SECONDS;
        assert!((guess / true_seconds - 1.0).abs() < 0.2, "{guess}");
    }

    #[test]
    fn after_a_tenth_it_is_right_within_a_factor_of_two() {
        // A scene takes 20 s of reference and 4 s a job, the other 0.6 of both; the second method 1.5 times as long.
        let jobs = jobs();
        let open: Vec<&Job> = jobs.iter().collect();
        let pace = |job: &Job| if job.scene == "statues" { 1.0 } else { 0.6 };
        let took = |job: &Job| pace(job) * if job.label == "IM" { 4.0 } else { 6.0 };
        let references = 20.0 + 12.0;
        let total = references + jobs.iter().map(took).sum::<f64>();
        for stored in [false, true] {
            let mut remaining = Remaining::of(&open, |_| stored);
            let mut left = total - if stored { references } else { 0.0 };
            let whole = left;
            let mut known: Option<&str> = None;
            let check = |remaining: &Remaining, left: f64| {
                if left >= 0.9 * whole || left <= 0.0 {
                    return;
                }
                match remaining.seconds() {
                    Some(guess) => assert!(is_near(guess, left), "{guess} for {left}, {stored}"),
                    None => assert!(left > 0.6 * whole, "nothing is told of {left}"),
                }
            };
            for job in &open {
                if known != Some(&job.reference) && !stored {
                    remaining.reference(job, 0, 4, 1.0);
                    for pass in 1..=4 {
                        let seconds = 5.0 * pace(job);
                        remaining.reference(job, pass, 4, seconds);
                        left -= seconds;
                        check(&remaining, left);
                    }
                }
                known = Some(&job.reference);
                remaining.job(job, 1.0, took(job));
                left -= took(job);
                check(&remaining, left);
            }
            let report = remaining.seconds().expect("a guess");
            assert!(report < 0.1 * whole, "the report takes {report}");
        }
    }
}
