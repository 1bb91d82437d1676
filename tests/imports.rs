//! Modules import downwards only: no top-level module reaches itself through others.

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
        for line in lines {
            for named in line.split("crate::").skip(1) {
                let is_word = |c: char| c.is_alphanumeric() || c == '_';
                let target: String = named.chars().take_while(|&c| is_word(c)).collect();
                if !target.is_empty() && target != own {
                    imports.entry(own.clone()).or_default().insert(target);
                }
            }
        }
    }
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
