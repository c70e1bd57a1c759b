//! The rooms of the architecture: which folder of `src` may use which, and that no file leads back to itself.
//!
//! The order of the rooms is written once, in `src/lib.rs`, from the ground up. Arrows are read from the
//! source: `use` items, paths in code and in macros, without `#[cfg(test)]`. The page of the architecture in the
//! book is drawn from the same arrows: `ROADBENCH_BLESS=1 cargo nextest run -E 'test(rooms::)'` writes it.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use syn::visit::Visit;

/// A module as the segments of its path below the crate.
type Module = Vec<String>;

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Every module that is a file, by its path below the crate, with its text.
fn modules() -> BTreeMap<Module, String> {
    let root = source();
    let files = walkdir::WalkDir::new(&root).sort_by_file_name().into_iter();
    files
        .map(|entry| entry.expect("src is readable").into_path())
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .filter(|path| !["lib.rs", "main.rs", "internals.rs"].iter().any(|n| *path == root.join(n)))
        .map(|path| {
            let below = path.strip_prefix(&root).expect("below src").with_extension("");
            let mut module: Module =
                below.iter().map(|s| s.to_string_lossy().into_owned()).collect();
            if module.last().is_some_and(|m| m == "mod") {
                module.pop();
            }
            (module, std::fs::read_to_string(&path).expect("UTF-8"))
        })
        .collect()
}

/// The rooms from the ground up: the modules of `src/lib.rs` in their order.
fn rooms() -> Vec<String> {
    let text = std::fs::read_to_string(source().join("lib.rs")).expect("lib.rs");
    let file = syn::parse_file(&text).expect("lib.rs is Rust");
    file.items
        .iter()
        .filter_map(|item| match item {
            syn::Item::Mod(m) if m.content.is_none() && m.ident != "internals" => {
                Some(m.ident.to_string())
            }
            _ => None,
        })
        .collect()
}

/// Collects the paths that a file names.
struct Paths {
    found: BTreeSet<Vec<String>>,
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|a| {
        a.path().is_ident("cfg")
            && matches!(&a.meta, syn::Meta::List(l) if l.tokens.to_string() == "test")
    })
}

impl Paths {
    fn tree(&mut self, before: &[String], tree: &syn::UseTree) {
        let with = |name: String| {
            let mut path = before.to_vec();
            path.push(name);
            path
        };
        match tree {
            syn::UseTree::Path(p) => self.tree(&with(p.ident.to_string()), &p.tree),
            syn::UseTree::Group(g) => g.items.iter().for_each(|t| self.tree(before, t)),
            syn::UseTree::Name(n) => drop(self.found.insert(with(n.ident.to_string()))),
            syn::UseTree::Rename(r) => drop(self.found.insert(with(r.ident.to_string()))),
            syn::UseTree::Glob(_) => drop(self.found.insert(before.to_vec())),
        }
    }
}

impl<'ast> Visit<'ast> for Paths {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            syn::visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if !is_test(&item.attrs) {
            self.tree(&[], &item.tree);
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if !is_test(&item.attrs) {
            syn::visit::visit_item_fn(self, item);
        }
    }

    /// `pub(super)` says who may use an item, not what it uses.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.found.insert(path.segments.iter().map(|s| s.ident.to_string()).collect());
        syn::visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, mac: &'ast syn::Macro) {
        // what a macro is given is tokens only: `crate :: a :: b`
        let text = mac.tokens.to_string();
        let words: Vec<&str> = text.split_whitespace().collect();
        let mut i = 0;
        while i < words.len() {
            let ident = |w: &str| w.chars().all(|c| c.is_alphanumeric() || c == '_');
            let mut path = vec![words[i].trim_start_matches(['(', '&', '*', '!']).to_owned()];
            while ident(path.last().map_or("", String::as_str))
                && words.get(i + 1) == Some(&"::")
                && words.get(i + 2).is_some_and(|w| w.starts_with(|c: char| c.is_alphabetic()))
            {
                let word = words[i + 2];
                let end = word.find(|c: char| !(c.is_alphanumeric() || c == '_'));
                path.push(word[..end.unwrap_or(word.len())].to_owned());
                i += 2;
            }
            if path.len() > 1 {
                self.found.insert(path);
            }
            i += 1;
        }
        syn::visit::visit_macro(self, mac);
    }
}

