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

/// Changes of each motorcycle with enough rides: the number of unchanged rides, then each change. A motorcycle without
/// changes has one line. Empty if none can be compared.
pub(crate) fn of_motorcycles(rows: &[ChangeRow]) -> String {
    let mut text = String::new();
    for rows in rows.chunk_by(|a, b| a.ident.bike_id == b.ident.bike_id) {
        let Some(head) = head(rows) else { continue };
        text += &format!("{}: {head}\n", rows[0].ident.bike_id);
        for row in rows.iter().filter(|r| is_change(r)) {
            text += &format!("  {}: {}\n", place(row), row.sentence);
        }
    }
    text
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
        cause: number.effect.map(|effect| effect.sentence_of(change.size)),
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
