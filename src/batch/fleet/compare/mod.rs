//! Two sets of sessions against each other: the table `comparison`.
//!
//! Assumes the tables of one output, or of two; no log is read again. The statistics are in [`crate::fleet::compare`].

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use arrow::array::RecordBatch;

use self::read::{Estimates, Key};
use self::words::{RowStatus, not_comparable, sentence};
use crate::batch::error::Error;
use crate::batch::store::intact;
use crate::batch::store::mark;
use crate::batch::store::reading::Reading;
use crate::contract::coefficient::{Coefficient, Id, Source};
use crate::fleet::compare::{Compared, Session, Verdict};
use crate::report::labels;
use crate::store::objects::Location;
use crate::store::tables::file;
use crate::store::tables::read as tables;
use crate::store::tables::rows::{ComparisonRow, SessionRow};

pub(crate) mod answer;
pub(crate) mod numbers;
pub(crate) mod page;
mod read;
pub(crate) mod select;
pub(crate) mod words;

/// Most sessions that are read beside those of the sides: a spread is known well from fewer.
const MOST_OTHERS: usize = 60;
/// All other sessions of the output, as a set.
const OTHERS: &str = "others";

/// One side of a comparison.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chosen {
    /// As it was chosen.
    pub text: String,
    /// Its sessions: bike and id.
    pub sessions: BTreeSet<(String, String)>,
    /// First and last day, where the sessions say when they were.
    pub days: Option<[String; 2]>,
    /// Tyre models, front and rear; `None` stands for a session that does not say.
    pub tyres: BTreeSet<[Option<String>; 2]>,
}

impl Chosen {
    fn of(text: &str, rows: &[&SessionRow]) -> Chosen {
        let days: BTreeSet<&str> =
            rows.iter().filter_map(|r| r.ident.start_time.as_deref()?.get(..10)).collect();
        let key = |r: &&SessionRow| (r.ident.bike_id.clone(), r.ident.session_id.clone());
        Chosen {
            text: text.to_owned(),
            sessions: rows.iter().map(key).collect(),
            days: days.first().zip(days.last()).map(|(a, b)| [(*a).to_owned(), (*b).to_owned()]),
            tyres: rows.iter().map(|r| [r.tyre_front.clone(), r.tyre_rear.clone()]).collect(),
        }
    }

    /// Ids of the motorcycles of its sessions.
    pub fn bikes(&self) -> BTreeSet<&str> {
        self.sessions.iter().map(|(bike, _)| bike.as_str()).collect()
    }
}

/// Differences of all coefficients between two sets of sessions, A and B.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Comparison {
    /// A and B.
    pub sides: [Chosen; 2],
    /// The table: front, rear, vehicle, coefficients in the contract's order.
    pub rows: Vec<ComparisonRow>,
}

impl Comparison {
    /// The table `comparison`.
    ///
    /// # Errors
    /// A row does not fit its schema: our own mistake.
    pub fn table(&self) -> Result<RecordBatch, file::Error> {
        file::batch(&self.rows)
    }
}

/// Compares two sets of sessions of an output, or, without `b`, all of an output with all of the one that `a` is. With
/// `same_tyres` tyres whose model no log gives are one on both sides.
///
/// # Errors
/// `Usage`: a folder is no output, or a set is empty, is not there, or shares sessions with the other.
pub fn compare(
    out: &Path,
    a: &str,
    b: Option<&str>,
    same_tyres: bool,
) -> Result<Comparison, Error> {
    require(out)?;
    let _reading = Reading::of(out)?;
    intact::require_sessions(&Location::from(out))?;
    let rows: Vec<SessionRow> = tables::rows(out)?;
    let Some(b) = b else { return two_outputs(out, rows, a, same_tyres) };
    let wrong = |which: &str, e: String| Error::Usage(format!("{which}: {e}"));
    let pick = |which: &str, text: &str, other: &str| -> Result<Vec<&SessionRow>, Error> {
        if text.trim() != OTHERS {
            return select::select(text, &rows).map_err(|e| wrong(which, e));
        }
        if other.trim() == OTHERS {
            return Err(Error::Usage("both sides are `others`: others than which?".to_owned()));
        }
        let not: Vec<&SessionRow> = select::select(other, &rows).map_err(|e| wrong(which, e))?;
        let rest = rows.iter().filter(|r| !not.iter().any(|n| n.ident.key() == r.ident.key()));
        let rest: Vec<&SessionRow> = rest.collect();
        match rest.is_empty() {
            true => Err(wrong(which, format!("`{other}` is every session; there are no others"))),
            false => Ok(rest),
        }
    };
    let chosen = [pick("A", a, b)?, pick("B", b, a)?];
    let sides = [Chosen::of(a, &chosen[0]), Chosen::of(b, &chosen[1])];
    apart(&sides)?;
    let rest = rest(&rows, &sides);
    intact_of(out, sides.iter())?; // the rest is of the same motorcycles
    let estimates = [
        read::estimates(out, &chosen[0])?,
        read::estimates(out, &chosen[1])?,
        read::estimates(out, &rest)?,
    ];
    let [a, b] = chosen;
    Ok(of_sides(sides, &[a, b, rest], estimates, same_tyres))
}