/// The files that a file uses, as modules.
fn uses(module: &Module, text: &str, all: &BTreeMap<Module, String>) -> BTreeSet<Module> {
    let file = syn::parse_file(text).unwrap_or_else(|e| panic!("{}: {e}", module.join("/")));
    let mut paths = Paths { found: BTreeSet::new() };
    paths.visit_file(&file);
    paths
        .found
        .iter()
        .filter_map(|path| resolve(module, path, all))
        .filter(|m| m != module)
        .collect()
}

/// The innermost file that a path leads through, if it stays in the crate.
fn resolve(here: &Module, path: &[String], all: &BTreeMap<Module, String>) -> Option<Module> {
    let mut at = here.clone();
    let rest = match path[0].as_str() {
        "crate" => {
            at.clear();
            &path[1..]
        }
        "self" => &path[1..],
        "super" => {
            let up = path.iter().take_while(|s| *s == "super").count();
            at.truncate(at.len().checked_sub(up)?);
            &path[up..]
        }
        child => {
            at.push(child.to_owned());
            if !all.contains_key(&at) {
                return None;
            }
            &path[1..]
        }
    };
    for segment in rest {
        at.push(segment.clone());
        if !all.contains_key(&at) {
            at.pop();
            break;
        }
    }
    (!at.is_empty()).then_some(at)
}

/// Every arrow between files.
fn arrows(all: &BTreeMap<Module, String>) -> BTreeMap<Module, BTreeSet<Module>> {
    all.iter().map(|(module, text)| (module.clone(), uses(module, text, all))).collect()
}

/// Arrows that lead up, as sentences.
fn upward(arrows: &BTreeMap<Module, BTreeSet<Module>>, rooms: &[String]) -> Vec<String> {
    let floor = |m: &Module| rooms.iter().position(|r| *r == m[0]);
    let mut out = Vec::new();
    for (from, to) in arrows {
        for to in to.iter().filter(|to| floor(from) < floor(to)) {
            out.push(format!("{} uses {}, which is above it", from.join("/"), to.join("/")));
        }
    }
    out
}

/// The shortest way from a file back to itself, for every circle one.
fn circles(arrows: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<String> {
    let mut out = Vec::new();
    let mut known: BTreeSet<&Module> = BTreeSet::new();
    for start in arrows.keys() {
        // breadth first: the way by which each file was reached
        let mut from: BTreeMap<&Module, &Module> = BTreeMap::new();
        let mut queue = std::collections::VecDeque::from([start]);
        while let Some(at) = queue.pop_front() {
            for next in arrows.get(at).into_iter().flatten() {
                if from.contains_key(next) {
                    continue;
                }
                from.insert(next, at);
                queue.push_back(next);
            }
        }
        if !from.contains_key(start) || known.contains(start) {
            continue;
        }
        let mut way = vec![start];
        let mut at = from[start];
        while at != start {
            way.push(at);
            at = from[at];
        }
        known.extend(&way);
        way.push(start);
        let names: Vec<String> = way.iter().rev().map(|m| m.join("/")).collect();
        out.push(names.join(" -> "));
    }
    out
}

#[test]
fn every_room_stands_in_the_order() {
    let (rooms, all) = (rooms(), modules());
    let found: BTreeSet<&String> = all.keys().map(|m| &m[0]).collect();
    assert_eq!(found, rooms.iter().collect());
    assert!(rooms.len() > 10 && all.len() > 300, "{} rooms, {} files", rooms.len(), all.len());
}

/// The Python module, the program and the examples of the book need the interface only.
#[test]
fn the_interface_serves_python_the_program_and_the_examples() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = walkdir::WalkDir::new(root.join("python/src"));
    let files = python.into_iter().map(|entry| entry.expect("readable").into_path());
    let examples = ["read_log", "fit_ride", "export_tyre"];
    let examples = examples.map(|name| root.join("examples").join(name).with_extension("rs"));
    let files = files.filter(|f| f.is_file()).chain(examples).chain([source().join("main.rs")]);
    for file in files {
        let text = std::fs::read_to_string(&file).expect("UTF-8");
        assert!(text.contains("roadbench") || text.contains("pyo3"), "{}", file.display());
        assert!(!text.contains("internals"), "{} uses internals", file.display());
    }
}

