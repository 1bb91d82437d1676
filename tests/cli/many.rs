//! The scripts for many machines: shards that are killed and started again give the rows of a single run.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Command, Output};

use super::{Place, TINY, repository};

/// A batch system that runs everything at once, here, and starts a shard that failed again.
const SBATCH: &str = r#"#!/bin/bash
while [ $# -gt 0 ]; do
    case $1 in --array=*) array=${1#*=} ;; --wrap) wrap=$2; shift ;; esac
    shift
done
for task in ${array:+$(seq "${array%-*}" "${array#*-}")} ${array:-once}; do
    case $task in *-*) continue ;; esac
    export SLURM_ARRAY_TASK_ID=$task
    sh -c "$wrap" >>"tasks.log" 2>&1 || sh -c "$wrap" >>"tasks.log" 2>&1 || echo "failed: $task" >&2
done
echo "7;here"
"#;

/// The program, of which the second of three shards is killed at work the first time.
const KILLED_ONCE: &str = r#"#!/bin/bash
case "$*" in *"--shard 2/3"*)
    if mkdir killed 2>/dev/null; then
        PROGRAM "$@" & sleep 0.2; kill -9 $!; exit 137
    fi ;;
esac
exec PROGRAM "$@"
"#;

fn executable(place: &Place, name: &str, text: &str) -> PathBuf {
    let path = place.write(name, text);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("executable");
    path
}

/// A place with the tiny experiment run as a whole, and a program that is killed once.
fn prepared() -> (Place, PathBuf) {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let whole = place.lightbench(&["run", "tiny.toml", "--out", "whole/tiny"]);
    assert_eq!(whole.code, 0, "{}", whole.err);
    let program = env!("CARGO_BIN_EXE_lightbench");
    let text = KILLED_ONCE.replace("PROGRAM", &format!("'{program}'"));
    let program = executable(&place, "killed-once", &text);
    (place, program)
}

fn script(place: &Place, name: &str, program: &PathBuf) -> Output {
    let path = std::env::var("PATH").unwrap_or_default();
    Command::new("bash")
        .arg(repository(&format!("scripts/{name}")))
        .args(["3", "tiny.toml"])
        .current_dir(place.path())
        .env_remove("LIGHTBENCH_SCENES")
        .env("LIGHTBENCH", program)
        .env("THREADS", "1")
        .env("PATH", format!("{}:{path}", place.path().display()))
        .output()
        .expect("runs")
}

/// Rows by job: a merged folder has them shard by shard.
fn sorted(place: &Place, results: &str) -> Vec<String> {
    let rows = place.rows(results);
    let mut rows: Vec<String> = rows.iter().map(ToString::to_string).collect();
    rows.sort();
    rows
}

#[test]
fn a_slurm_array_gives_the_rows_of_a_single_run() {
    let (place, program) = prepared();
    executable(&place, "sbatch", SBATCH);
    let output = script(&place, "slurm-array.sh", &program);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && told.is_empty(), "{told}");
    assert!(place.path().join("killed").is_dir(), "one was killed");
    assert_eq!(sorted(&place, "results/tiny"), sorted(&place, "whole/tiny"));
}

#[test]
fn gnu_parallel_gives_the_rows_of_a_single_run() {
    let known = Command::new("parallel").arg("--version").output();
    if !known.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).contains("GNU parallel")) {
        eprintln!("skipped: GNU parallel is not installed");
        return;
    }
    let (place, program) = prepared();
    let first = script(&place, "parallel.sh", &program);
    let told = String::from_utf8_lossy(&first.stderr).into_owned();
    assert!(told.contains("run the same command again"), "{told}");
    let second = script(&place, "parallel.sh", &program);
    let told = String::from_utf8_lossy(&second.stderr).into_owned();
    assert!(second.status.success(), "{told}");
    assert_eq!(sorted(&place, "results/tiny"), sorted(&place, "whole/tiny"));
}
