//! The order of the house: modules import downwards only, so that no top-level module reaches itself through others; each
//! says what it is; `unsafe` is in few of them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Modules that each top-level module names as `crate::…`, tests left out.
type Imports = BTreeMap<String, BTreeSet<String>>;

fn read(folder: &Path, module: Option<&str>, imports: &mut Imports) {
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .expect("a folder of sources")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    for path in paths {
        let name = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        let own = module.unwrap_or(&name).to_owned();
        if name.contains("tests") || (module.is_none() && (name == "lib" || name == "main")) {
            continue;
        }
        if path.is_dir() {
            read(&path, Some(&own), imports);
            continue;
        }
        if path.extension().is_none_or(|ending| ending != "rs") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("UTF-8");
        let code = text
            .split("#[cfg(test)]\nmod tests {")
            .next()
            .unwrap_or_default();
        let lines = code
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"));
        let code = lines.collect::<Vec<_>>().join("\n");
        for target in targets(&code) {
            if target != own {
                imports.entry(own.clone()).or_default().insert(target);
            }
        }
    }
}

/// The modules that stand behind each `crate::`, alone or in braces.
fn targets(code: &str) -> Vec<String> {
    let first_word = |text: &str| -> String {
        let is_word = |c: &char| c.is_alphanumeric() || *c == '_';
        text.trim_start().chars().take_while(is_word).collect()
    };
    let mut targets = Vec::new();
    for named in code.split("crate::").skip(1) {
        let Some(group) = named.strip_prefix('{') else {
            targets.push(first_word(named));
            continue;
        };
        let (mut start, mut depth) = (0, 1);
        for (at, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if depth == 0 || depth == 1 && c == ',' {
                targets.push(first_word(&group[start..at]));
                start = at + 1;
            }
            if depth == 0 {
                break;
            }
        }
    }
    targets.retain(|target| !target.is_empty());
    targets
}

#[test]
fn imports_in_braces_are_read() {
    let code =
        "use crate::{a::{b, c}, d,\n    e::f};\nuse crate::g::{h, i};\nlet x = crate::j::k();";
    assert_eq!(targets(code), ["a", "d", "e", "g", "j"]);
    assert!(targets("pub(crate) use a::b;").is_empty());
}

#[test]
fn no_module_reaches_itself_through_others() {
    let mut imports = Imports::new();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    read(&source, None, &mut imports);
    assert!(imports["technique"].contains("cache"), "imports are found");
    for start in imports.keys() {
        let mut open = vec![vec![start.clone()]];
        let mut seen = BTreeSet::new();
        while let Some(way) = open.pop() {
            for next in imports.get(&way[way.len() - 1]).into_iter().flatten() {
                assert!(next != start, "{} → {start}", way.join(" → "));
                if seen.insert(next.clone()) {
                    open.push([way.clone(), vec![next.clone()]].concat());
                }
            }
        }
    }
}

/// Name below `src` and text of every source file.
fn sources() -> Vec<(String, String)> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut folders, mut files) = (vec![source.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder of sources") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let name = path.strip_prefix(&source).expect("below it");
                let name = name.to_string_lossy().replace('\\', "/");
                files.push((name, std::fs::read_to_string(&path).expect("UTF-8")));
            }
        }
    }
    files
}

#[test]
fn unsafe_code_is_in_ray_kernels_calls_by_instruction_set_and_the_advice_on_memory() {
    for (name, text) in sources() {
        let allowed =
            name.starts_with("trace/") || ["instructions.rs", "memory.rs"].contains(&name.as_str());
        let mut code = text.lines().filter(|l| !l.trim_start().starts_with("//"));
        let is_unsafe = |line: &str| line.contains("unsafe {") || line.contains("unsafe fn");
        assert!(allowed || !code.any(is_unsafe), "{name}");
    }
}

#[test]
fn every_module_says_what_it_is() {
    for (name, text) in sources() {
        let is_test = name.contains("tests");
        assert!(is_test || text.starts_with("//!"), "{name} has no `//!`");
    }
}
