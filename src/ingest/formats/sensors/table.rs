//! One text of many: a table whose first column is the clock.

use std::io::Cursor;

use crate::contract::warning::Warning;
use crate::ingest::error::Error;
use crate::ingest::formats::csv::{cells, table};
use crate::ingest::formats::streams::{MAX_STREAMS, Streams};
use crate::store::objects::Location;

/// A text as numbers.
#[derive(Debug)]
pub(super) struct Text {
    /// Its name without folders and ending.
    pub stem: String,
    /// Of its columns; the first is the clock.
    pub names: Vec<String>,
    /// As many as names, NaN where there is no number; dates in s since 1970.
    pub columns: Vec<Vec<f64>>,
}

/// The names of a text's columns, of its first line.
pub(super) fn names(bytes: &[u8]) -> Vec<String> {
    let line = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
    let line = String::from_utf8_lossy(line);
    let line = line.trim_start_matches('\u{feff}').trim_end();
    let between = [';', '\t', ','].into_iter().find(|c| line.contains(*c)).unwrap_or(',');
    line.split(between).map(|cell| cell.trim().trim_matches('"').to_owned()).collect()
}

/// Lines below the names that begin with a number.
pub(super) fn rows(bytes: &[u8]) -> usize {
    let number = |line: &&[u8]| {
        let line = line.trim_ascii();
        line.strip_prefix(b"-").unwrap_or(line).first().is_some_and(u8::is_ascii_digit)
    };
    bytes.split(|b| *b == b'\n').skip(1).filter(number).count()
}

/// The whole text; `None` of one without rows. Rows without a stamp are left out, with a warning. Of the column `dates`
/// the cells are dates.
///
/// # Errors
/// It is no table.
pub(super) fn read(
    label: &Location,
    stem: &str,
    bytes: Vec<u8>,
    dates: Option<&str>,
    streams: &mut Streams,
) -> Result<Option<Text>, Error> {
    let rows = bytes.split(|b| *b == b'\n').filter(|l| !l.trim_ascii().is_empty());
    if rows.take(2).count() < 2 {
        return Ok(None);
    }
    let mut table = table::read(label, Cursor::new(bytes), &["time", "Time (s)", "cts"], 0)?;
    let mut names = std::mem::take(&mut table.names);
    let width = names.len();
    names.truncate(MAX_STREAMS);
    let dates = dates.and_then(|dates| names.iter().position(|n| n == dates));
    let places: Vec<cells::Wanted<'_>> =
        names.iter().enumerate().map(|(place, name)| (name.as_str(), place)).collect();
    let writing = cells::Writing {
        decimal: table.decimal,
        missing: &[],
        first_line: table.first_line,
        width,
        clock: dates,
        units: &[],
        coordinates: &[],
    };
    let read = cells::read_all(label, &mut table.rows, &places, writing, usize::MAX)?;
    let mut columns = read.columns;
    // a column of words alone is no channel
    let wordy = |(_, values): &(&String, &Vec<f64>)| !values.iter().any(|v| v.is_finite());
    let words: Vec<String> =
        names.iter().zip(&columns).filter(wordy).map(|(name, _)| format!("`{name}`")).collect();
    let is_of_words =
        |w: &Warning| w.code == "bad_cell" && words.iter().any(|n| w.message.contains(n));
    for mut warning in read.warnings.into_iter().filter(|w| !is_of_words(w)) {
        warning.message = format!("`{stem}`: {}", warning.message);
        streams.warnings.push(warning);
    }
    let there: Vec<bool> =
        columns.first().map_or(vec![], |c| c.iter().map(|t| t.is_finite()).collect());
    let lost = there.iter().filter(|t| !**t).count();
    if lost > 0 {
        for column in &mut columns {
            let mut kept = there.iter();
            column.retain(|_| kept.next().is_some_and(|k| *k));
        }
        let message = format!("{lost} rows of `{stem}` have no time and are left out");
        streams.warn("time_missing", lost, message);
    }
    Ok(Some(Text { stem: stem.to_owned(), names, columns }))
}
