//! Cells of delimited text to columns of numbers.

use std::io::Read;

use ::csv::{ByteRecord, Reader};

use super::text::decoded;
use crate::contract::warning::Warning;
use crate::ingest::error::Error;
use crate::ingest::warning::warning;
use crate::objects::Location;

/// Share of a column's cells that may be unreadable before the log is refused.
const BAD_CELLS: f64 = 0.01;

/// How cells are written.
#[derive(Debug, Clone, Copy)]
pub struct Writing<'a> {
    /// `.` or `,`.
    pub decimal: char,
    /// Cells that mean "no sample", besides empty ones and `nan`.
    pub missing: &'a [String],
    /// Line of the file that the first row stands in, from 1.
    pub first_line: u64,
    /// Cells of a whole row.
    pub width: usize,
}

/// A column that is wanted: its name and its place in a row.
pub type Wanted<'a> = (&'a str, usize);

/// What is read of the rows.
#[derive(Debug, Default)]
pub struct Cells {
    /// As asked for, NaN where there is no number.
    pub columns: Vec<Vec<f64>>,
    /// Cells that were no numbers; a row that breaks off.
    pub warnings: Vec<Warning>,
}

/// A column's unreadable cells: how many, the first one's line and text.
type Bad = Option<(usize, u64, String)>;

/// Reads the columns of at most `rows` rows.
///
/// A last row that breaks off before its last cell is left out: its own last number may be half.
///
/// # Errors
/// The file cannot be read (`unreadable`), or too many cells of a column are no numbers
/// (`bad_cell`).
pub fn read(
    log: &Location,
    reader: &mut Reader<impl Read>,
    wanted: &[Wanted<'_>],
    writing: Writing<'_>,
    rows: usize,
) -> Result<Cells, Error> {
    cells_of(log, reader, wanted, writing, rows, BAD_CELLS)
}

/// Reads columns of which nothing is known: what is no number is missing, however much it is.
///
/// # Errors
/// The file cannot be read.
pub fn read_all(
    log: &Location,
    reader: &mut Reader<impl Read>,
    wanted: &[Wanted<'_>],
    writing: Writing<'_>,
) -> Result<Cells, Error> {
    cells_of(log, reader, wanted, writing, usize::MAX, f64::INFINITY)
}

fn cells_of(
    log: &Location,
    reader: &mut Reader<impl Read>,
    wanted: &[Wanted<'_>],
    writing: Writing<'_>,
    rows: usize,
    most_bad: f64,
) -> Result<Cells, Error> {
    let mut columns = vec![Vec::new(); wanted.len()];
    let mut bad: Vec<Bad> = vec![None; wanted.len()];
    let mut record = ByteRecord::new();
    let (mut count, mut cells) = (0, [writing.width; 2]);
    while count < rows {
        match reader.read_byte_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(e) => {
                return Err(Error::unreadable(log, &e.into()));
            }
        }
        count += 1;
        cells = [cells[1], record.len()];
        for ((column, &(_, place)), bad) in columns.iter_mut().zip(wanted).zip(&mut bad) {
            let value = match record.get(place).map_or(Cell::Missing, |c| cell(c, writing)) {
                Cell::Number(x) => x,
                Cell::Missing => f64::NAN,
                Cell::Bad => {
                    let before = record.position().map_or(0, |p| p.line() - 1);
                    let text = || decoded(&record[place]);
                    bad.get_or_insert_with(|| (0, before + writing.first_line, text())).0 += 1;
                    f64::NAN
                }
            };
            column.push(value);
        }
    }
    let mut read = Cells { columns, warnings: Vec::new() };
    // shorter than whole rows and than the row before: the file was cut there
    if count < rows && count > 1 && cells[1] < writing.width.min(cells[0]) {
        count -= 1;
        read.columns.iter_mut().for_each(|c| c.truncate(count));
        let message = "the last row breaks off and is left out; was the file cut?".to_owned();
        read.warnings.push(warning("cut_off", None, 1, None, message));
    }
    for (&(name, _), bad) in wanted.iter().zip(bad) {
        if let Some(bad) = bad {
            read.warnings.push(judged(name, bad, count, most_bad)?);
        }
    }
    Ok(read)
}

/// Unreadable cells are a warning as long as they are few.
fn judged(
    name: &str,
    (bad, line, text): (usize, u64, String),
    rows: usize,
    most: f64,
) -> Result<Warning, Error> {
    let text: String = text.chars().take(40).collect();
    let message = format!(
        "column `{name}`: {bad} of {rows} cells are not numbers, the first is `{text}` in line \
         {line}"
    );
    if bad as f64 > most * rows as f64 {
        let hint = "; name it in the map's `csv.missing` if it means no sample";
        return Err(Error::new("bad_cell", message + hint));
    }
    Ok(warning("bad_cell", None, bad, None, message + "; taken as missing"))
}

enum Cell {
    Number(f64),
    Missing,
    Bad,
}

/// One cell. Infinities are no measurement, so they are missing.
fn cell(bytes: &[u8], writing: Writing<'_>) -> Cell {
    let Ok(text) = std::str::from_utf8(bytes) else { return Cell::Bad };
    let text = text.trim();
    if text.is_empty() || writing.missing.iter().any(|m| m == text) {
        return Cell::Missing;
    }
    match number(text, writing.decimal) {
        Some(x) if x.is_finite() => Cell::Number(x),
        Some(_) => Cell::Missing,
        None => Cell::Bad,
    }
}

/// The number that a text is, if it is one; a date with a time of day is its Unix time, s.
pub fn number(text: &str, decimal: char) -> Option<f64> {
    let number = if decimal == ',' && text.contains(',') {
        text.replace(',', ".").parse().ok()
    } else {
        text.parse().ok()
    };
    number.or_else(|| unix_time(text))
}

/// Unix seconds of an ISO 8601 date with a time of day; without an offset it is taken for that of UTC.
fn unix_time(text: &str) -> Option<f64> {
    let bytes = text.as_bytes();
    if bytes.len() < 16 || bytes[4] != b'-' || bytes[13] != b':' {
        return None; // most cells are none: parsing costs
    }
    let stamp = text.parse::<jiff::Timestamp>().ok().or_else(|| {
        let civil: jiff::civil::DateTime = text.parse().ok()?;
        Some(civil.to_zoned(jiff::tz::TimeZone::UTC).ok()?.timestamp())
    })?;
    Some(stamp.as_nanosecond() as f64 * 1e-9)
}