/// Fuzz targets are a workspace of their own that no test compiles: what they import is in the list of `internals`.
#[test]
fn fuzz_targets_import_what_there_is() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let list = std::fs::read_to_string(source().join("internals.rs")).expect("UTF-8");
    let mut imports = 0;
    for file in std::fs::read_dir(root.join("fuzz/fuzz_targets")).expect("targets") {
        let text = std::fs::read_to_string(file.expect("a target").path()).expect("UTF-8");
        for line in text.lines().filter_map(|l| l.strip_prefix("use roadbench::")) {
            let path = line.strip_prefix("internals::").expect("through internals");
            let path = path.trim_end_matches(';').split(" as ").next().unwrap_or_default();
            let name = path.rsplit("::").next().unwrap_or_default();
            let words = list.split(|c: char| !(c.is_alphanumeric() || c == '_'));
            assert!(words.into_iter().any(|word| word == name), "{line} is not in internals.rs");
            imports += 1;
        }
    }
    assert!(imports > 5, "{imports}");
}

/// All tests of the imports in one: to read them takes longer than everything else.
#[test]
fn imports_lead_down_and_are_those_of_the_page() {
    let (rooms, all) = (rooms(), modules());
    let arrows = arrows(&all);
    no_arrow_leads_up_and_no_file_back_to_itself(&rooms, &arrows);
    planted_arrows_are_found(&rooms, &all, &arrows);
    the_page_of_the_house_is_drawn_from_the_arrows(&rooms, &all, &arrows);
}

type Files = BTreeMap<Module, String>;
type Arrows = BTreeMap<Module, BTreeSet<Module>>;

fn no_arrow_leads_up_and_no_file_back_to_itself(rooms: &[String], arrows: &Arrows) {
    let (up, back) = (upward(arrows, rooms), circles(arrows));
    assert!(
        up.is_empty() && back.is_empty(),
        "{} arrows lead up:\n{}\n{} circles:\n{}",
        up.len(),
        up.join("\n"),
        back.len(),
        back.join("\n")
    );
}

/// What is said of arrows above can fail: planted ones of every shape are found.
fn planted_arrows_are_found(rooms: &[String], clean: &Files, known: &Arrows) {
    let (ground, top) = (&rooms[0], &rooms[rooms.len() - 2]);
    let file = clean.keys().find(|m| m[0] == *ground && m.len() == 2).expect("a file").clone();
    let with = |file: &Module, planted: &str| {
        let text = format!("{}\n{planted}", clean[file]);
        (file.clone(), uses(file, &text, clean))
    };
    let up = |planted: &str| {
        let mut arrows = known.clone();
        arrows.extend([with(&file, planted)]);
        upward(&arrows, rooms).len()
    };
    let before = up("");
    for planted in [
        format!("use crate::{top};"),
        format!("use crate::{{{ground}, {top}::main}};"),
        format!("fn f() {{ crate::{top}::main(); }}"),
        format!("fn f() {{ println!(\"{{}}\", crate::{top}::main()); }}"),
        format!("use super::super::{top};"),
    ] {
        assert_eq!(up(&planted), before + 1, "not found: {planted}");
    }
    let test_only = format!("#[cfg(test)]\nmod planted {{ use crate::{top}; }}");
    assert_eq!(up(&test_only), before, "tests may use what they like");

    let other = clean.keys().rfind(|m| m[0] == *ground && m.len() == 2).expect("a file").clone();
    let mut arrows = known.clone();
    arrows.extend([
        with(&file, &format!("use super::{};", other[1])),
        with(&other, &format!("use super::{};", file[1])),
    ]);
    let found = circles(&arrows);
    let named = |c: &String| c.contains(&file.join("/")) && c.contains(&other.join("/"));
    assert!(found.iter().any(named), "a planted circle is not found: {found:?}");
}

