//! Changes in words.

use super::difference::Difference;
use super::numbers::{History, Number};
use super::search::Change;
use crate::report::change_sentence::{self, Parts};
use crate::report::{parameter_words, readable};
use crate::statistics::number_format::{decimals, fixed};
use crate::statistics::order::median_of_finite;
use crate::store::tables::changes::{head, is_change, place};
use crate::store::tables::rows::ChangeRow;

/// Motorcycles without a change that have a line each; more of them share one.
const QUIET: usize = 3;
/// Most motorcycles that a line lists.
const LISTED: usize = 12;

/// Changes of each motorcycle with enough rides: the number of unchanged rides, then each change. A motorcycle without
/// changes has one line; of many that line is one for all of them. Empty if none can be compared.
pub(crate) fn of_motorcycles(rows: &[ChangeRow]) -> String {
    let bikes = rows.chunk_by(|a, b| a.ident.bike_id == b.ident.bike_id);
    let compared: Vec<(&[ChangeRow], String)> =
        bikes.filter_map(|rows| Some((rows, head(rows)?))).collect();
    let is_quiet = |rows: &[ChangeRow]| rows.iter().all(|r| r.verdict == "as_before");
    let quiet: Vec<&[ChangeRow]> =
        compared.iter().map(|(rows, _)| *rows).filter(|rows| is_quiet(rows)).collect();
    let is_joined = quiet.len() > QUIET;
    let mut text = if is_joined { joined(&quiet) } else { String::new() };
    for (rows, head) in &compared {
        if is_joined && is_quiet(rows) {
            continue;
        }
        text += &format!("{}: {head}\n", rows[0].ident.bike_id);
        for row in rows.iter().filter(|r| is_change(r)) {
            text += &format!("  {}: {}\n", place(row), row.sentence);
        }
    }
    text
}

/// The line of motorcycles without a change.
fn joined(quiet: &[&[ChangeRow]]) -> String {
    let rides: usize = quiet.iter().map(|rows| rows.len()).sum();
    let ids: Vec<&str> =
        quiet.iter().take(LISTED).map(|rows| rows[0].ident.bike_id.as_str()).collect();
    let more = quiet.len() - ids.len();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{} motorcycles: all {rides} rides as before ({}{more})\n", quiet.len(), ids.join(", "))
}

/// A change as a sentence.
pub(crate) fn sentence(history: &History, change: &Change) -> String {
    let number = &history.numbers[change.cause];
    let rivals: Vec<&str> =
        change.rivals.iter().map(|p| history.numbers[*p].name.as_str()).collect();
    change_sentence::sentence(&Parts {
        what: match number.effect {
            Some(_) => &number.name,
            None => parameter_words::parameter(&number.name),
        },
        size: &size(history, change),
        rides: change.rides.name(),
        counts: change.rides.counts(),
        cause: match change.swap {
            Some(swap) => Some(swap.swap_sentence()),
            None => number.effect.map(|effect| effect.sentence_of(change.size)),
        },
        rivals: &rivals,
    })
}

/// The size of a change with its interval: of what is friction, stiffness, drag or a brake as a share of its usual value.
fn size(history: &History, change: &Change) -> String {
    let number = &history.numbers[change.cause];
    if number.effect.is_none() && parameter_words::is_logarithm(&number.name) {
        let ratio = (-change.size).exp();
        return change_sentence::size(ratio - 1.0, ratio * change.half_width, (" %", 100.0));
    }
    let usual = median_of_finite(&history.values[change.cause]).unwrap_or(0.0).abs();
    if number.effect.is_none() && usual > 0.0 && parameter_words::is_relative(&number.name) {
        return change_sentence::size(change.size, change.half_width, (" %", 100.0 / usual));
    }
    let (unit, factor) = unit(number);
    change_sentence::size(change.size, change.half_width, (&unit, factor))
}

/// The unit that a number is read in, with the blank before it, and the factor to it. A share that is no effect's stays one:
/// per cent of it would be read as relative.
fn unit(number: &Number) -> (String, f64) {
    readable::unit(number.effect.map_or("", |effect| effect.name), &number.unit)
}

/// A number that moved, by how much, and over its standard error: `radius_front 0.61 mm (t 7.3)`.
pub(crate) fn moved(number: &Number, by: Difference) -> String {
    let (unit, factor) = unit(number);
    let value = fixed(by.size * factor, decimals(by.error * factor));
    format!("{} {value}{unit} (t {:.1})", number.name, by.t())
}
