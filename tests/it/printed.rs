//! What README and book say the program prints is what it prints now.
//!
//! A block of a page that is fenced as `console` has commands behind `$ `, each with its output below it. Every such block
//! is run in one folder that has `fixtures/` and, where they are beside the repository, the real recordings as `kiro/`; the
//! same command runs once. In the output
//!
//! ```text
//! ...      on a line of its own stands for any lines, at a line's end for the rest of the line
//! [..]     stands for one word: durations, versions, platforms
//! ```
//!
//! and numbers may differ by 2 %, or in their last digit if they have decimals: machines round differently. A block that
//! cannot be run says why on its fence (`console not run: takes minutes`). `ROADBENCH_BLESS=1 cargo nextest run -E
//! 'test(printed::)'` writes the program's lines over those whose words are the same.
#![cfg(unix)]

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A block: the lines between its fences, from the first, and why it is not run.
struct Block {
    first: usize,
    lines: Vec<String>,
    not_run: Option<String>,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut found: Vec<Block> = Vec::new();
    let (mut inside, mut is_console) = (false, false);
    for (i, line) in page.lines().enumerate() {
        if let Some(fence) = line.strip_prefix("```") {
            inside = !inside;
            is_console = inside && fence.starts_with("console");
            if is_console {
                let not_run = fence.strip_prefix("console not run: ").map(str::to_owned);
                found.push(Block { first: i + 1, lines: Vec::new(), not_run });
            }
        } else if is_console && let Some(block) = found.last_mut() {
            block.lines.push(line.to_owned());
        }
    }
    found
}

/// The commands of a block: place of the first line of the output, and the output that is shown.
fn commands(block: &Block) -> Vec<(String, std::ops::Range<usize>)> {
    let mut all: Vec<(String, std::ops::Range<usize>)> = Vec::new();
    for (i, line) in block.lines.iter().enumerate() {
        if let Some(command) = line.strip_prefix("$ ") {
            all.push((command.to_owned(), i + 1..i + 1));
        } else if let Some((command, shown)) = all.last_mut() {
            if shown.start == shown.end && command.ends_with('\\') {
                command.push('\n');
                command.push_str(line);
                *shown = i + 1..i + 1;
            } else {
                shown.end = i + 1;
            }
        }
    }
    all
}

/// A word without the marks around it, if it is a number, and how many decimals it has.
fn number(word: &str) -> Option<(f64, usize)> {
    let bare = word.trim_matches(|c: char| !(c.is_ascii_digit() || c == '-'));
    let decimals = bare.split_once('.').map_or(0, |(_, d)| d.len());
    Some((bare.parse().ok()?, decimals))
}

fn is_same_word(shown: &str, printed: &str) -> bool {
    if shown == "[..]" || shown == printed {
        return true;
    }
    let (Some((a, digits)), Some((b, _))) = (number(shown), number(printed)) else { return false };
    let last = if digits > 0 { 1.01 * 0.1_f64.powi(digits as i32) } else { 0.0 };
    (a - b).abs() <= last + 0.02 * a.abs().max(b.abs())
}

fn is_same_kind(shown: &str, printed: &str) -> bool {
    is_same_word(shown, printed) || (number(shown).is_some() && number(printed).is_some())
}

fn is_same(shown: &str, printed: &str, word: fn(&str, &str) -> bool) -> bool {
    let (mut a, mut b) = (shown.split_whitespace(), printed.split_whitespace());
    loop {
        match (a.next(), b.next()) {
            (Some("..."), _) | (None, None) => return true,
            (Some(x), Some(y)) if word(x, y) => {}
            _ => return false,
        }
    }
}

/// The line of what is shown that the program does not print, if there is one.
fn difference(shown: &[String], printed: &[&str]) -> Option<usize> {
    let (mut at, mut open) = (0, false);
    for (i, line) in shown.iter().enumerate() {
        if line.trim() == "..." {
            open = true;
            continue;
        }
        let most = if open { printed.len() } else { printed.len().min(at + 1) };
        match (at..most).find(|k| is_same(line, printed[*k], is_same_word)) {
            Some(place) => (at, open) = (place + 1, false),
            None => return Some(i),
        }
    }
    let ends = open || printed[at..].iter().all(|line| line.trim().is_empty());
    (!ends).then_some(shown.len())
}

/// What is shown with the program's lines in place of those whose words are the same.
fn renewed(shown: &[String], printed: &[&str]) -> Vec<String> {
    let mut at = 0;
    let line = |line: &String| {
        let place = (at..printed.len()).find(|k| is_same(line, printed[*k], is_same_kind));
        let Some(place) = place.filter(|_| line.trim() != "...") else { return line.clone() };
        at = place + 1;
        match is_same(line, printed[place], is_same_word) || line.contains("[..]") {
            true => line.clone(),
            false if line.ends_with("...") => {
                let words = line.split_whitespace().count() - 1;
                let rest = printed[place].split_whitespace().nth(words);
                let cut = rest.and_then(|rest| printed[place].rfind(rest));
                format!("{}...", cut.map_or(printed[place], |cut| &printed[place][..cut]))
            }
            false => printed[place].trim_end().to_owned(),
        }
    };
    shown.iter().map(line).collect()
}

