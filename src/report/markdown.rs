//! The report in Markdown, for pull requests and chat: the numbers and what is wrong, no more.

use std::fmt::Write as _;

use crate::report::fleet::page::Page as Fleet;
use crate::report::next_ride;
use crate::report::run::page::Page as Run;
use crate::report::session::page::Page;

/// Rows of a list; omitted rows are counted.
const LISTED: usize = 30;

/// The run: coefficients by bike, what happened to the fleet, diagnoses, sessions, rejected
/// inputs, warnings. With one session its own coefficients take the place of the medians.
pub(crate) fn write(run: &Run, fleet: Option<&Fleet>, only: Option<&Page>) -> String {
    let mut out = String::new();
    heading(&mut out, run);
    match only {
        Some(page) => session(&mut out, page),
        None => bikes(&mut out, run),
    }
    if let Some(fleet) = fleet.filter(|f| !f.events.is_empty()) {
        events(&mut out, fleet);
    }
    if !run.diagnoses.is_empty() {
        diagnoses(&mut out, run);
    }
    if only.is_none() && !run.sessions.is_empty() {
        sessions(&mut out, run);
    }
    if !run.rejected.is_empty() {
        rejected(&mut out, run);
    }
    if !run.warnings.is_empty() {
        warnings(&mut out, run);
    }
    let _ = writeln!(out, "\nroadbench {}; SI units, intervals are 95 %.", text(&run.versions));
    out
}

// writing to a String cannot fail: the results of `writeln!` are dropped throughout

fn heading(out: &mut String, run: &Run) {
    let title = match (run.inputs, run.sessions.len()) {
        (0, _) => format!("Diagnoses of {} riding sessions", run.diagnoses.len()),
        (_, 1) => "Tyre coefficients from 1 riding session".to_owned(),
        (_, n) => format!("Tyre coefficients from {n} riding sessions"),
    };
    let _ = writeln!(out, "# {title}\n");
    if run.inputs > 0 {
        let _ = writeln!(out, "{} {}", text(&run.verdict), text(&run.ridden));
    }
}

fn session(out: &mut String, page: &Page) {
    let _ = writeln!(out, "\n## {}\n\n{} {}", text(&page.session_id), page.verdict, page.ridden);
    if let Some(laps) = &page.laps {
        let _ = writeln!(out, "\nLaps: {} {}", laps.verdict, laps.grip);
        if !laps.markers.is_empty() {
            let _ = writeln!(out, "{}", laps.markers);
        }
        if let Some(trends) = &laps.trends {
            let _ = writeln!(out, "{}", trends.verdict);
        }
    }
    for tyre in &page.tyres {
        let _ = writeln!(out, "\n### {}\n", text(&tyre.title));
        head(out, &["coefficient", "value", "unit", "95 % interval", "status"], &[1, 3]);
        for c in &tyre.rows {
            let status = match c.reason.as_str() {
                "" => c.status_label.to_owned(),
                reason => format!("{}: {}", c.status_label, text(reason)),
            };
            row(out, &[text(&c.label), text(&c.value), text(&c.unit), text(&c.interval), status]);
        }
    }
    if !page.missing.is_empty() {
        let _ = writeln!(out, "\n### {}: what this one could not determine\n", next_ride::TITLE);
        for group in &page.missing {
            let items: Vec<String> = group.items.iter().map(|i| text(&i.0)).collect();
            let _ = writeln!(out, "- {}: {}", text(&group.ride), items.join("; "));
        }
    }
}

fn bikes(out: &mut String, run: &Run) {
    for bike in &run.bikes {
        let _ = writeln!(out, "\n## {}, {} sessions", text(&bike.bike_id), bike.sessions);
        for tyre in &bike.tyres {
            let models = match tyre.models.as_str() {
                "" => String::new(),
                models => format!(": {}", text(models)),
            };
            let _ = writeln!(out, "\n### {}{models}\n", text(&tyre.title));
            let columns = ["coefficient", "median", "unit", "spread", "std error", "determined"];
            head(out, &columns, &[1, 3, 4, 5]);
            for c in &tyre.rows {
                row(
                    out,
                    &[
                        text(&c.label),
                        text(if c.determined == 0 { &c.note } else { &c.median }),
                        text(if c.determined == 0 { "" } else { &c.unit }),
                        text(&c.spread),
                        text(&c.within),
                        format!("{} of {}", c.determined, c.of),
                    ],
                );
            }
        }
    }
}