/// Makes sure that what the tables say of some motorcycles is as it was written.
fn intact_of<'a>(out: &Path, bikes: impl Iterator<Item = &'a Chosen>) -> Result<(), Error> {
    let bikes = bikes.flat_map(Chosen::bikes).collect();
    intact::require_bikes(&Location::from(out), &read::TABLES, &bikes)
}

/// Other sessions of the motorcycles: what they differ by among themselves is what sessions differ by.
fn rest<'a>(rows: &'a [SessionRow], sides: &[Chosen; 2]) -> Vec<&'a SessionRow> {
    let bikes: BTreeSet<&str> = sides.iter().flat_map(Chosen::bikes).collect();
    let is_chosen = |row: &SessionRow| {
        let (bike, session) = row.ident.key();
        sides.iter().any(|s| s.sessions.contains(&(bike.to_owned(), session.to_owned())))
    };
    let other = |row: &&SessionRow| bikes.contains(row.ident.bike_id.as_str()) && !is_chosen(row);
    rows.iter().filter(other).take(MOST_OTHERS).collect()
}

fn require(out: &Path) -> Result<(), Error> {
    match out.is_dir() {
        true => mark::require(&Location::from(out)),
        false => Err(Error::Usage(format!("{} is not a folder", out.display()))),
    }
}

fn two_outputs(
    first: &Path,
    rows: Vec<SessionRow>,
    second: &str,
    same_tyres: bool,
) -> Result<Comparison, Error> {
    let other = Path::new(second);
    if !other.is_dir() {
        let out = first.display();
        return Err(Error::Usage(format!(
            "`{second}` is no folder: give a second output, or two sets of sessions: `roadbench compare {out} A B`"
        )));
    }
    require(other)?;
    let _reading = Reading::of(other)?;
    intact::require_sessions(&Location::from(other))?;
    let others: Vec<SessionRow> = tables::rows(other)?;
    for (rows, at) in [(&rows, first), (&others, other)] {
        if rows.is_empty() {
            return Err(Error::Usage(format!("{} has no sessions", at.display())));
        }
    }
    let chosen: [Vec<&SessionRow>; 2] = [rows.iter().collect(), others.iter().collect()];
    let text = first.display().to_string();
    let sides = [Chosen::of(&text, &chosen[0]), Chosen::of(second, &chosen[1])];
    apart(&sides)?;
    for (out, side) in [first, other].into_iter().zip(&sides) {
        intact_of(out, std::iter::once(side))?;
    }
    let estimates =
        [read::estimates(first, &chosen[0])?, read::estimates(other, &chosen[1])?, BTreeMap::new()];
    let [a, b] = chosen;
    Ok(of_sides(sides, &[a, b, Vec::new()], estimates, same_tyres))
}

/// No session is on both sides.
fn apart([a, b]: &[Chosen; 2]) -> Result<(), Error> {
    let both: Vec<&str> = a.sessions.intersection(&b.sessions).map(|s| s.1.as_str()).collect();
    let Some(first) = both.first() else { return Ok(()) };
    Err(Error::Usage(match (a.sessions == b.sessions, both.len()) {
        (true, _) => {
            "A and B are the same sessions; a set has no difference from itself".to_owned()
        }
        (_, 1) => format!("session `{first}` is in both A and B"),
        (_, n) => format!("`{first}` and {} more are in both A and B", n - 1),
    }))
}

