//! Tells the program which commit it was built from (without git it knows its version alone), puts configs and
//! typefaces into it, and links it small.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=Cargo.toml");
    println!("cargo::rerun-if-changed=src");
    println!("cargo::rerun-if-changed=configs");
    list_configs();
    pack_typefaces();
    link_small();
    println!(
        "cargo::rustc-env=LIGHTBENCH_COMMIT={}",
        commit().unwrap_or_default()
    );
}

/// Writes the list of shipped configs, from which the program takes their texts: path below `configs/` without its
/// ending, and text.
fn list_configs() {
    let configs = variable("CARGO_MANIFEST_DIR").join("configs");
    let (mut folders, mut files) = (vec![configs.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of configs") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "toml") {
                files.push(path);
            }
        }
    }
    files.sort();
    let mut list = String::from("&[\n");
    for file in files {
        let name = file
            .strip_prefix(&configs)
            .expect("below it")
            .with_extension("");
        let name = name.to_str().expect("UTF-8").replace('\\', "/");
        let file = file.to_str().expect("UTF-8");
        list.push_str(&format!("    ({name:?}, include_str!({file:?})),\n"));
    }
    list.push_str("]\n");
    let place = variable("OUT_DIR").join("configs.rs");
    std::fs::write(place, list).expect("the list of configs is written");
}

fn variable(name: &str) -> PathBuf {
    PathBuf::from(std::env::var_os(name).expect("set by cargo"))
}

/// Writes the typefaces of figures, compressed to half their size.
fn pack_typefaces() {
    let faces = [
        ("UbuntuLight", epaint_default_fonts::UBUNTU_LIGHT),
        ("HackRegular", epaint_default_fonts::HACK_REGULAR),
    ];
    for (name, bytes) in faces {
        let place = variable("OUT_DIR").join(name);
        if !place.exists() {
            let mut packed =
                flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
            packed.write_all(bytes).expect("compresses");
            let packed = packed.finish().expect("compresses");
            std::fs::write(place, packed).expect("a typeface is written");
        }
    }
}

/// Asks the linker of a release to keep one of equal functions and to write relocations briefly, a megabyte together,
/// where a program linked so runs on this machine.
fn link_small() {
    if std::env::var_os("PROFILE").is_none_or(|profile| profile != "release") {
        return;
    }
    for argument in ["-Wl,--icf=all", "-Wl,-z,pack-relative-relocs"] {
        if runs_linked_with(argument).unwrap_or(false) {
            println!("cargo::rustc-link-arg-bins={argument}");
        }
    }
}

/// Whether a program that does nothing does so when it is linked with an argument.
fn runs_linked_with(argument: &str) -> Option<bool> {
    let source = variable("OUT_DIR").join("nothing.rs");
    let program = source.with_extension("program");
    std::fs::write(&source, "fn main() {}").ok()?;
    let flags = std::env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    let mut compiler = Command::new(variable("RUSTC"));
    compiler.args(flags.split('\u{1f}').filter(|flag| !flag.is_empty()));
    if let Ok(linker) = std::env::var("RUSTC_LINKER") {
        compiler.arg(format!("-Clinker={linker}"));
    }
    let target = variable("TARGET");
    compiler
        .arg("--target")
        .arg(target)
        .arg("-C")
        .arg(format!("link-arg={argument}"));
    compiler.arg("-o").arg(&program).arg(&source);
    let linked = compiler.output().ok()?.status.success();
    Some(linked && Command::new(&program).status().ok()?.success())
}

/// The commit's short name, with `modified` behind it if sources differ from it; `None` outside a
/// checkout of this very package.
fn commit() -> Option<String> {
    let folder = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR")?);
    let top = git(&["rev-parse", "--show-toplevel"])?;
    if Path::new(&top).canonicalize().ok()? != folder.canonicalize().ok()? {
        return None;
    }
    let branch = git(&["rev-parse", "--symbolic-full-name", "HEAD"]).unwrap_or_default();
    for name in ["HEAD", "logs/HEAD", "packed-refs", branch.as_str()] {
        let path = git(&["rev-parse", "--git-path", name]);
        // A path that is not there would have this run at every build.
        if let Some(path) = path.filter(|path| Path::new(path).is_file()) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let name = git(&["rev-parse", "--short=12", "HEAD"])?;
    let sources = [
        "diff",
        "--name-only",
        "HEAD",
        "--",
        "src",
        "Cargo.toml",
        "Cargo.lock",
    ];
    let modified = git(&sources).is_none_or(|files| !files.is_empty());
    Some(if modified {
        format!("{name} modified")
    } else {
        name
    })
}

/// What git says; `None` without git, or when it fails.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
