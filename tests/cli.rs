//! The program from outside: exit codes, messages, resume, shards, determinism.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

#[path = "cli/damage.rs"]
mod damage;
#[path = "cli/explaining.rs"]
mod explaining;
#[path = "cli/folders.rs"]
mod folders;
#[path = "cli/gates.rs"]
mod gates;
#[path = "cli/inputs.rs"]
mod inputs;
#[cfg(unix)]
#[path = "cli/many.rs"]
mod many;
#[path = "cli/planning.rs"]
mod planning;
#[path = "cli/refused.rs"]
mod refused;
#[path = "cli/running.rs"]
mod running;
#[path = "cli/sequences.rs"]
mod sequences;
#[path = "cli/starting.rs"]
mod starting;

/// What differs from run to run: times, and memory as the allocator sees it.
const MEASURED: &[&str] = &[
    "seconds",
    "seconds_total",
    "cpu_seconds",
    "cpu_seconds_total",
    "serial_share",
    "bytes_scene",
    "bytes_work",
];

/// A small experiment on a scene of primitives, a second or two in a debug build.
const TINY: &str = r#"
name = "tiny"
technique = "ambient-occlusion"
parameters = { side = 8 }
caches = 60
size = [48, 27]
repeats = 2

[[scene]]
name = "hard-cases"
view = "poles"

[[method]]
id = "IM"
[[method]]
id = "VGC+DGS"

[[table]]
name = "errors"

[[claim]]
text = "clustering helps"
where = "nowhere"
expect = "rmse(VGC+DGS) < rmse(IM)"

[[gate]]
text = "bounded"
expect = "rmse(VGC+DGS) < 0.5"
"#;

/// A small experiment under a map, every image of the same time.
const TIMED: &str = r#"
name = "timed"
technique = "environment-lighting"
parameters = { reference_samples = 8, reference_passes = 2 }
seconds = 0.02
size = [24, 18]
environment = "living-room"

[[scene]]
name = "still-puzzle"

[[method]]
id = "mis"
[[method]]
id = "decomposition"
"#;

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("temporary folder"))
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path().join(name);
        fs::write(&path, text).expect("writable");
        path
    }

    fn lightbench(&self, arguments: &[&str]) -> Output {
        self.lightbench_by(None, arguments)
    }

    /// With a ray kernel of choice.
    fn lightbench_by(&self, kernel: Option<&str>, arguments: &[&str]) -> Output {
        let kernel = kernel.map(|name| ("LIGHTBENCH_KERNEL", name));
        self.lightbench_with(kernel, arguments)
    }

    /// With a variable of the environment.
    fn lightbench_with(&self, variable: Option<(&str, &str)>, arguments: &[&str]) -> Output {
        let output = Command::cargo_bin("lightbench")
            .expect("built")
            .current_dir(self.path())
            .env_remove("LIGHTBENCH_SCENES")
            .env_remove("LIGHTBENCH_KERNEL")
            .env_remove("LIGHTBENCH_HIDE")
            .envs(variable)
            .args(arguments)
            .output()
            .expect("runs");
        Output {
            code: output.status.code().expect("not killed"),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// Job folder name → bytes of its image.
    fn images(&self, results: &str) -> BTreeMap<String, Vec<u8>> {
        fs::read_dir(self.path().join(results).join("jobs"))
            .expect("jobs")
            .map(|entry| entry.expect("entry").path())
            .map(|path| {
                let name = path
                    .file_name()
                    .expect("name")
                    .to_string_lossy()
                    .into_owned();
                (name, fs::read(path.join("image.exr")).expect("image"))
            })
            .collect()
    }

    /// The rows without what depends on the machine's speed.
    fn rows(&self, results: &str) -> Vec<serde_json::Value> {
        let text = fs::read_to_string(self.path().join(results).join("rows.jsonl")).expect("rows");
        text.lines()
            .map(|line| {
                let mut row: serde_json::Value = serde_json::from_str(line).expect("json");
                for measured in MEASURED {
                    row[*measured] = serde_json::Value::Null;
                }
                row
            })
            .collect()
    }
}

struct Output {
    code: i32,
    out: String,
    err: String,
}

fn repository(path: &str) -> String {
    format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))
}
