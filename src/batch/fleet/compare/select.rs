//! Sets of sessions as people name them: `s0001,s0002`, `tyre=Model A`, `bike=b1,rider=anna`, `2026-05-01..2026-05-03`.
//!
//! Terms of one kind add up, those of different kinds narrow each other. `*` stands for any letters, capital and small
//! letters are the same.

use std::collections::BTreeSet;

use crate::contract::schema::nearest;
use crate::store::tables::rows::SessionRow;

/// Property by which a term selects sessions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Session,
    Bike,
    Tyre,
    Front,
    Rear,
    Rider,
    Site,
    Days,
}

impl Kind {
    /// By their names on the command line.
    const NAMED: [(&'static str, Kind); 7] = [
        ("session", Kind::Session),
        ("bike", Kind::Bike),
        ("tyre", Kind::Tyre),
        ("front", Kind::Front),
        ("rear", Kind::Rear),
        ("rider", Kind::Rider),
        ("site", Kind::Site),
    ];

    fn words(self) -> &'static str {
        match self {
            Kind::Session => "session",
            Kind::Bike => "bike",
            Kind::Tyre => "tyre",
            Kind::Front => "front tyre",
            Kind::Rear => "rear tyre",
            Kind::Rider => "rider",
            Kind::Site => "site",
            Kind::Days => "day",
        }
    }

    /// Values of a session for this property.
    fn of(self, row: &SessionRow) -> Vec<&str> {
        let texts = match self {
            Kind::Session => vec![Some(row.ident.session_id.as_str())],
            Kind::Bike => vec![Some(row.ident.bike_id.as_str())],
            Kind::Tyre => vec![row.tyre_front.as_deref(), row.tyre_rear.as_deref()],
            Kind::Front => vec![row.tyre_front.as_deref()],
            Kind::Rear => vec![row.tyre_rear.as_deref()],
            Kind::Rider => vec![row.rider_id.as_deref()],
            Kind::Site => vec![row.site.as_deref()],
            Kind::Days => vec![row.ident.start_time.as_deref()],
        };
        texts.into_iter().flatten().collect()
    }
}

/// One condition of a selection.
#[derive(Debug, Clone, PartialEq)]
struct Term {
    kind: Kind,
    /// As it was written, without the kind's name.
    text: String,
    /// Of days: first and last, as far as they are given.
    days: [Option<String>; 2],
}

impl Term {
    fn read(text: &str) -> Result<Term, String> {
        let term = |kind, text: &str| Term { kind, text: text.to_owned(), days: [None, None] };
        if let Some((name, value)) = text.split_once('=') {
            let (name, value) = (name.trim().to_lowercase(), value.trim());
            let Some((_, kind)) = Kind::NAMED.iter().find(|(known, _)| *known == name) else {
                let names: Vec<&str> = Kind::NAMED.iter().map(|k| k.0).collect();
                return Err(format!(
                    "`{text}`: sessions cannot be chosen by `{name}`; choose by {}, session id or day",
                    names.join(", ")
                ));
            };
            return match value.is_empty() {
                true => Err(format!("`{text}`: the value after `=` is missing")),
                false => Ok(term(*kind, value)),
            };
        }
        let Some((from, to)) = text.split_once("..") else { return Ok(term(Kind::Session, text)) };
        let day = |text: &str| match text.trim() {
            "" => Ok(None),
            day if is_day(day) => Ok(Some(day.to_owned())),
            other => {
                Err(format!("`{other}` is no day such as 2026-05-01, nor a month such as 2026-05"))
            }
        };
        let days = [day(from)?, day(to)?];
        match &days {
            [None, None] => Err(format!("`{text}`: give the first day, the last day or both")),
            [Some(from), Some(to)] if from > to && !from.starts_with(to.as_str()) => {
                Err(format!("`{text}`: the last day is before the first"))
            }
            _ => Ok(Term { days, ..term(Kind::Days, text) }),
        }
    }

    fn matches(&self, row: &SessionRow) -> bool {
        self.kind.of(row).into_iter().any(|text| match self.kind {
            Kind::Days => {
                let [from, to] = &self.days;
                let start = |day: &str| text.get(..day.len()).unwrap_or(text).to_owned();
                from.as_ref().is_none_or(|day| start(day) >= *day)
                    && to.as_ref().is_none_or(|day| start(day) <= *day)
            }
            _ => is_like(&self.text.to_lowercase(), &text.to_lowercase()),
        })
    }

    /// Why it matches nothing.
    fn nothing(&self, rows: &[SessionRow]) -> String {
        let there: BTreeSet<&str> = rows.iter().flat_map(|row| self.kind.of(row)).collect();
        let what = self.kind.words();
        if self.kind == Kind::Days {
            return match (there.first(), there.last()) {
                (Some(first), Some(last)) => {
                    let day = |t: &str| t.get(..10).unwrap_or(t).to_owned();
                    format!(
                        "no session is from {}; the sessions are from {} to {}",
                        self.text,
                        day(first),
                        day(last)
                    )
                }
                _ => format!("no session is from {}: the sessions have no start time", self.text),
            };
        }
        if there.is_empty() {
            return format!(
                "no session has a {what}: give it in the log or under [meta] of its channel map"
            );
        }
        let ends = |id: &&&str| id.to_lowercase().ends_with(&self.text.to_lowercase());
        let near = there.iter().find(ends).copied();
        let near = near.or_else(|| nearest(&self.text, there.iter().copied()));
        let hint = match near {
            Some(near) => format!("did you mean `{near}`?"),
            None => {
                let some: Vec<String> = there.iter().take(6).map(|t| format!("`{t}`")).collect();
                let more = if there.len() > some.len() { ", ..." } else { "" };
                format!("there are {}{more}", some.join(", "))
            }
        };
        format!("no session has the {what} `{}`; {hint}", self.text)
            .replace("no session has the session", "no session")
    }
}

