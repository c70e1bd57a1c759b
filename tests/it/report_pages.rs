//! The kinds of a session's page: alone, sharing what they have in common, none; and that only what
//! changed is written anew.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use roadbench::internals::report::{self, Pages};

use crate::page;
use crate::report::generate;

const PAGE: &str = "2024-05-03_lap-1.html";

fn read(out: &Path, name: &str) -> String {
    fs::read_to_string(out.join("report").join(name)).expect(name)
}

/// Names of the shared files.
fn assets(out: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(out.join("report/assets")) else { return Vec::new() };
    let mut names: Vec<String> =
        entries.map(|e| e.expect("entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Every session's page with what is in it.
fn pages(out: &Path) -> BTreeMap<String, String> {
    fs::read_dir(out.join("report"))
        .expect("report")
        .map(|e| e.expect("entry").file_name().to_string_lossy().into_owned())
        .filter(|n| n.ends_with(".html") && n != "index.html")
        .map(|n| (n.clone(), read(out, &n)))
        .collect()
}

/// Notes on every session's page that it was there before.
fn mark(out: &Path) {
    for (name, html) in pages(out) {
        fs::write(out.join("report").join(name), html + "<!-- before -->").expect("page");
    }
    relist(out);
}

/// Lists the pages as they are now: one that is not as it was listed is written again.
pub fn relist(out: &Path) {
    let at = out.join("report/.written.json");
    let list = fs::read(&at).expect("a list");
    let mut list: BTreeMap<String, String> = serde_json::from_slice(&list).expect("a list");
    for (name, sum) in &mut list {
        let bytes = fs::read(out.join("report").join(name)).expect("a page");
        *sum = blake3::hash(&bytes).to_hex().to_string();
    }
    fs::write(at, serde_json::to_vec(&list).expect("text")).expect("written");
}

fn stayed(out: &Path) -> usize {
    pages(out).values().filter(|html| html.ends_with("<!-- before -->")).count()
}

#[test]
fn shared_pages_have_their_script_and_style_beside_them() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path();
    generate(out);
    report::write(out).expect("report");
    let alone = read(out, PAGE);
    assert!(assets(out).is_empty() && !alone.contains("src="));

    report::build(out, Pages::Shared, false).expect("shared");
    let shared = read(out, PAGE);
    assert!(shared.len() + 85_000 < alone.len(), "{} of {}", shared.len(), alone.len());
    assert_eq!(page::data(&shared), page::data(&alone), "what is drawn is the same");
    assert!(!shared.contains("<style") && !shared.contains("'unsafe-inline';"), "no inline script");
    let files = assets(out);
    assert_eq!(files.len(), 2, "{files:?}");
    for (attribute, file) in [("href", &files[0]), ("src", &files[1])] {
        assert!(shared.contains(&format!("{attribute}=\"assets/{file}\"")), "{file}");
    }
    let script = read(out, &format!("assets/{}", files[1]));
    for part in ["const unstep", "uPlot"] {
        assert!(script.contains(part) && alone.contains(part), "{part}");
    }
    // the run's own page opens wherever it is
    assert!(!read(out, "index.html").contains("assets/"));
}

#[test]
fn a_page_that_is_there_stays_whatever_the_next_would_be() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path();
    generate(out);
    report::build(out, Pages::Shared, true).expect("shared");
    let files = assets(out);
    mark(out);
    // three sessions: by itself it would take pages that stand alone
    report::update(out).expect("update");
    assert_eq!((stayed(out), assets(out)), (3, files.clone()));
    // what the pages need comes back, what an older version left goes, what is not ours stays
    let folder = out.join("report/assets");
    fs::remove_file(folder.join(&files[0])).expect("removed");
    fs::write(folder.join("report-0123.js"), "/* roadbench report */\nold").expect("old");
    fs::write(folder.join("mine.js"), "mine").expect("mine");
    report::update(out).expect("update");
    assert_eq!(stayed(out), 3);
    assert_eq!(assets(out), ["mine.js", files[0].as_str(), files[1].as_str()]);
    // a page whose session is another is made anew, of the kind that is now the usual
    fs::remove_file(out.join("report").join(PAGE)).expect("removed");
    report::update(out).expect("update");
    assert_eq!(stayed(out), 2);
    assert!(!read(out, PAGE).contains("assets/") && assets(out).len() == 3);

    // asked for by name, each page is brought to that kind, once
    report::build(out, Pages::SelfContained, false).expect("alone");
    assert_eq!((stayed(out), assets(out)), (0, vec!["mine.js".to_owned()]));
    mark(out);
    report::build(out, Pages::SelfContained, false).expect("again");
    assert_eq!(stayed(out), 3);
}

/// A page that was made while a table was damaged is no page of the whole tables, although the sessions are the same.
#[test]
fn a_page_that_was_made_without_a_table_is_made_again_with_it() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path();
    generate(out);
    report::write(out).expect("report");
    let whole = pages(out);
    let mut shown = Vec::new();
    for table in ["coefficients", "manoeuvres", "plots", "warnings", "tyre_parameters", "forces"] {
        let (there, away) = (out.join(table), out.join("away"));
        if fs::rename(&there, &away).is_err() {
            continue;
        }
        report::update(out).expect("without the table");
        let without = pages(out);
        fs::rename(&away, &there).expect("back");
        report::update(out).expect("with the table");
        assert!(pages(out) == whole, "{table}");
        if without != whole {
            shown.push(table);
        }
    }
    assert!(shown.contains(&"coefficients") && shown.contains(&"plots"), "{shown:?}");
}

#[test]
fn a_report_without_pages_of_sessions_links_to_none() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path();
    generate(out);
    report::build(out, Pages::Shared, true).expect("shared");
    report::build(out, Pages::None, true).expect("none");
    assert!(pages(out).is_empty() && !out.join("report/assets").exists());
    let index = read(out, "index.html");
    assert!(index.contains("2024-05-03_lap-1") && !index.contains(".html\""));
}
