//! The sessions of an output as a list on the terminal, and what was rejected.

use crate::report::terminal;
use crate::statistics::number_format::{count, timestamp};
use crate::store::tables::rows::{Rejected, SessionRow};

/// Columns of the list.
const HEAD: [&str; 5] = ["session", "motorcycle", "date", "state", "determined"];

/// A line for each session: id, motorcycle, date, state, how many coefficients are determined; below it what was rejected
/// and why. Lines of at most `width` characters; of ids that leave too little room the rest stands on a line of its own.
pub(crate) fn text(sessions: &[SessionRow], rejected: &[Rejected], width: usize) -> String {
    let mut out = String::new();
    let rows: Vec<[String; 5]> = sessions.iter().map(cells).collect();
    if rows.is_empty() {
        out.push_str("no sessions\n");
    } else {
        let head = HEAD.map(str::to_owned);
        let all = || std::iter::once(&head).chain(&rows);
        let wide = |k: usize| all().map(|row| row[k].chars().count()).max().unwrap_or(0);
        let widths = [0, 1, 2, 3, 4].map(wide);
        let is_one_line = widths.iter().sum::<usize>() + 2 * (HEAD.len() - 1) <= width;
        for row in all() {
            out.push_str(&line(row, &widths, is_one_line));
        }
    }
    if !rejected.is_empty() {
        out += &format!("\n{} rejected:\n", rejected.len());
        out += &terminal::rejections(rejected, rejected.len(), width);
    }
    out
}

fn cells(session: &SessionRow) -> [String; 5] {
    let date = session.ident.start_time.as_deref().map(timestamp).unwrap_or_default();
    let state = match usize::try_from(session.n_warnings).unwrap_or(0) {
        0 => "done".to_owned(),
        n => format!("done, {}", count(n, "warning")),
    };
    [
        terminal::clean(&session.ident.session_id),
        terminal::clean(&session.ident.bike_id),
        if date.is_empty() { "-".to_owned() } else { date.chars().take(10).collect() },
        state,
        session.n_coefficients_ok.to_string(),
    ]
}

fn line(cells: &[String; 5], widths: &[usize; 5], is_one_line: bool) -> String {
    let mut out = cells[0].clone();
    match is_one_line {
        true => out += &" ".repeat(widths[0] - cells[0].chars().count()),
        false => out += "\n ",
    }
    for k in 1..5 {
        let (cell, width) = (&cells[k], widths[k]);
        out += &if k == 4 { format!("  {cell:>width$}") } else { format!("  {cell:width$}") };
    }
    out.trim_end().to_owned() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tables::rows::Ident;

    fn session(id: &str, warnings: i64) -> SessionRow {
        SessionRow {
            ident: Ident {
                session_id: id.into(),
                bike_id: "b1".into(),
                start_time: (warnings > 0).then(|| "2026-05-01T08:00:00Z".into()),
            },
            n_warnings: warnings,
            n_coefficients_ok: 7,
            ..SessionRow::default()
        }
    }

    #[test]
    fn sessions_are_lines_and_what_was_rejected_says_why() {
        let rejected = Rejected {
            path: "logs/c.csv".into(),
            stage: "ingest".into(),
            code: "empty".into(),
            message: "no rows".into(),
            ..Rejected::default()
        };
        let said = text(&[session("ride\u{1b}1", 1), session("r2", 0)], &[rejected], 80);
        assert_eq!(
            said,
            "session  motorcycle  date        state            determined\n\
             ride 1   b1          2026-05-01  done, 1 warning           7\n\
             r2       b1          -           done                      7\n\
             \n1 rejected:\n  logs/c.csv\n      ingest (empty): no rows\n"
        );
        assert_eq!(text(&[], &[], 80), "no sessions\n");
    }

    #[test]
    fn a_long_id_has_a_line_of_its_own() {
        let said = text(&[session(&"x".repeat(60), 1)], &[], 80);
        assert!(said.lines().all(|l| l.chars().count() <= 80), "{said}");
        assert!(said.contains(&format!("\n{}\n   b1 ", "x".repeat(60))), "{said}");
    }
}