/// `2026-05-01`, or a month or a year.
fn is_day(text: &str) -> bool {
    let shape: String = text.chars().map(|c| if c.is_ascii_digit() { '0' } else { c }).collect();
    ["0000-00-00", "0000-00", "0000"].contains(&shape.as_str())
}

/// Whether a text is like a pattern in which `*` stands for any letters.
fn is_like(pattern: &str, text: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = text.strip_prefix(first) else { return false };
    let parts: Vec<&str> = parts.collect();
    let Some((last, middle)) = parts.split_last() else { return rest.is_empty() };
    for part in middle {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

/// The sessions that a text names.
///
/// # Errors
/// The text is none, or what it names is not there.
pub(crate) fn select<'a>(
    text: &str,
    rows: &'a [SessionRow],
) -> Result<Vec<&'a SessionRow>, String> {
    let terms: Vec<Term> =
        text.split(',').map(|term| Term::read(term.trim())).collect::<Result<_, _>>()?;
    if terms.iter().any(|term| term.text.is_empty()) {
        return Err(format!("`{text}` selects no sessions"));
    }
    if let Some(term) = terms.iter().find(|term| !rows.iter().any(|row| term.matches(row))) {
        return Err(term.nothing(rows));
    }
    let kinds: BTreeSet<Kind> = terms.iter().map(|term| term.kind).collect();
    let is_chosen = |row: &&SessionRow| {
        kinds.iter().all(|kind| terms.iter().any(|t| t.kind == *kind && t.matches(row)))
    };
    let chosen: Vec<&SessionRow> = rows.iter().filter(is_chosen).collect();
    match chosen.is_empty() {
        true => {
            Err(format!("no session matches all parts of `{text}`; each part alone matches some"))
        }
        false => Ok(chosen),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tables::rows::Ident;

    fn rows() -> Vec<SessionRow> {
        let row = |id: &str, bike: &str, day: &str, tyre: Option<&str>, rider: &str| SessionRow {
            ident: Ident {
                session_id: id.into(),
                bike_id: bike.into(),
                start_time: Some(format!("{day}T09:00:00Z")),
            },
            tyre_front: tyre.map(|t| format!("120/70 {t}")),
            tyre_rear: tyre.map(|t| format!("180/55 {t}")),
            rider_id: Some(rider.into()),
            ..SessionRow::default()
        };
        vec![
            row("day_s0001", "b1", "2026-05-01", Some("A"), "anna"),
            row("day_s0002", "b1", "2026-05-02", Some("A"), "Ben"),
            row("day_s0003", "b2", "2026-05-03", Some("B"), "anna"),
            row("day_s0004", "b2", "2026-06-01", None, "anna"),
        ]
    }

    fn found(text: &str) -> Vec<usize> {
        let rows = rows();
        let chosen = select(text, &rows).unwrap_or_else(|e| panic!("{text}: {e}"));
        chosen.iter().filter_map(|c| rows.iter().position(|r| r.ident == c.ident)).collect()
    }

    #[test]
    fn terms_of_a_kind_add_up_and_kinds_narrow_each_other() {
        for (text, ids) in [
            ("day_s0001", &[0][..]),
            ("day_s0001,day_s0003", &[0, 2]),
            ("*s0004", &[3]),
            ("tyre=180/55 a", &[0, 1]),
            ("rear=*B", &[2]),
            ("rider=ANNA", &[0, 2, 3]),
            ("rider=anna,bike=b2", &[2, 3]),
            ("2026-05-02..2026-05-03", &[1, 2]),
            ("2026-05..2026-05", &[0, 1, 2]),
            ("..2026-05-01", &[0]),
            ("2026-06..", &[3]),
            ("bike=*", &[0, 1, 2, 3]),
        ] {
            assert_eq!(found(text), ids, "{text}");
        }
    }

    #[test]
    fn what_is_not_there_is_said_with_what_is() {
        let rows = rows();
        for (text, part) in [
            ("s0001", "no session `s0001`; did you mean `day_s0001`?"),
            ("day_s001", "did you mean `day_s0001`?"),
            ("tire=x", "cannot be chosen by `tire`"),
            ("tyre=Rosso", "there are `120/70 A`, `120/70 B`"),
            ("site=Jerez", "no session has a site"),
            ("2027-01-01..", "from 2026-05-01 to 2026-06-01"),
            ("1.5..2", "`1.5` is no day"),
            ("2026-06..2026-05", "the last day is before the first"),
            ("..", "give the first day"),
            ("bike=", "the value after `=` is missing"),
            ("day_s0001,", "selects no sessions"),
            ("rider=ben,bike=b2", "no session matches all parts of"),
        ] {
            let e = select(text, &rows).expect_err(text);
            assert!(e.contains(part), "{text}: {e}");
        }
    }
}
