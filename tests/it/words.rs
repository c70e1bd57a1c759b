//! Phrases that are not to come back, with the word to use instead (`book/src/glossary.md`).

use std::path::Path;

/// A phrase in small letters, and what to write instead.
const PHRASES: [(&str, &str); 17] = [
    ("null simulation", "fault-free simulation"),
    ("noise alone", "noise only"),
    ("base model", "nominal model"),
    ("hold the truth", "contain the true value"),
    ("holds the truth", "contains the true value"),
    ("is named", "is identified"),
    ("cause is named", "a cause is identified"),
    ("log likelihood rises", "2 x log-likelihood gain"),
    ("brakings", "braking manoeuvres, stops"),
    ("mass centre", "centre of mass"),
    ("whoever", "say who"),
    ("honest uncertainty", "confidence interval"),
    ("how sure it is", "accuracy"),
    ("the house", "the architecture"),
    ("independent plant", "independent simulator"),
    ("since then", "the state of the current version"),
    ("by a reviewer", "the origin of the figures"),
];

/// Pages that are clean. The glossary is not among them: it defines the program's own words.
const PAGES: [&str; 5] = [
    "README.md",
    "CONTRIBUTING.md",
    "book/src/introduction.md",
    "book/src/tutorial.md",
    "book/src/SUMMARY.md",
];

#[test]
fn phrases_of_before_stay_away() {
    let mut wrong = Vec::new();
    for name in PAGES {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
        let text = std::fs::read_to_string(&path).expect(name).to_lowercase();
        // a phrase may run over the end of a line
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let found = PHRASES.iter().filter(|(phrase, _)| text.contains(phrase));
        wrong.extend(found.map(|(phrase, instead)| format!("{name}: {phrase}: say {instead}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
