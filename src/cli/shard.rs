//! Shards: which jobs of a plan are dealt to one of several machines.

use std::collections::HashMap;

use super::exit::Failure;
use crate::experiment::Job;

/// One of several machines.
#[derive(Clone, Copy)]
pub struct Shard {
    /// From zero.
    number: usize,
    of: usize,
}

impl Shard {
    /// All jobs.
    pub const WHOLE: Self = Self { number: 0, of: 1 };

    /// Of `K/N`.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        text.split_once('/')
            .and_then(|(k, n)| Some((k.parse::<usize>().ok()?, n.parse::<usize>().ok()?)))
            .filter(|(k, n)| *k >= 1 && k <= n)
            .map(|(k, of)| Self { number: k - 1, of })
            .ok_or_else(|| {
                Failure::usage(format!(
                    "--shard {text}: expected K/N with 1 ≤ K ≤ N, for example 2/8"
                ))
            })
    }

    pub fn is_whole(self) -> bool {
        self.of == 1
    }

    /// Its jobs. Those that share a reference stay together, so that none is rendered twice; where there are fewer
    /// references (of sequences: sets of them) than shards, jobs are dealt one by one.
    pub fn own(self, mut jobs: Vec<Job>) -> Vec<Job> {
        let groups = Groups::of(&jobs);
        let by_group = groups.sets >= self.of;
        let mut dealt = groups.of_jobs.into_iter().enumerate();
        jobs.retain(|_| {
            dealt.next().is_some_and(|(i, group)| {
                let place = if by_group { group } else { i };
                place % self.of == self.number
            })
        });
        jobs
    }
}

/// Jobs by the references that they share, one with another or through others.
struct Groups {
    /// The group of each job, in the order of their first jobs.
    of_jobs: Vec<usize>,
    /// How many different sets of references there are.
    sets: usize,
}

impl Groups {
    fn of(jobs: &[Job]) -> Self {
        let mut sets: HashMap<&str, usize> = HashMap::new();
        let mut first_with: HashMap<&str, usize> = HashMap::new();
        // An earlier set that each is joined with, or itself.
        let mut joined: Vec<usize> = Vec::new();
        let mut of_jobs = Vec::with_capacity(jobs.len());
        for job in jobs {
            let set = *sets.entry(&job.reference).or_insert(joined.len());
            of_jobs.push(set);
            if set < joined.len() {
                continue;
            }
            joined.push(set);
            for reference in job.references.iter() {
                let earlier = *first_with.entry(reference).or_insert(set);
                let ends = [earlier, set].map(|set| end(&joined, set));
                joined[ends[0].max(ends[1])] = ends[0].min(ends[1]);
            }
        }
        let mut numbers: HashMap<usize, usize> = HashMap::new();
        for group in &mut of_jobs {
            let next = numbers.len();
            *group = *numbers.entry(end(&joined, *group)).or_insert(next);
        }
        Self {
            of_jobs,
            sets: joined.len(),
        }
    }
}

/// The first of the sets that one is joined with.
fn end(joined: &[usize], mut set: usize) -> usize {
    while joined[set] != set {
        set = joined[set];
    }
    set
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::experiment::{Override, Source, plan};

    /// Jobs of one sequence for each scene and setting, each of one method.
    fn sequences(scenes: &[&str], setting: &str) -> Vec<Job> {
        let mut text = String::from(
            "name = 'n'\ntechnique = 'radiance'\nsamples = 1\nsize = [16, 12]\n\
             [sequence]\npath = 'walk'\nframes = '0..8'\n\
             [[path]]\nname = 'walk'\n\
             keys = [{ time = 0, view = 'main' }, { time = 9, view = 'main', move = [1, 0, 0] }]\n\
             [[method]]\nid = 'sharc'\n",
        );
        for scene in scenes {
            text += &format!("[[scene]]\nname = '{scene}'\n");
        }
        planned(text, setting)
    }

    fn planned(text: String, setting: &str) -> Vec<Job> {
        let source = Source {
            text,
            ..Source::default()
        };
        let setting = Override::parse(setting).expect("an override");
        plan(&source, &[setting]).expect("a plan").1.jobs
    }

    fn dealt(jobs: &[Job], of: usize) -> Vec<Vec<Job>> {
        (0..of)
            .map(|number| Shard { number, of }.own(jobs.to_vec()))
            .collect()
    }

    fn references(jobs: &[Job]) -> BTreeSet<&str> {
        let keys = jobs.iter().flat_map(|job| job.references.iter());
        keys.map(String::as_str).collect()
    }

    /// The references of all shards, one after another.
    fn rendered(shards: &[Vec<Job>]) -> usize {
        shards.iter().map(|jobs| references(jobs).len()).sum()
    }

    #[test]
    fn no_two_shards_render_a_reference_of_sequences_that_share_some() {
        let scenes = ["cornell-curved", "still-puzzle"];
        let jobs = sequences(&scenes[..1], "sequence.warm_up=0,2");
        assert_eq!(jobs.len(), 2);
        assert_ne!(jobs[0].reference, jobs[1].reference);
        assert_eq!(references(&jobs).len(), 8);
        let shards = dealt(&jobs, 2);
        assert_eq!(rendered(&shards), 8);
        assert_eq!([shards[0].len(), shards[1].len()], [2, 0]);
        // The first and the second share none, but each some with the third.
        let jobs = sequences(&scenes, "sequence.frames=0..4,4..8,2..6");
        assert_eq!(jobs.len(), 6);
        let shards = dealt(&jobs, 2);
        assert_eq!(rendered(&shards), references(&jobs).len());
        for (shard, scene) in shards.iter().zip(scenes) {
            assert_eq!(shard.len(), 3);
            assert!(shard.iter().all(|job| job.scene == scene), "{scene}");
        }
    }

    #[test]
    fn stills_are_dealt_by_reference_or_one_by_one() {
        let text = "name = 'n'\ntechnique = 'radiance'\nsamples = 1\nsize = [16, 12]\nrepeats = 2\n\
                    [[scene]]\nname = 'cornell-curved'\n[[method]]\nid = 'sharc'\n";
        let jobs = planned(text.into(), "spp=1,2,3");
        assert_eq!((jobs.len(), references(&jobs).len()), (6, 3));
        let spp = |shards: Vec<Vec<Job>>| -> Vec<Vec<u32>> {
            let spp = |jobs: &Vec<Job>| jobs.iter().map(|job| job.spp).collect();
            shards.iter().map(spp).collect()
        };
        assert_eq!(spp(dealt(&jobs, 2)), [vec![1, 1, 3, 3], vec![2, 2]]);
        assert_eq!(spp(dealt(&jobs, 3)), [[1, 1], [2, 2], [3, 3]]);
        assert_eq!(
            spp(dealt(&jobs, 4)),
            [vec![1, 3], vec![1, 3], vec![2], vec![2]]
        );
    }
}
