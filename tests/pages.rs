//! README and docs against the program: examples that work, links that lead somewhere, numbers of published tables.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;

#[path = "../examples/headline.rs"]
mod headline;

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(name: &str) -> String {
    let text = fs::read_to_string(repository().join(name));
    text.unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Whether pages are to be written anew.
fn blesses() -> bool {
    std::env::var_os("LIGHTBENCH_BLESS").is_some()
}

/// Names of the Markdown files of a folder, from the repository.
fn pages_in(folder: &str) -> Vec<String> {
    let entries = fs::read_dir(repository().join(folder)).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name());
    let names = names.map(|name| format!("{folder}/{}", name.to_string_lossy()));
    let mut pages: Vec<String> = names.filter(|name| name.ends_with(".md")).collect();
    pages.sort();
    pages
}

fn all_pages() -> Vec<String> {
    let folders = ["docs", "results/published"].map(pages_in).concat();
    [vec!["README.md".to_owned()], folders].concat()
}

/// The first block of a language after a heading.
fn block<'a>(page: &'a str, heading: &str, language: &str) -> &'a str {
    let section = page.split(&format!("{heading}\n")).nth(1);
    let section = section.unwrap_or_else(|| panic!("no heading `{heading}`"));
    let block = section.split(&format!("```{language}\n")).nth(1);
    let block = block.and_then(|rest| rest.split("```").next());
    block.unwrap_or_else(|| panic!("{heading}: no block of {language}"))
}

/// Runs the program in a folder; what it says where it fails.
fn lightbench(folder: &Path, arguments: &[&str]) -> Result<String, String> {
    let output = Command::cargo_bin("lightbench")
        .expect("built")
        .current_dir(folder)
        .env_remove("LIGHTBENCH_SCENES")
        .args(arguments)
        .output()
        .expect("runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    match output.status.success() {
        true => Ok(text(&output.stdout)),
        false => Err(text(&output.stderr)),
    }
}

#[test]
fn the_readme_is_read_in_a_minute() {
    let readme = read("README.md");
    assert!(readme.lines().count() <= 150);
    for line in readme.lines() {
        let columns = line.chars().count();
        assert!(columns <= 120, "{columns} columns: {line}");
    }
    for page in pages_in("docs") {
        assert!(readme.contains(&page), "README has no link to {page}");
    }
}

#[test]
fn the_scene_and_the_experiment_of_the_readme_work() {
    let readme = read("README.md");
    let place = tempfile::tempdir().expect("a folder");
    let scene = block(&readme, "## Your scene", "toml");
    let experiment = block(&readme, "## Your experiment", "toml");
    assert_eq!(scene.lines().count(), 12);
    assert_eq!(experiment.lines().count(), 20);
    fs::write(place.path().join("my-scene.toml"), scene).expect("written");
    fs::write(place.path().join("my-test.toml"), experiment).expect("written");
    let checked = lightbench(place.path(), &["scene", "check", "my-scene.toml"]);
    let checked = checked.expect("a scene");
    assert!(checked.contains("triangles"), "{checked}");
    let small = ["size=[32,18]", "caches=60", "parameters.side=8"];
    let run = [&["run", "my-test.toml"], small.as_slice()].concat();
    let told = lightbench(place.path(), &run).expect("an experiment");
    assert!(told.contains("ours has the smaller error"), "{told}");
    for file in ["report.html", "rows.csv", "tables/errors.md", "plan.json"] {
        let file = place.path().join("results/my-test").join(file);
        assert!(file.is_file(), "{}", file.display());
    }
}

#[test]
fn the_experiment_of_the_page_on_ci_plans_and_its_verbs_are_there() {
    let page = read("docs/ci.md");
    let place = tempfile::tempdir().expect("a folder");
    let experiment = block(&page, "# Gating a pull request", "toml");
    fs::write(place.path().join("quality.toml"), experiment).expect("written");
    let plan = lightbench(place.path(), &["plan", "quality.toml"]).expect("a plan");
    assert!(plan.contains("quality: 20 jobs"), "{plan}");
    for used in page.split("target/release/lightbench ").skip(1) {
        let verb = used.split(' ').next().unwrap_or_default();
        let help = lightbench(place.path(), &[verb, "--help"]);
        assert!(help.is_ok(), "{verb}");
    }
}

/// Text without blocks and spans of code, in which brackets are no links.
fn prose(page: &str) -> String {
    let outside = page.split("```").step_by(2).collect::<String>();
    outside.split('`').step_by(2).collect()
}

/// What a heading is called in links.
fn anchor(heading: &str) -> String {
    let kept = heading
        .trim_start_matches('#')
        .trim()
        .to_lowercase()
        .replace(' ', "-");
    kept.chars()
        .filter(|c| c.is_alphanumeric() || "-_".contains(*c))
        .collect()
}

