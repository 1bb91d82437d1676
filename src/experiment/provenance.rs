//! What made the results: program, machine, commands, and what was lost of the scenes.

use std::collections::BTreeMap;
use std::io;
use std::sync::OnceLock;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::{Plan, Store};
use crate::standard_error::tell;
use crate::trace::{Kernel, hidden_instructions};

const FILE: &str = "provenance.json";

/// The program's name, version and, if it was built in a checkout, commit.
pub fn program() -> String {
    let version = concat!("lightbench ", env!("CARGO_PKG_VERSION"));
    match env!("LIGHTBENCH_COMMIT") {
        "" => version.to_owned(),
        commit => format!("{version} ({commit})"),
    }
}

/// The kernel that answers rays. Bit identity is promised for one instruction set and one kernel.
pub fn kernel() -> String {
    Kernel::best().name().to_owned()
}

/// Processor, its number of threads, architecture and operating system.
pub fn machine() -> String {
    static MACHINE: OnceLock<String> = OnceLock::new();
    let describe = || {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let processor = processor().unwrap_or_else(|| "unknown processor".into());
        let (architecture, system) = (std::env::consts::ARCH, std::env::consts::OS);
        format!("{processor}, {threads} threads, {architecture}, {system}")
    };
    MACHINE.get_or_init(describe).clone()
}

/// The processor's name, where the system tells it in a file.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    let (_, name) = line.split_once(':')?;
    Some(name.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// `provenance.json`: one entry for each program and machine that worked on a folder.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Provenance {
    entries: Vec<Entry>,
    /// What was dropped, approximated or replaced of each scene, a sentence each.
    #[serde(default)]
    scenes: BTreeMap<String, Vec<String>>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Entry {
    program: String,
    machine: String,
    /// The kernel that answered rays.
    ray_kernel: String,
    /// Of the processor, those that the environment hid included.
    instruction_sets: Vec<String>,
    /// What `LIGHTBENCH_HIDE` kept from use.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    hidden_instruction_sets: Vec<String>,
    build: String,
    threads: usize,
    /// First and last time.
    started_unix_seconds: u64,
    last_started_unix_seconds: u64,
    experiment: String,
    configs: Vec<String>,
    overrides: Vec<String>,
}

impl Provenance {
    /// That of a folder; empty where there is none, and, with a line on standard error, where it is damaged.
    pub fn of(store: &Store) -> Self {
        let file = store.folder.join(FILE);
        let read = match std::fs::read_to_string(&file) {
            Ok(text) => serde_json::from_str(&text).map_err(|error| error.to_string()),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Self::default()),
            Err(error) => Err(error.to_string()),
        };
        read.unwrap_or_else(|error| {
            tell!(
                "warning: {} is damaged ({error}): which programs worked on this folder before is lost",
                file.display()
            );
            Self::default()
        })
    }

    /// Enters this program on this machine with a plan.
    pub fn start(&mut self, plan: &Plan) {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let now = now.map_or(0, |d| d.as_secs());
        let build = if cfg!(debug_assertions) {
            "debug"
        } else {
            "release"
        };
        self.enter(Entry {
            program: program(),
            machine: machine(),
            ray_kernel: kernel(),
            instruction_sets: instruction_sets(),
            hidden_instruction_sets: hidden_instructions()
                .into_iter()
                .map(str::to_owned)
                .collect(),
            build: build.into(),
            threads: rayon::current_num_threads(),
            started_unix_seconds: now,
            last_started_unix_seconds: now,
            experiment: plan.name.clone(),
            configs: plan
                .configs
                .iter()
                .map(|c| c.display().to_string())
                .collect(),
            overrides: plan.overrides.clone(),
        });
    }

    /// Notes what was lost of a scene; says whether that is new.
    pub fn note(&mut self, scene: &str, notes: &[String]) -> bool {
        let earlier = self.scenes.insert(scene.to_owned(), notes.to_vec());
        earlier.is_none_or(|earlier| earlier != notes)
    }

    /// Takes over what another folder knows.
    pub fn unite(&mut self, other: Self) {
        other
            .entries
            .into_iter()
            .for_each(|entry| self.enter(entry));
        self.scenes.extend(other.scenes);
    }

    /// Writes `provenance.json` into a results folder.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn write(&self, store: &Store) -> io::Result<()> {
        store.write(FILE, &format!("{}\n", serde_json::to_string_pretty(self)?))
    }

    fn enter(&mut self, new: Entry) {
        let alike = |known: &&mut Entry| {
            known.program == new.program
                && known.machine == new.machine
                && known.ray_kernel == new.ray_kernel
                && known.hidden_instruction_sets == new.hidden_instruction_sets
                && known.build == new.build
        };
        let Some(known) = self.entries.iter_mut().find(alike) else {
            self.entries.push(new);
            return;
        };
        known.threads = new.threads;
        known.started_unix_seconds = known.started_unix_seconds.min(new.started_unix_seconds);
        known.last_started_unix_seconds = known
            .last_started_unix_seconds
            .max(new.last_started_unix_seconds);
        extend(&mut known.configs, new.configs);
        extend(&mut known.overrides, new.overrides);
    }
}

/// Appends what is not there yet.
fn extend(known: &mut Vec<String>, more: Vec<String>) {
    for text in more {
        if !known.contains(&text) {
            known.push(text);
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn instruction_sets() -> Vec<String> {
    let known = [
        ("sse2", true),
        ("avx2", std::arch::is_x86_feature_detected!("avx2")),
        ("fma", std::arch::is_x86_feature_detected!("fma")),
        ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
    ];
    let found = known.iter().filter(|(_, there)| *there);
    found.map(|(name, _)| (*name).to_owned()).collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn instruction_sets() -> Vec<String> {
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(program: &str, started: u64) -> Entry {
        Entry {
            program: program.into(),
            machine: "machine".into(),
            ray_kernel: "kernel".into(),
            instruction_sets: Vec::new(),
            hidden_instruction_sets: Vec::new(),
            build: "release".into(),
            threads: 2,
            started_unix_seconds: started,
            last_started_unix_seconds: started,
            experiment: "x".into(),
            configs: vec![format!("{started}.toml")],
            overrides: Vec::new(),
        }
    }

    #[test]
    fn a_program_on_a_machine_has_one_entry_and_others_keep_theirs() {
        let mut all = Provenance::default();
        all.enter(entry("one", 5));
        all.enter(entry("two", 6));
        let other = Provenance {
            entries: vec![entry("one", 9), entry("one", 5)],
            ..Provenance::default()
        };
        all.unite(other);
        assert_eq!(all.entries.len(), 2);
        let one = &all.entries[0];
        let times = [one.started_unix_seconds, one.last_started_unix_seconds];
        assert_eq!(times, [5, 9]);
        assert_eq!(one.configs, ["5.toml", "9.toml"]);
        assert!(program().contains(env!("CARGO_PKG_VERSION")));
        assert!(machine().contains("threads"));
    }
}