fn events(out: &mut String, fleet: &Fleet) {
    let _ = writeln!(out, "\n## Changes between sessions\n\n{}\n", text(&fleet.verdict));
    head(out, &["bike", "what", "since", "sessions", "size", "why"], &[3, 4]);
    for e in fleet.events.iter().take(LISTED) {
        row(
            out,
            &[
                text(&e.bike),
                format!("{}, {}", text(&e.label), text(&e.tyre)),
                text(&e.first),
                e.sessions.to_string(),
                text(&e.size),
                text(&e.reason),
            ],
        );
    }
    more(out, fleet.events.len());
}

fn diagnoses(out: &mut String, run: &Run) {
    let _ = writeln!(out, "\n## Diagnoses\n");
    head(out, &["session", "bike", "verdict", "cause", "simulation of manoeuvres left out"], &[]);
    for d in run.diagnoses.iter().take(LISTED) {
        let causes: Vec<String> = d
            .findings
            .iter()
            .map(|f| {
                let or: Vec<String> = f.or.iter().map(|o| format!(" or {}", text(o))).collect();
                format!("{} {}{}", text(&f.sentence), text(&f.size), or.concat())
            })
            .collect();
        let why = if causes.is_empty() { text(&d.reason) } else { causes.join("; ") };
        let verdict = d.verdict.to_owned();
        row(out, &[text(&d.session_id), text(&d.bike_id), verdict, why, text(&d.gain)]);
    }
    more(out, run.diagnoses.len());
}

fn sessions(out: &mut String, run: &Run) {
    let _ = writeln!(out, "\n## Sessions\n");
    head(out, &["session", "bike", "start", "km", "determined", "warnings"], &[3, 4, 5]);
    for s in run.sessions.iter().take(LISTED) {
        row(
            out,
            &[
                text(&s.session_id),
                text(&s.bike_id),
                text(&s.start),
                text(&s.distance),
                format!("{} of {}", s.determined, s.of),
                s.warnings.to_string(),
            ],
        );
    }
    more(out, run.sessions.len());
}

fn rejected(out: &mut String, run: &Run) {
    let _ = writeln!(out, "\n## Rejected\n");
    head(out, &["input", "why"], &[]);
    for r in run.rejected.iter().take(LISTED) {
        row(out, &[text(&r.path), format!("{} ({})", text(&r.message), text(&r.code))]);
    }
    more(out, run.rejected.len());
}

fn warnings(out: &mut String, run: &Run) {
    let _ = writeln!(out, "\n## Warnings\n");
    head(out, &["stage", "warning", "sessions", "for example"], &[2]);
    for (stage, code, sessions, _, example) in run.warnings.iter().take(LISTED) {
        row(out, &[text(stage), text(code), sessions.to_string(), text(example)]);
    }
    more(out, run.warnings.len());
}

fn head(out: &mut String, names: &[&str], right: &[usize]) {
    let rule = |i: usize| if right.contains(&i) { "---:" } else { "---" };
    let rules: Vec<&str> = (0..names.len()).map(rule).collect();
    let _ = writeln!(out, "| {} |\n| {} |", names.join(" | "), rules.join(" | "));
}

fn row(out: &mut String, cells: &[String]) {
    let _ = writeln!(out, "| {} |", cells.join(" | "));
}

fn more(out: &mut String, all: usize) {
    if all > LISTED {
        let _ = writeln!(out, "\n{} more are in the tables.", all - LISTED);
    }
}

/// A text from a log as text: no markup, no mention, no new line.
fn text(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '@' => out.push_str("&#64;"),
            '|' | '\\' | '`' | '*' | '_' | '[' | ']' | '#' | '~' => {
                out.push('\\');
                out.push(c);
            }
            // an address would become a link of itself
            ':' if out.ends_with("http") || out.ends_with("https") => out.push_str("&#58;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_logs_stay_texts() {
        let hostile = "<img src=x>|`a`\n# b @all [x](http://y) *z* \\|";
        let safe = text(hostile);
        assert_eq!(
            safe,
            "&lt;img src=x&gt;\\|\\`a\\` \\# b &#64;all \\[x\\](http&#58;//y) \\*z\\* \\\\\\|"
        );
    }

    #[test]
    fn a_table_says_what_it_leaves_out() {
        let mut out = String::new();
        head(&mut out, &["a", "b"], &[1]);
        row(&mut out, &["1".into(), "2".into()]);
        more(&mut out, LISTED + 2);
        assert_eq!(out, "| a | b |\n| --- | ---: |\n| 1 | 2 |\n\n2 more are in the tables.\n");
    }
}