#[test]
fn links_lead_somewhere() {
    let mut links = 0;
    for page in all_pages() {
        let text = read(&page);
        let folder = repository().join(&page);
        let folder = folder.parent().expect("a folder");
        for rest in prose(&text).split("](").skip(1) {
            let target = rest.split([')', ' ', '\n']).next().unwrap_or_default();
            if target.contains("://") || target.is_empty() {
                continue;
            }
            links += 1;
            let (file, part) = target.split_once('#').unwrap_or((target, ""));
            let file = match file.is_empty() {
                true => repository().join(&page),
                false => folder.join(file),
            };
            assert!(file.exists(), "{page}: {target}");
            if !part.is_empty() {
                let text = fs::read_to_string(&file).expect("a page");
                let mut headings = text.lines().filter(|line| line.starts_with('#'));
                assert!(headings.any(|h| anchor(h) == part), "{page}: {target}");
            }
        }
    }
    assert!(links > 50, "{links}");
}

#[test]
fn configs_that_pages_name_are_there() {
    let mut named = 0;
    for page in all_pages() {
        for rest in read(&page).split("configs/").skip(1) {
            let is_part = |c: char| c.is_alphanumeric() || "-_./".contains(c);
            let path: String = rest.chars().take_while(|&c| is_part(c)).collect();
            if path.ends_with(".toml") {
                named += 1;
                let file = repository().join("configs").join(&path);
                assert!(file.is_file(), "{page}: configs/{path}");
            }
        }
        // Shipped configs by name, in commands.
        for rest in read(&page).split("`lightbench run ").skip(1) {
            let name = rest.split([' ', '`', '\n']).next().unwrap_or_default();
            if name.contains(|c: char| !(c.is_alphanumeric() || "-_/.".contains(c)))
                || name.starts_with(char::is_uppercase)
                || name.starts_with("my-")
            {
                continue;
            }
            named += 1;
            let place = tempfile::tempdir().expect("a folder");
            let plan = lightbench(place.path(), &["plan", name]);
            assert!(plan.is_ok(), "{page}: {name}: {}", plan.unwrap_err());
        }
    }
    assert!(named > 20, "{named}");
}

#[test]
fn published_tables_are_listed_with_command_and_commit() {
    let results = read("docs/results.md");
    for page in pages_in("results/published") {
        let line = results
            .lines()
            .find(|l| l.contains(&format!("](../{page}) |")));
        let line = line.unwrap_or_else(|| panic!("docs/results.md does not list {page}"));
        assert!(line.contains("| `run "), "{line}");
    }
}

/// Commands of published tables are planned with their overrides, those whose scenes or maps are in the program.
#[test]
fn commands_of_published_tables_plan_with_their_overrides() {
    let results = read("docs/results.md");
    let commands = results.lines().filter_map(|line| {
        let command = line.strip_prefix("| [")?.split("| `run ").nth(1)?;
        Some(command.split('`').next().unwrap_or_default())
    });
    let mut commands: Vec<&str> = commands.collect();
    commands.sort_unstable();
    commands.dedup();
    let place = tempfile::tempdir().expect("a folder");
    let mut planned = 0;
    for command in commands {
        if command.ends_with('…') {
            println!("skipped, as it is cut short: {command}");
            continue;
        }
        let arguments: Vec<&str> = ["plan"].into_iter().chain(command.split(' ')).collect();
        match lightbench(place.path(), &arguments) {
            Ok(_) => planned += 1,
            Err(why) if why.contains("Set LIGHTBENCH_SCENES") => {
                println!("skipped, as its scenes are in LIGHTBENCH_SCENES: {command}");
            }
            Err(why) => panic!("run {command}: {why}"),
        }
    }
    assert!(planned > 20, "{planned}");
}

/// Puts text between two marks of a page: compares, or blesses.
fn between(page: &str, start: &str, end: &str, text: &str, advice: &str) {
    let written = read(page);
    let (before, rest) = written.split_once(start).expect("a first mark");
    let (_, after) = rest.split_once(end).expect("a second mark");
    let wanted = format!("{before}{start}\n{text}\n{end}{after}");
    if blesses() && wanted != written {
        fs::write(repository().join(page), &wanted).expect("writable");
    } else {
        assert!(wanted == written, "{page} differs: {advice}");
    }
}

#[test]
fn headlines_are_cells_of_published_tables() {
    let lines = headline::lines(&repository().join("results/published"));
    let lines = lines.expect("every cell is there");
    assert!(lines.len() >= 6);
    between(
        "README.md",
        "<!-- headlines: from results/published/headlines.txt -->",
        "<!-- end -->",
        &lines.join("\n"),
        "LIGHTBENCH_BLESS=1 cargo test --test pages",
    );
}

#[test]
fn worked_examples_are_those_that_are_compiled() {
    let files = [
        "src/placement/example.rs",
        "src/environment/example.rs",
        "src/technique/example_contender.rs",
        "src/technique/example_technique.rs",
    ];
    for file in files {
        let source = read(file);
        let code = source.split("\n#[cfg(test)]\nmod tests").next();
        let code = code.unwrap_or_default().trim_end();
        between(
            "docs/adding.md",
            &format!("<!-- {file} -->"),
            "<!-- end -->",
            &format!("```rust\n{code}\n```"),
            "LIGHTBENCH_BLESS=1 cargo test --test pages",
        );
    }
}

#[test]
fn files_of_scripts_and_pages_exist() {
    for name in [
        "scripts/slurm-array.sh",
        "scripts/parallel.sh",
        "docs/ci.md",
    ] {
        assert!(PathBuf::from(repository()).join(name).is_file(), "{name}");
    }
}