fn of_sides(
    sides: [Chosen; 2],
    chosen: &[Vec<&SessionRow>; 3],
    estimates: [BTreeMap<Key, Estimates>; 3],
    same_tyres: bool,
) -> Comparison {
    let mut sessions = Vec::new();
    let mut statuses: BTreeMap<(String, String), [Vec<RowStatus>; 2]> = BTreeMap::new();
    for (side, (rows, estimates)) in chosen.iter().zip(estimates).enumerate() {
        let tyres: BTreeMap<(&str, &str), [Option<String>; 2]> = rows
            .iter()
            .map(|r| (r.ident.key(), [r.tyre_front.clone(), r.tyre_rear.clone()]))
            .collect();
        for ((bike, session), estimates) in estimates {
            for (name, (status, unit)) in estimates.statuses {
                if let Some(of_side) = statuses.entry(name).or_default().get_mut(side) {
                    of_side.push(RowStatus { status, unit });
                }
            }
            let named = tyres.get(&(bike.as_str(), session.as_str())).cloned().unwrap_or_default();
            let tyres = named.map(|tyre| tyre.or_else(|| same_tyres.then(String::new)));
            sessions.push(Session { bike, session, side, tyres, pieces: estimates.pieces });
        }
    }
    let mut rows: Vec<ComparisonRow> = Vec::new();
    for found in crate::fleet::compare::compare(&sessions) {
        let name = (found.tyre.clone(), found.coefficient.clone());
        let known = statuses.remove(&name).unwrap_or_default();
        rows.push(row(&sides, &found, &known));
    }
    // what no session determines, but for what no ride can
    for ((tyre, coefficient), known) in statuses {
        let is_ridden = Coefficient::from_name(&coefficient)
            .is_none_or(|c| !matches!(c.spec().source, Source::BikeFile(_)));
        if is_ridden {
            let unit = known.iter().flatten().next().map(|t| t.unit.clone()).unwrap_or_default();
            let found = Compared { tyre, coefficient, unit, sides: [None, None], difference: None };
            rows.push(row(&sides, &found, &known));
        }
    }
    rows.sort_by_cached_key(|r| labels::order(&r.tyre, &r.coefficient));
    Comparison { sides, rows }
}

fn row(chosen: &[Chosen; 2], found: &Compared, known: &[Vec<RowStatus>; 2]) -> ComparisonRow {
    let [a, b] = &found.sides;
    let difference = found.difference.as_ref();
    let verdict = difference.map_or(Verdict::NotComparable, |d| d.verdict());
    let decided = matches!(verdict, Verdict::Larger | Verdict::Smaller);
    // the slip stiffness is one of the friction curve
    let by = match found.coefficient == Coefficient::SlipStiffness.name() {
        true => Coefficient::MfD.name(),
        false => &found.coefficient,
    };
    let riding =
        Id::from_names(&found.tyre, by).map(|id| id.requirement().riding.remedy.to_owned());
    let count = |side: &Option<crate::fleet::compare::Side>| {
        side.as_ref().map_or(0, |s| i64::try_from(s.sessions).unwrap_or(i64::MAX))
    };
    let more = |m: Option<usize>| m.and_then(|m| i64::try_from(m).ok());
    let relative = difference.and_then(|d| d.relative);
    ComparisonRow {
        a: chosen[0].text.clone(),
        b: chosen[1].text.clone(),
        tyre: found.tyre.clone(),
        coefficient: found.coefficient.clone(),
        unit: found.unit.clone(),
        verdict: verdict.name().to_owned(),
        value_a: a.as_ref().map(|s| s.value),
        ci95_low_a: a.as_ref().map(|s| s.interval[0]),
        ci95_high_a: a.as_ref().map(|s| s.interval[1]),
        n_sessions_a: count(a),
        value_b: b.as_ref().map(|s| s.value),
        ci95_low_b: b.as_ref().map(|s| s.interval[0]),
        ci95_high_b: b.as_ref().map(|s| s.interval[1]),
        n_sessions_b: count(b),
        difference: difference.map(|d| d.size),
        ci95_low: difference.map(|d| d.interval[0]),
        ci95_high: difference.map(|d| d.interval[1]),
        relative: relative.map(|r| r[0]),
        relative_low: relative.map(|r| r[1]),
        relative_high: relative.map(|r| r[2]),
        probability_larger: difference.map(|d| d.probability),
        false_discovery_rate: difference.map(|d| d.false_discovery),
        between_sd: difference.map(|d| d.between),
        between_assumed: difference.map(|d| d.is_assumed),
        cancelled_share: difference.map(|d| d.cancelled),
        limited_by: difference.map(|d| d.limited_by.0.clone()),
        limited_share: difference.map(|d| d.limited_by.1),
        more_sessions_for_seen: difference.and_then(|d| more(d.more_for_seen)),
        more_sessions_for_5_percent: difference.and_then(|d| more(d.more_for_worth)),
        sentence: match difference {
            Some(d) => sentence(&found.tyre, &found.coefficient, &found.unit, d),
            None => not_comparable(known),
        },
        advice: riding.filter(|_| !decided),
    }
}
