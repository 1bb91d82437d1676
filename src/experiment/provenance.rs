//! What made the results: program, machine, command.

use super::Plan;
use crate::trace::Kernel;

/// JSON text of `provenance.json`. Bit identity is promised for one instruction set and
/// one ray kernel, so both are in it.
pub fn collect(plan: &Plan) -> String {
    let started = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0, |d| d.as_secs());
    let record = serde_json::json!({
        "program": concat!("lightbench ", env!("CARGO_PKG_VERSION")),
        "architecture": std::env::consts::ARCH,
        "operating_system": std::env::consts::OS,
        "instruction_sets": instruction_sets(),
        "ray_kernel": Kernel::best().name(),
        "threads": rayon::current_num_threads(),
        "build": if cfg!(debug_assertions) { "debug" } else { "release" },
        "started_unix_seconds": started,
        "experiment": plan.name,
        "configs": plan.configs,
        "overrides": plan.overrides,
    });
    format!("{record:#}\n")
}

#[cfg(target_arch = "x86_64")]
fn instruction_sets() -> Vec<&'static str> {
    let mut found = vec!["sse2"];
    if std::arch::is_x86_feature_detected!("avx2") {
        found.push("avx2");
    }
    if std::arch::is_x86_feature_detected!("fma") {
        found.push("fma");
    }
    if std::arch::is_x86_feature_detected!("avx512f") {
        found.push("avx512f");
    }
    found
}

#[cfg(not(target_arch = "x86_64"))]
fn instruction_sets() -> Vec<&'static str> {
    Vec::new()
}