/// First sentence of a room's own documentation.
fn purpose(text: &str) -> String {
    let lines: Vec<&str> = text
        .lines()
        .take_while(|l| l.starts_with("//!"))
        .map(|l| l.trim_start_matches("//!").trim())
        .take_while(|l| !l.is_empty())
        .collect();
    let whole = lines.join(" ");
    let end = whole.find(". ").map_or(whole.len(), |k| k + 1);
    whole[..end].trim_end_matches('.').replace(['[', ']', '`'], "").replace("mod@", "")
}

/// Rooms as floors, arrows as arcs from a room down to those it uses.
fn drawing(
    rooms: &[String],
    all: &BTreeMap<Module, String>,
    arrows: &BTreeMap<Module, BTreeSet<Module>>,
) -> String {
    const FLOOR: f64 = 30.0;
    const LEFT: f64 = 12.0;
    const RIGHT: f64 = 250.0;
    let mut between: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let floor = |m: &Module| rooms.iter().position(|r| *r == m[0]).expect("a room");
    for (from, to) in arrows {
        for to in to.iter().filter(|to| to[0] != from[0]) {
            *between.entry((floor(from), floor(to))).or_default() += 1;
        }
    }
    let height = FLOOR * rooms.len() as f64 + 20.0;
    let y = |k: usize| 10.0 + FLOOR * (rooms.len() - 1 - k) as f64 + 0.5 * FLOOR;
    let mut svg = format!(
        "<svg viewBox=\"0 0 760 {height}\" role=\"img\" aria-label=\"Rooms of the program and what each uses\" \
         font-family=\"sans-serif\" font-size=\"12\">\n"
    );
    for (&(from, to), &count) in &between {
        let (a, b) = (y(from), y(to));
        let reach = RIGHT + 22.0 * (from.abs_diff(to) as f64).sqrt() * 4.2;
        let width = 0.5 + (count as f64).ln().max(0.0) * 0.6;
        let _ = writeln!(
            svg,
            "<path d=\"M{RIGHT} {a} C{reach:.0} {a} {reach:.0} {b} {RIGHT} {b}\" fill=\"none\" stroke=\"#5b7fa6\" \
             stroke-opacity=\"0.55\" stroke-width=\"{width:.1}\"><title>{} uses {}: {count} imports</title></path>",
            rooms[from], rooms[to]
        );
    }
    for (k, room) in rooms.iter().enumerate() {
        let files = all.iter().filter(|(m, _)| m[0] == *room);
        let (count, lines) =
            files.fold((0, 0), |(n, lines), (_, text)| (n + 1, lines + text.lines().count()));
        let top = y(k) - 0.5 * FLOOR + 2.0;
        let _ = writeln!(
            svg,
            "<rect x=\"{LEFT}\" y=\"{top}\" width=\"{}\" height=\"{}\" fill=\"#eef3f8\" stroke=\"#5b7fa6\"/>\
             <text x=\"{}\" y=\"{}\" font-weight=\"bold\" fill=\"#1d2b3a\">{room}</text>\
             <text x=\"{}\" y=\"{}\" text-anchor=\"end\" fill=\"#4a5b6c\">{count} files, {} lines</text>",
            RIGHT - LEFT,
            FLOOR - 4.0,
            LEFT + 8.0,
            y(k) + 4.0,
            RIGHT - 8.0,
            y(k) + 4.0,
            (lines + 50) / 100 * 100,
        );
    }
    svg.push_str("</svg>\n");
    svg
}

