//! Swept keys: their values, the combinations of these, and values that say the same.

use std::collections::{BTreeMap, HashMap, HashSet};

use toml::Value;

use super::Job;
use super::config::{ConfigError, Source};
use super::overrides::Override;

/// What a config and overrides sweep.
pub(super) struct Sweep<'a> {
    /// Key and values.
    pub axes: BTreeMap<String, Vec<Value>>,
    source: &'a Source,
    overrides: &'a [Override],
}

impl<'a> Sweep<'a> {
    /// Overrides with several values sweep as well; one with a single value ends the sweep of its key.
    pub fn new(
        source: &'a Source,
        swept: &BTreeMap<String, Vec<Value>>,
        overrides: &'a [Override],
    ) -> Self {
        let mut axes = swept.clone();
        for o in overrides {
            match o.values.len() {
                1 => _ = axes.remove(&o.key),
                _ => _ = axes.insert(o.key.clone(), o.values.clone()),
            }
        }
        Self {
            axes,
            source,
            overrides,
        }
    }

    /// An error at the place where a key is swept.
    pub fn error(&self, key: &str, message: String) -> ConfigError {
        match self.overrides.iter().find(|o| o.key == key) {
            None => self.source.error(&["sweep", key], message),
            Some(written) => ConfigError::Override {
                text: written.to_string(),
                message,
            },
        }
    }

    /// All combinations of the swept values, in the order of keys and values.
    pub fn combinations(&self) -> Vec<BTreeMap<String, Value>> {
        self.axes
            .iter()
            .fold(vec![BTreeMap::new()], |done, (key, values)| {
                done.iter()
                    .flat_map(|combination| {
                        values.iter().map(|value| {
                            let mut next = combination.clone();
                            next.insert(key.clone(), value.clone());
                            next
                        })
                    })
                    .collect()
            })
    }

    /// Leaves each job once: a swept key that a method does not have gives the same job again, which then stands for all
    /// of the key's values.
    ///
    /// # Errors
    /// A value that gives no job of its own for any method; seeds that are there twice.
    pub fn leave_each_once(&self, jobs: &mut Vec<Job>) -> Result<(), ConfigError> {
        let mut firsts = HashMap::new();
        let mut again: Vec<(usize, usize)> = Vec::new();
        for (index, job) in jobs.iter().enumerate() {
            let first = *firsts.entry(job.place()).or_insert(index);
            if first != index {
                again.push((first, index));
            }
        }
        for (first, second) in &again {
            self.check_seeds(&jobs[*first], &jobs[*second])?;
        }
        let own: HashSet<(&String, String)> = firsts
            .values()
            .flat_map(|first| &jobs[*first].sweep)
            .map(|(key, value)| (key, value.to_string()))
            .collect();
        for (first, second) in &again {
            self.check_value(&jobs[*first], &jobs[*second], &own)?;
        }
        for (first, second) in again {
            let other = jobs[second].sweep.clone();
            jobs[first].also_at.push(other);
        }
        let kept: HashSet<usize> = firsts.into_values().collect();
        let mut index = 0..;
        jobs.retain(|_| index.next().is_some_and(|index| kept.contains(&index)));
        Ok(())
    }

    /// Refuses a seed that follows from two values of `seed` or `repeats`.
    fn check_seeds(&self, first: &Job, second: &Job) -> Result<(), ConfigError> {
        let differs = |key: &&str| first.sweep.get(*key) != second.sweep.get(*key);
        let Some(key) = ["seed", "repeats"].into_iter().find(differs) else {
            return Ok(());
        };
        let of = |job: &Job| job.sweep.get(key).map_or(String::new(), Value::to_string);
        let message = format!(
            "`{key}` = {} and `{key}` = {} both run seed {}: repeats run the seeds `seed`, `seed` + 1, …; sweep neither \
             of them and write the first seed and the number of `repeats`, such as seed=1 repeats=3",
            of(first),
            of(second),
            first.seed
        );
        Err(self.error(key, message))
    }

    /// Refuses a value of which every job is one of another value; `own` are those with a job of their own.
    fn check_value(
        &self,
        first: &Job,
        second: &Job,
        own: &HashSet<(&String, String)>,
    ) -> Result<(), ConfigError> {
        for (key, value) in &second.sweep {
            if !own.contains(&(key, value.to_string())) {
                let other = first.sweep.get(key).map_or(String::new(), Value::to_string);
                let message = format!(
                    "`{key}` = {value} gives the jobs of `{key}` = {other} again and none of its own: leave one of the \
                     two out"
                );
                return Err(self.error(key, message));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::plan::plan;
    use super::*;

    fn planned(overrides: &[&str]) -> Result<usize, String> {
        let text = "name = \"t\"\ntechnique = \"ambient-occlusion\"\ncaches = 20\nsize = [24, 16]\n\
                    [[scene]]\nname = \"stairs\"\n[[method]]\nid = \"IM\"\n[[method]]\nid = \"VGC\"\n";
        let source = Source {
            file: "t.toml".into(),
            text: text.into(),
        };
        let overrides = overrides.iter().map(|text| Override::parse(text));
        let overrides: Vec<Override> = overrides.collect::<Result<_, _>>().expect("overrides");
        let planned = plan(&source, &overrides).map_err(|error| error.to_string())?;
        Ok(planned.1.jobs.len())
    }

    #[test]
    fn values_that_say_the_same_are_refused() {
        for (overrides, both) in [
            (
                &["scale=1/2,0.5"][..],
                "`scale` = 0.5 gives the jobs of `scale` = \"1/2\"",
            ),
            (
                &["technique=ambient-occlusion,path-tracing", "caches=20,40"],
                "an experiment has one `technique`",
            ),
            (&["title=a,b"], "none of its own"),
        ] {
            let error = planned(overrides).expect_err(both);
            assert!(error.contains(both), "{error}");
            assert!(
                error.starts_with(&format!("override `{}`", overrides[0])),
                "{error}"
            );
        }
    }

    #[test]
    fn seeds_that_overlap_are_refused() {
        for overrides in [&["seed=1,2", "repeats=2"][..], &["repeats=1,2"]] {
            let error = planned(overrides).expect_err("overlapping");
            assert!(
                error.contains("both run seed") && error.contains("repeats=3"),
                "{error}"
            );
        }
        assert_eq!(planned(&["seed=1,3", "repeats=2"]), Ok(8));
    }

    #[test]
    fn a_key_that_a_method_lacks_gives_its_job_once() {
        assert_eq!(planned(&["method.VGC.angle_deg=15,20"]), Ok(3));
        assert_eq!(
            planned(&["method.VGC.angle_deg=15,20", "scale=1,1/2"]),
            Ok(6)
        );
    }
}