/// The folder in which all blocks run, and what their commands printed.
struct Place {
    folder: tempfile::TempDir,
    printed: HashMap<String, String>,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("folder");
        let link = |from: PathBuf, name: &str| {
            if from.exists() {
                std::os::unix::fs::symlink(from, folder.path().join(name)).expect(name);
            }
        };
        link(root().join("fixtures"), "fixtures");
        let recordings = root().join("../shared/data/emoto_kiro");
        link(recordings.canonicalize().unwrap_or(recordings), "kiro");
        Place { folder, printed: HashMap::new() }
    }

    /// What a command prints to stdout; the same command runs once.
    fn printed(&mut self, command: &str) -> String {
        if let Some(text) = self.printed.get(command) {
            return text.clone();
        }
        let binary = assert_cmd::cargo::cargo_bin("roadbench");
        let here = binary.parent().expect("a folder").to_string_lossy().into_owned();
        let path = format!("{here}:{}", std::env::var("PATH").unwrap_or_default());
        let output = Command::new("sh")
            .args(["-e", "-c", command])
            .current_dir(self.folder.path())
            .env("PATH", path)
            .output()
            .expect("a shell");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code().is_some_and(|code| code < 2), "{command}\n{error}");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        self.printed.insert(command.to_owned(), text.clone());
        text
    }
}

fn pages() -> Vec<PathBuf> {
    let book = walkdir::WalkDir::new(root().join("book/src")).sort_by_file_name();
    let book = book.into_iter().map(|entry| entry.expect("entry").into_path());
    let is_page = |path: &PathBuf| path.extension().is_some_and(|e| e == "md");
    std::iter::once(root().join("README.md")).chain(book.filter(is_page)).collect()
}

#[test]
fn what_the_pages_show_is_what_the_program_prints() {
    let mut place = Place::new();
    let (mut ran, mut left, mut wrong) = (0, 0, Vec::new());
    for path in pages() {
        let page = std::fs::read_to_string(&path).expect("page");
        let name = path.strip_prefix(root()).expect("below").display().to_string();
        let mut lines: Vec<String> = page.lines().map(str::to_owned).collect();
        for block in blocks(&page) {
            let needs = block.lines.iter().any(|l| l.contains("kiro/"));
            let absent = needs && !place.folder.path().join("kiro").exists();
            let absent = absent.then(|| "there are no recordings beside the repository".to_owned());
            if let Some(why) = block.not_run.clone().or(absent) {
                println!("{name}, line {}: not run: {why}", block.first);
                left += 1;
                continue;
            }
            let all = commands(&block);
            assert!(!all.is_empty(), "{name}, line {}: no command (`$ ...`)", block.first);
            for (command, shown) in all {
                let text = place.printed(&command);
                let printed: Vec<&str> = text.lines().collect();
                ran += 1;
                if std::env::var_os("ROADBENCH_BLESS").is_some() {
                    let new = renewed(&block.lines[shown.clone()], &printed);
                    lines.splice(block.first + shown.start..block.first + shown.end, new.clone());
                    if let Some(i) = difference(&new, &printed) {
                        wrong.push(format!("{name}: {command}: cannot renew {:?}", new.get(i)));
                    }
                } else if let Some(i) = difference(&block.lines[shown.clone()], &printed) {
                    let line = block.lines[shown].get(i).map_or("the end", String::as_str);
                    wrong.push(format!("{name}: `{command}` does not print: {line}\n{text}"));
                }
            }
        }
        if std::env::var_os("ROADBENCH_BLESS").is_some() {
            std::fs::write(&path, lines.join("\n") + "\n").expect("written");
        }
    }
    println!("{ran} commands of the pages compared, {left} blocks not run");
    assert!(wrong.is_empty(), "ROADBENCH_BLESS=1 renews numbers:\n{}", wrong.join("\n"));
    assert!(ran >= 6, "{ran}");
}

#[test]
fn other_numbers_and_words_are_seen() {
    let printed = ["head 1", "peak_slip  0.2143 ± 0.0096", "25 of 37 determined", "took 3.2 s"];
    let same = |shown: &[&str]| {
        let shown: Vec<String> = shown.iter().map(|s| (*s).to_owned()).collect();
        difference(&shown, &printed).is_none()
    };
    assert!(same(&["head 1", "peak_slip 0.2144 ± 0.0097", "25 of 37 determined", "took [..] s"]));
    assert!(same(&["...", "25 of 37 ...", "..."]));
    assert!(same(&["head 1", "..."]));
    for wrong in [
        &["...", "peak_slip 0.2243 ± 0.0096", "..."][..],
        &["...", "21 of 37 determined", "..."],
        &["...", "slip_peak 0.2143 ± 0.0096", "..."],
        &["head 1", "25 of 37 determined", "..."],
        &["head 1"],
        &["...", "no such line", "..."],
    ] {
        assert!(!same(wrong), "{wrong:?}");
    }
    let page = "x\n```console\n$ a \\\nb\none\n$ c\n```\n```console not run: slow\n$ d\n```\n";
    let found = blocks(page);
    let all = commands(&found[0]);
    assert_eq!((all.len(), all[0].0.as_str(), all[0].1.clone()), (2, "a \\\nb", 2..3));
    assert_eq!((all[1].1.len(), found[1].not_run.as_deref()), (0, Some("slow")));
    let shown = ["peak_slip 0.3012 ± 0.0140".to_owned(), "...".to_owned()];
    assert_eq!(renewed(&shown, &printed)[0], printed[1]);
}