fn the_page_of_the_house_is_drawn_from_the_arrows(rooms: &[String], all: &Files, arrows: &Arrows) {
    let mut page = String::from(
        "<!-- generated by tests/it/rooms.rs: ROADBENCH_BLESS=1 cargo nextest run -E 'test(rooms::)' -->\n\
         # Architecture: modules and dependencies\n\n\
         Every folder of `src` is a module, called a room in the code. A room uses only rooms below it, and no file leads back \
         to itself: `tests/it/rooms.rs` reads the imports and fails otherwise. The order stands in `src/lib.rs`. Each line \
         of the drawing leads from a room to one that it uses. The thicker the line, the more files use it.\n\n",
    );
    page += &drawing(rooms, all, arrows);
    page += "\n| room, from the top | what is in it | uses |\n|---|---|---|\n";
    for room in rooms.iter().rev() {
        let text = &all[&vec![room.clone()]];
        let used: BTreeSet<&String> = arrows
            .iter()
            .filter(|(m, _)| m[0] == *room)
            .flat_map(|(_, to)| to.iter().map(|m| &m[0]))
            .filter(|r| *r != room)
            .collect();
        let used: Vec<&str> =
            rooms.iter().filter(|r| used.contains(r)).map(String::as_str).collect();
        let _ = writeln!(page, "| `{room}` | {} | {} |", purpose(text), used.join(", "));
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("book/src/house.md");
    if std::env::var_os("ROADBENCH_BLESS").is_some() {
        std::fs::write(&path, page).expect("written");
        return;
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    // numbers of lines and imports change with every edit: what has to agree is who uses whom
    let table = |text: &str| text.split_once("| room,").map(|(_, t)| t.to_owned());
    assert!(
        table(&found) == table(&page),
        "book/src/house.md is stale: ROADBENCH_BLESS=1 cargo nextest run -E 'test(rooms::)'"
    );
}

/// Comments cite the method as `book/src/diagnosis.md, section 2.5`: the page has that section.
#[test]
fn cited_sections_of_the_book_are_there() {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("book/src");
    let heading = |page: &str, number: &str| {
        let text = std::fs::read_to_string(book.join(page)).unwrap_or_default();
        text.lines().any(|l| {
            let title = l.trim_start_matches('#').trim_start();
            l.starts_with('#')
                && title.strip_prefix(number).is_some_and(|r| r.starts_with([' ', '.']))
        })
    };
    let mut cited = 0;
    let mut wrong = Vec::new();
    for (module, text) in modules() {
        // a citation may run over a line of a comment
        let lines = text.lines().map(|l| l.trim_start().trim_start_matches(['/', '!']));
        let text = lines.collect::<Vec<_>>().join("");
        for (at, _) in text.match_indices(".md`, section") {
            let before = &text[..at];
            let start = before.rfind('`').map_or(0, |k| k + 1);
            let page = format!("{}.md", &before[start..]);
            let after = text[at..].trim_start_matches(".md`, section").trim_start_matches('s');
            let number: String = after
                .trim_start()
                .chars()
                .take_while(|c| c.is_ascii_digit() || *c == '.')
                .collect();
            let number = number.trim_end_matches('.');
            cited += 1;
            match page.strip_prefix("book/src/") {
                Some(page) if heading(page, number) => {}
                _ => wrong.push(format!("{}: {page}, section {number}", module.join("/"))),
            }
        }
    }
    assert!(wrong.is_empty() && cited >= 15, "{cited} cited, not there:\n{}", wrong.join("\n"));
}
