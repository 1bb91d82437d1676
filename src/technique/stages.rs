//! What each stage of a job took: wall time, and processor time of all threads and of the one that coordinates them.

use std::ops::{AddAssign, Sub};
use std::time::Instant;

/// Seconds of one stage, or of one moment on the clocks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Time on the clock.
    pub wall: f64,
    /// Processor time of all threads of the program.
    pub cpu: f64,
    /// Processor time of the thread that runs the stage: work that no other thread shares.
    pub serial: f64,
}

impl Seconds {
    /// What one thread did alone, as a share of all processor time; 0 where nothing was measured.
    pub fn serial_share(self) -> f64 {
        if self.cpu > 0.0 {
            (self.serial / self.cpu).min(1.0)
        } else {
            0.0
        }
    }
}

impl AddAssign for Seconds {
    fn add_assign(&mut self, other: Self) {
        self.wall += other.wall;
        self.cpu += other.cpu;
        self.serial += other.serial;
    }
}

impl Sub for Seconds {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            wall: self.wall - other.wall,
            cpu: self.cpu - other.cpu,
            serial: self.serial - other.serial,
        }
    }
}

/// A time at which clocks were read.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
    cpu: f64,
    serial: f64,
}

impl Clock {
    /// Reads the clocks. Processor times are 0 where the system has none.
    pub fn start() -> Self {
        let [cpu, serial] = processor_times();
        Self {
            start: Instant::now(),
            cpu,
            serial,
        }
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> Seconds {
        let [cpu, serial] = processor_times();
        Seconds {
            wall: self.start.elapsed().as_secs_f64(),
            cpu: cpu - self.cpu,
            serial: serial - self.serial,
        }
    }
}

/// Processor seconds of the program and of this thread.
#[cfg(unix)]
fn processor_times() -> [f64; 2] {
    use rustix::time::{ClockId, clock_gettime};
    [ClockId::ProcessCPUTime, ClockId::ThreadCPUTime].map(|clock| {
        let time = clock_gettime(clock);
        time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
    })
}

#[cfg(not(unix))]
fn processor_times() -> [f64; 2] {
    [0.0; 2]
}

/// A stage and what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// As in the columns `seconds_<stage>`.
    pub name: &'static str,
    /// Over all its executions.
    pub seconds: Seconds,
}

/// The stages of a job, in order of first execution.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stages(pub Vec<Stage>);

impl Stages {
    /// Runs `work` and adds what it took to the stage.
    pub fn time<T>(&mut self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        let clock = Clock::start();
        let result = work();
        self.add(stage, clock.seconds());
        result
    }

    /// Adds to a stage.
    pub fn add(&mut self, name: &'static str, seconds: Seconds) {
        match self.0.iter_mut().find(|stage| stage.name == name) {
            Some(stage) => stage.seconds += seconds,
            None => self.0.push(Stage { name, seconds }),
        }
    }

    /// All stages together.
    pub fn total(&self) -> Seconds {
        let mut total = Seconds::default();
        self.0.iter().for_each(|stage| total += stage.seconds);
        total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_that_runs_twice_stands_once_and_all_of_a_single_thread_is_serial() {
        let mut stages = Stages::default();
        let busy = || (0..2_000_000u64).map(std::hint::black_box).sum::<u64>();
        let first = stages.time("a", busy);
        stages.time("b", || ());
        let second = stages.time("a", busy);
        assert_eq!(first, second);
        let names: Vec<&str> = stages.0.iter().map(|stage| stage.name).collect();
        assert_eq!(names, ["a", "b"]);
        let a = stages.0[0].seconds;
        // The two clocks are not read at the same moment.
        assert!(a.wall > 0.0 && a.serial <= a.cpu + 1e-3, "{a:?}");
        assert!(stages.total().wall >= a.wall);
    }
}
