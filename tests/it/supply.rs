//! What the program is built from and by: dependencies as `deny.toml` allows them, and the release workflow.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Runners that were taken out of service, by what their names begin with.
const RETIRED: [&str; 9] = [
    "macos-11",
    "macos-12",
    "macos-13",
    "macos-14",
    "ubuntu-18",
    "ubuntu-20",
    "windows-2016",
    "windows-2019",
    "macos-10",
];

fn read(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).expect(path)
}

/// Every `uses:` of a workflow: what is behind it, on its line.
fn actions(workflow: &str) -> Vec<&str> {
    let uses = |line: &&str| line.trim_start().trim_start_matches("- ").starts_with("uses:");
    let lines = workflow.lines().filter(uses);
    lines.filter_map(|line| Some(line.split_once("uses:")?.1.trim())).collect()
}

/// What is wrong with an action, if anything is: a tag may be moved to other code, a commit cannot.
fn unpinned(action: &str) -> Option<String> {
    let (place, version) = action.split_once(" # v").unwrap_or((action, ""));
    let commit = place.split_once('@').map_or("", |(_, commit)| commit.trim());
    let is_commit = commit.len() == 40 && commit.bytes().all(|b| b.is_ascii_hexdigit());
    let is_version = version.split('.').count() == 3;
    (!is_commit || !is_version)
        .then(|| format!("{action}: give the commit, and `# v1.2.3` behind it"))
}

/// The retired runners that a workflow asks for.
fn retired(workflow: &str) -> Vec<&str> {
    let words = workflow.lines().filter(|l| l.contains("os:") || l.contains("runs-on:"));
    let words = words.flat_map(|l| l.split(|c: char| !(c.is_alphanumeric() || "-.".contains(c))));
    words.filter(|word| RETIRED.iter().any(|old| word.starts_with(old))).collect()
}

#[test]
fn the_release_runs_where_there_are_runners_and_on_code_that_cannot_change() {
    let workflow = read(".github/workflows/release.yml");
    let all = actions(&workflow);
    assert!(all.len() >= 6, "{all:?}");
    let wrong: Vec<String> = all.iter().filter_map(|action| unpinned(action)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(retired(&workflow), Vec::<&str>::new());
    // what the tests above would say of the workflow as it was
    let old = "- { os: macos-13, target: x }\n- uses: actions/checkout@v4";
    assert_eq!((retired(old), actions(old).len()), (vec!["macos-13"], 1));
    assert!(actions(old).iter().all(|action| unpinned(action).is_some()));
}

/// Whether an SPDX expression is satisfied by licences that are allowed: `AND` binds more than `OR`.
fn is_allowed(expression: &str, allowed: &BTreeSet<String>) -> bool {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
    let tokens: Vec<&str> = spaced.split_whitespace().collect();
    let mut at = 0;
    let value = any(&tokens, &mut at, allowed);
    value && at == tokens.len()
}

fn any(tokens: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut value = all(tokens, at, allowed);
    while tokens.get(*at) == Some(&"OR") {
        *at += 1;
        value |= all(tokens, at, allowed);
    }
    value
}

fn all(tokens: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut value = one(tokens, at, allowed);
    while tokens.get(*at) == Some(&"AND") {
        *at += 1;
        value &= one(tokens, at, allowed);
    }
    value
}

fn one(tokens: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let Some(token) = tokens.get(*at) else { return false };
    *at += 1;
    if *token == "(" {
        let value = any(tokens, at, allowed);
        *at += usize::from(tokens.get(*at) == Some(&")"));
        return value;
    }
    let mut licence = (*token).to_owned();
    if let (Some(&"WITH"), Some(exception)) = (tokens.get(*at), tokens.get(*at + 1)) {
        licence += &format!(" WITH {exception}");
        *at += 2;
    }
    allowed.contains(&licence)
}

/// Every package that is built in, as cargo resolves it; without a network those of this platform.
fn packages() -> Vec<Value> {
    let metadata = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO"));
        command.current_dir(env!("CARGO_MANIFEST_DIR"));
        command.args([
            "metadata",
            "--format-version",
            "1",
            "--locked",
            "--all-features",
            "--offline",
        ]);
        command.args(more).output().expect("cargo runs")
    };
    let version = Command::new("rustc").arg("-vV").output().expect("rustc runs");
    let version = String::from_utf8(version.stdout).expect("text");
    let host = version.lines().find_map(|l| l.strip_prefix("host: ")).expect("a host");
    let mut output = metadata(&[]);
    if !output.status.success() {
        output = metadata(&["--filter-platform", host]);
    }
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut all: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let Value::Array(packages) = all["packages"].take() else { panic!("no packages") };
    packages
}

/// What `cargo deny check licenses bans sources` looks at, by the same file, where cargo-deny is not installed.
#[test]
fn dependencies_are_as_the_policy_allows() {
    let policy: toml::Table = read("deny.toml").parse().expect("TOML");
    let strings = |table: &str, key: &str| -> BTreeSet<String> {
        let list = policy[table][key].as_array().expect("a list");
        list.iter().map(|x| x.as_str().expect("a string").to_owned()).collect()
    };
    let (allowed, denied) = (strings("licenses", "allow"), strings("bans", "deny"));
    for (expression, want) in [
        ("MIT", true),
        ("MIT OR GPL-3.0", true),
        ("MIT AND GPL-3.0", false),
        ("(MIT OR GPL-3.0) AND Zlib", true),
        ("Apache-2.0 WITH LLVM-exception", true),
        ("MIT/Apache-2.0", true),
        ("", false),
    ] {
        assert_eq!(is_allowed(expression, &allowed), want, "{expression}");
    }
    let (mut seen, mut wrong, mut sources) = (0, Vec::new(), BTreeSet::new());
    for package in packages() {
        let name = package["name"].as_str().expect("a name");
        let Some(source) = package["source"].as_str() else { continue }; // ours
        seen += 1;
        let licence = package["license"].as_str().unwrap_or_default();
        if !is_allowed(licence, &allowed) {
            wrong.push(format!("{name}: licence `{licence}`"));
        }
        if denied.contains(name) {
            wrong.push(format!("{name}: banned"));
        }
        // the registry that cargo has without configuration, and no other beside it
        if !source.starts_with("registry+") {
            wrong.push(format!("{name}: from {source}"));
        }
        sources.insert(source.to_owned());
    }
    assert!(seen > 100, "{seen}");
    assert_eq!(sources.len(), 1, "{sources:?}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
