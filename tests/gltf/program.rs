//! Bad files from outside: exit code 2, a message with file and place, and nothing written.

use assert_cmd::Command;
use serde_json::json;

use crate::builder::File;

#[test]
fn bad_files_stop_every_verb_before_anything_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let bad = File::triangle()
        .with("/accessors/0/count", json!(99))
        .text();
    std::fs::write(folder.path().join("bad.gltf"), bad).expect("writable");
    let config = "name = \"x\"\ntechnique = \"ambient-occlusion\"\ncaches = 10\nsize = [8, 8]\n\
                  [[scene]]\nname = \"./bad.gltf\"\n[[method]]\nid = \"IM\"\n";
    std::fs::write(folder.path().join("x.toml"), config).expect("writable");
    let out = out.to_string_lossy();
    for arguments in [
        vec!["scene", "check", "./bad.gltf"],
        vec!["render", "./bad.gltf", "--out", "image.exr"],
        vec!["plan", "x.toml"],
        vec!["run", "x.toml", "--out", &out],
    ] {
        let mut command = Command::cargo_bin("lightbench").expect("built");
        let ran = command
            .current_dir(folder.path())
            .args(&arguments)
            .output()
            .expect("runs");
        let told = String::from_utf8_lossy(&ran.stderr).into_owned();
        assert_eq!(ran.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(
            told.contains("bad.gltf: accessor 0: reaches beyond"),
            "{told}"
        );
    }
    let left = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 2, "nothing is written");
}
