//! Phrases that are not to come back, with the word to use instead (`book/src/glossary.md`).

use std::path::Path;

/// A phrase in small letters, and what to write instead.
const PHRASES: [(&str, &str); 30] = [
    ("null simulation", "fault-free simulation"),
    ("noise alone", "noise only"),
    ("base model", "nominal model"),
    ("strained", "implausible fit"),
    ("hold the truth", "contain the true value"),
    ("holds the truth", "contains the true value"),
    ("held the truth", "contained the true value"),
    ("is named", "is identified"),
    ("are named", "are identified"),
    ("was named", "is identified"),
    ("named cause", "identified cause"),
    ("cause is named", "a cause is identified"),
    ("rightly named", "correctly identified"),
    ("log likelihood rises", "2 x log-likelihood gain"),
    ("brakings", "braking manoeuvres, stops"),
    ("mass centre", "centre of mass"),
    ("whoever", "say who"),
    ("honest uncertainty", "confidence interval"),
    ("how sure", "accuracy"),
    ("the house", "the architecture"),
    ("independent plant", "independent simulator"),
    ("workshop's", "level A"),
    ("tutorial's", "level B"),
    ("of before", "earlier"),
    ("of now", "current version"),
    ("the last version", "the state of the current version"),
    ("since then", "the state of the current version"),
    ("a day later", "the state of the current version"),
    ("told apart", "separated"),
    ("by a reviewer", "the origin of the figures"),
];

/// The glossary defines the program's own words.
const GLOSSARY: &str = "glossary.md";

/// The text of a page without blocks and spans of code, in small letters, on one line: a phrase may run over the end
/// of a line, and a key is what it is.
fn prose(page: &str) -> String {
    let outside = page.split("```").step_by(2).collect::<Vec<_>>().join(" ");
    let words = outside.split('`').step_by(2).collect::<Vec<_>>().join(" ").to_lowercase();
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn phrases_of_before_stay_away() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let chapters = walkdir::WalkDir::new(root.join("book/src"));
    let chapters = chapters.into_iter().map(|entry| entry.expect("entry").into_path());
    let chapters = chapters.filter(|p| p.extension().is_some_and(|e| e == "md"));
    let mut pages: Vec<_> = chapters.filter(|p| !p.ends_with(GLOSSARY)).collect();
    assert!(pages.len() > 40, "{}", pages.len());
    pages.extend(["README.md", "CONTRIBUTING.md"].map(|name| root.join(name)));
    let mut wrong = Vec::new();
    for path in pages {
        let text = prose(&std::fs::read_to_string(&path).expect("page"));
        let name = path.strip_prefix(root).expect("below").display();
        let found = PHRASES.iter().filter(|(phrase, _)| text.contains(phrase));
        wrong.extend(found.map(|(phrase, instead)| format!("{name}: {phrase}: say {instead}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
