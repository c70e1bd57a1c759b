//! Phrases that are not to come back, with the word to use instead (`book/src/glossary.md`): in pages, in comments of the
//! code and in the program's messages.

use std::path::{Path, PathBuf};

/// A phrase of pages in small letters, and the words to use instead.
const PHRASES: [(&str, &str); 51] = [
    ("null simulation", "fault-free simulation"),
    ("noise alone", "noise only"),
    ("base model", "nominal model"),
    (" strained", "implausible fit"),
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
    ("required-numbers file", "bike file of level C"),
    ("takes sessions out", "removes sessions"),
    ("still as it was written", "integrity check"),
    ("said by you", "given by the user"),
    ("0 to know of", "0 notes"),
    ("that never was", "simulated"),
    ("not told", "unknown"),
    ("told of", "reported"),
    ("has structure", "disagree, depending on ..."),
    ("twice the log likelihood", "2 x log-likelihood gain"),
    ("the plant", "independent simulator"),
    ("rightly", "correctly"),
    ("faultless", "fault-free"),
    ("what is left", "the remainder, the residual"),
    ("formerly", "the state of the current version"),
    ("previously", "the state of the current version"),
    ("used to be", "the state of the current version"),
    ("bends", "corners"),
    ("constants of the naming", "constants of the identification"),
    ("false name", "false alarm"),
    ("told that", "reported"),
];

/// A phrase of comments in the code in small letters, and the words to use instead.
const COMMENTS: [(&str, &str); 29] = [
    ("null simulation", "fault-free simulation"),
    ("noise alone", "noise only"),
    ("base model", "nominal model"),
    (" strained", "implausible fit"),
    ("hold the truth", "contain the true value"),
    ("holds the truth", "contains the true value"),
    ("held the truth", "contained the true value"),
    ("brakings", "braking manoeuvres, stops"),
    ("mass centre", "centre of mass"),
    ("whoever", "say who"),
    ("how sure", "accuracy"),
    ("of before", "earlier"),
    ("of now", "current version"),
    ("a day later", "the reason, not the history"),
    ("told apart", "separated"),
    ("by a reviewer", "the reason, not the history"),
    ("independent plant", "independent simulator"),
    ("none of our business", "ignored"),
    ("takes sessions out", "removes sessions"),
    ("rightly", "correctly"),
    ("held against", "compared with"),
    ("noise floor", "noise-only rms"),
    ("diagnosis named", "identified causes"),
    ("was named", "is identified"),
    ("named cause", "identified cause"),
    ("have it that", "suggest, show"),
    ("has it that", "suggests, shows"),
    ("what is left", "the remainder, the residual"),
    (" told ", "reported, separated, recognised"),
];

/// A phrase of the program's messages, help texts and tables in small letters, and the words to use instead.
const MESSAGES: [(&str, &str); 26] = [
    ("null simulation", "fault-free simulation"),
    ("noise alone", "noise only"),
    ("base model", "nominal model"),
    ("strained", "implausible fit"),
    ("hold the truth", "contain the true value"),
    ("holds the truth", "contains the true value"),
    ("brakings with", "stops, braking"),
    ("mass centre", "centre of mass"),
    ("whoever", "say who"),
    ("how sure", "accuracy"),
    ("of before", "earlier"),
    ("said by you", "given by the user"),
    ("told apart", "separated"),
    ("make no sense", "cannot be decoded"),
    ("carries on", "run the same command again"),
    ("is left over", "remains"),
    ("to hold it against", "to compare it with"),
    ("say it with", "give it with"),
    ("as it was written", "damaged"),
    ("is there already", "exists already"),
    ("takes it out", "removes it"),
    ("all along", "stays at, throughout"),
    ("is no number", "is not a number"),
    ("as you said", "given by the user"),
    ("nobody reads", "no program reads"),
    ("calculated of", "calculated from"),
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
fn pages_use_the_fields_words() {
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
        wrong.extend(found(&path, &text, &PHRASES));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The phrases that a text has, with its file and the words to use.
fn found(path: &Path, text: &str, phrases: &[(&str, &str)]) -> Vec<String> {
    let name = path.strip_prefix(env!("CARGO_MANIFEST_DIR")).expect("below").display();
    let has = |(phrase, _): &&(&str, &str)| text.contains(phrase);
    let line = |(phrase, instead): &(&str, &str)| format!("{name}: {phrase}: say {instead}");
    phrases.iter().filter(has).map(line).collect()
}

/// Comments and strings of Rust code in small letters, each on one line. A string that has an escaped quote ends there; that
/// finds what it should in messages.
fn comments_and_strings(code: &str) -> [String; 2] {
    let (mut comments, mut strings) = (Vec::new(), Vec::new());
    for line in code.lines() {
        let line = line.trim_start();
        if let Some(comment) = line.strip_prefix("//") {
            comments.push(comment.trim_start_matches(['/', '!']).to_lowercase());
            continue;
        }
        // behind code: outside of strings there is an even number of quotes before
        let behind =
            line.match_indices(" // ").find(|(i, _)| line[..*i].matches('"').count() % 2 == 0);
        let (code, comment) = behind.map_or((line, ""), |(i, _)| line.split_at(i));
        comments.push(comment.trim_start_matches([' ', '/']).to_lowercase());
        strings.push(code.to_lowercase());
    }
    let strings = strings.join(" ");
    let strings = strings.split('"').skip(1).step_by(2).collect::<Vec<_>>().join(" ");
    [comments.join(" "), strings].map(|text| text.split_whitespace().collect::<Vec<_>>().join(" "))
}

fn code_below(folder: &str) -> Vec<PathBuf> {
    let files = walkdir::WalkDir::new(Path::new(env!("CARGO_MANIFEST_DIR")).join(folder));
    let files = files.into_iter().map(|entry| entry.expect("entry").into_path());
    files.filter(|p| p.extension().is_some_and(|e| e == "rs") && !p.ends_with("words.rs")).collect()
}

#[test]
fn comments_and_messages_use_the_fields_words() {
    let mut wrong = Vec::new();
    let mut files = 0;
    for folder in ["src", "python/src", "tests", "examples", "benches"] {
        for path in code_below(folder) {
            let code = std::fs::read_to_string(&path).expect("code");
            let [comments, strings] = comments_and_strings(&code);
            wrong.extend(found(&path, &comments, &COMMENTS));
            if folder == "src" {
                wrong.extend(found(&path, &strings, &MESSAGES));
            }
            files += 1;
        }
    }
    assert!(files > 500, "{files}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn comments_and_strings_are_found_in_code() {
    let code = "/// Mass\n//! centre\nlet x = \"a // Word\"; // Whoever\n";
    let [comments, strings] = comments_and_strings(code);
    assert_eq!(comments, "mass centre whoever");
    assert_eq!(strings, "a // word");
}
