//! Cells of delimited text to columns of numbers.

use std::io::Read;

use ::csv::{ByteRecord, Reader};

use super::coordinate::Coordinate;
use super::layout::{grouped, number, with_unit};
use super::text::decoded;
use crate::contract::rejection::RejectionCode;
use crate::contract::warning::Warning;
use crate::ingest::clock::stamps::text::{Clock, Kind, seconds};
use crate::ingest::error::Error;
use crate::ingest::maps::units;
use crate::ingest::warning::warning;
use crate::store::objects::Location;

/// Texts of loggers for a missing sample, in capitals or not.
const NO_SAMPLE: [&str; 13] = [
    "nan", "null", "none", "nil", "n/a", "na", "-", "--", "---", "#n/a", "#nv", "#value!",
    "#div/0!",
];

/// Share of a column's cells that may be unreadable before the log is refused.
const BAD_CELLS: f64 = 0.01;

/// Share of the rows that may be left out for their cells before the log is refused.
const BAD_ROWS: f64 = 0.1;

/// How cells are written.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Writing<'a> {
    /// `.` or `,`.
    pub decimal: char,
    /// Cells that mean "no sample", besides empty ones and `nan`.
    pub missing: &'a [String],
    /// Line of the file that the first row stands in, from 1.
    pub first_line: u64,
    /// Cells of a whole row.
    pub width: usize,
    /// Which of the wanted columns holds the stamps: dates and times of day are read there.
    pub clock: Option<usize>,
    /// Units by place in a row: they may stand after the numbers.
    pub units: &'a [String],
    /// Coordinates by place in a row; after those the parts of cells that hold two.
    pub coordinates: &'a [Option<Coordinate>],
}

impl Writing<'_> {
    fn coordinate(&self, place: usize) -> Option<&Coordinate> {
        self.coordinates.get(place)?.as_ref()
    }

    /// The place in a row of a column's cell.
    fn cell(&self, place: usize) -> usize {
        self.coordinate(place).map_or(place, |c| c.cell)
    }
}

/// A column that is wanted: its name and its place in a row.
pub(crate) type Wanted<'a> = (&'a str, usize);

/// Data read from the rows.
#[derive(Debug, Default)]
pub(crate) struct Cells {
    /// As asked for, NaN where there is no number.
    pub columns: Vec<Vec<f64>>,
    /// How the stamps of the clock are written.
    pub kind: Kind,
    /// Cells that were no numbers; rows that are left out.
    pub warnings: Vec<Warning>,
}

/// A column's unreadable cells: how many, the first one's line and text.
type Bad = Option<(usize, u64, String)>;

/// Reads the columns of at most `rows` rows.
///
/// A row that has fewer or more cells than there are names is left out, for nobody knows which cells they are; so are a
/// row of words (the names again, a comment) and a last row that breaks off.
///
/// # Errors
/// The file cannot be read (`unreadable`), too many cells of a column are no numbers (`bad_cell`), or too many rows
/// have not as many cells as there are names (`cell_count`).
pub(crate) fn read(
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
/// The file cannot be read, or as of [`read`] `cell_count`.
pub(crate) fn read_all(
    log: &Location,
    reader: &mut Reader<impl Read>,
    wanted: &[Wanted<'_>],
    writing: Writing<'_>,
    rows: usize,
) -> Result<Cells, Error> {
    cells_of(log, reader, wanted, writing, rows, f64::INFINITY)
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
    let mut odd = Odd::new(wanted.len());
    let mut record = ByteRecord::new();
    let mut clock = Clock::default();
    let (mut count, mut whole) = (0, true);
    while count < rows {
        match reader.read_byte_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(e) => {
                return Err(Error::unreadable(log, &e.into()));
            }
        }
        count += 1;
        let before = whole;
        whole = record.len() == writing.width || odd.fits(&record, writing, before);
        if !whole {
            continue;
        }
        let (mut numbers, mut bad) = (0, false);
        for (k, (column, &(_, place))) in columns.iter_mut().zip(wanted).enumerate() {
            let of_clock = (writing.clock == Some(k)).then_some(&mut clock);
            let cell = match writing.coordinate(place) {
                Some(coordinate) => position(&record, coordinate, writing),
                None => {
                    record.get(place).map_or(Cell::Missing, |c| cell(c, place, writing, of_clock))
                }
            };
            column.push(match cell {
                Cell::Number(x) => {
                    numbers += 1;
                    x
                }
                Cell::Missing => f64::NAN,
                Cell::Bad => {
                    bad = true;
                    f64::NAN
                }
            });
        }
        if bad {
            odd.bad(&record, wanted, writing, numbers, &mut columns);
        }
    }
    if let Some(k) = writing.clock {
        clock.finish(&mut columns[k]);
    }
    let left = columns.first().map_or(0, Vec::len);
    let warnings = odd.judged(log, wanted, (count, left), writing.width, (!whole, most_bad))?;
    Ok(Cells { columns, kind: clock.kind(), warnings })
}

/// Oddities of rows and cells.
struct Odd {
    bad: Vec<Bad>,
    uneven: Uneven,
    /// Whether the row in front of the last one was whole, and the last one is too short.
    cut: bool,
    /// Rows of words: how many, and the first one's line and text.
    words: Bad,
}

impl Odd {
    fn new(columns: usize) -> Self {
        Odd { bad: vec![None; columns], uneven: Uneven::default(), cut: false, words: None }
    }

    /// Whether a row whose cells are not as many as the names is one all the same: what it has more is empty.
    fn fits(&mut self, record: &ByteRecord, writing: Writing<'_>, whole_before: bool) -> bool {
        let more = record.iter().skip(writing.width);
        if record.len() > writing.width && more.clone().all(|c| c.trim_ascii().is_empty()) {
            return true;
        }
        let line = line_of(record, writing);
        // a comment is no row
        if record.get(0).is_some_and(|c| c.trim_ascii_start().starts_with(b"#")) {
            self.words.get_or_insert_with(|| (0, line, text_of(record))).0 += 1;
            return false;
        }
        self.cut = whole_before && record.len() < writing.width;
        self.uneven.note(line, record.len(), &text_of(record));
        false
    }

    /// Notes the cells of a row that are no numbers; a row without any number is taken out again.
    fn bad(
        &mut self,
        record: &ByteRecord,
        wanted: &[Wanted<'_>],
        writing: Writing<'_>,
        numbers: usize,
        columns: &mut [Vec<f64>],
    ) {
        let line = line_of(record, writing);
        let words = |cell: &[u8]| !cell.iter().any(u8::is_ascii_digit);
        let of = |place: usize| record.get(writing.cell(place)).unwrap_or_default();
        let name = |&(name, place): &Wanted<'_>| decoded(of(place)).trim() == name;
        let all_words = wanted.iter().all(|w| words(of(w.1)) || name(w));
        if numbers == 0 && wanted.len() > 1 && all_words {
            for column in columns.iter_mut() {
                column.pop();
            }
            self.words.get_or_insert_with(|| (0, line, text_of(record))).0 += 1;
            return;
        }
        for ((bad, &(_, place)), column) in self.bad.iter_mut().zip(wanted).zip(columns.iter()) {
            let cell = of(place);
            let missing =
                cell.trim_ascii().is_empty() || column.last().is_some_and(|x| !x.is_nan());
            let means_none = || writing.missing.iter().any(|m| m.as_bytes() == cell.trim_ascii());
            let is_usual =
                || NO_SAMPLE.iter().any(|w| cell.trim_ascii().eq_ignore_ascii_case(w.as_bytes()));
            if !missing && !means_none() && !is_usual() {
                bad.get_or_insert_with(|| (0, line, decoded(cell))).0 += 1;
            }
        }
    }

    /// Warnings, as long as it is little. `rows` are those of the file and those that are left.
    fn judged(
        self,
        log: &Location,
        wanted: &[Wanted<'_>],
        (all, left): (usize, usize),
        width: usize,
        (last_is_odd, most_bad): (bool, f64),
    ) -> Result<Vec<Warning>, Error> {
        let mut warnings = Vec::new();
        let cut = self.cut && last_is_odd;
        let Odd { bad, mut uneven, words, .. } = self;
        uneven.count -= usize::from(cut);
        warnings.extend(uneven.judged(log, all, width)?);
        if cut {
            let message =
                "the last row is incomplete and left out; is the file cut off?".to_owned();
            warnings.push(warning("cut_off", None, 1, None, message));
        }
        if let Some((count, line, text)) = words {
            let message = format!(
                "{count} rows of words among the numbers are left out, the first in line {line}: `{text}`"
            );
            warnings.push(warning("bad_line", None, count, None, message));
        }
        for (&(name, _), bad) in wanted.iter().zip(bad) {
            if let Some(bad) = bad {
                warnings.push(judged(name, bad, left, most_bad)?);
            }
        }
        Ok(warnings)
    }
}

/// Rows that have another number of cells than there are names.
#[derive(Debug, Default)]
pub(crate) struct Uneven {
    count: usize,
    /// Line, cells and text of the first.
    first: Option<(u64, usize, String)>,
}

impl Uneven {
    /// Notes such a row.
    pub(crate) fn note(&mut self, line: u64, cells: usize, text: &str) {
        self.count += 1;
        self.first.get_or_insert_with(|| (line, cells, text.chars().take(60).collect()));
    }

    /// A warning as long as they are few of `all` rows.
    ///
    /// # Errors
    /// `cell_count`: they are many.
    pub(crate) fn judged(
        self,
        log: &Location,
        all: usize,
        width: usize,
    ) -> Result<Option<Warning>, Error> {
        let (count, Some((line, cells, text))) = (self.count, self.first) else { return Ok(None) };
        if count == 0 {
            return Ok(None);
        }
        let message = format!(
            "{log}: {count} of {all} rows do not have {width} cells, one for each name: the first, \
             line {line}, has {cells}: `{text}`"
        );
        if count as f64 > BAD_ROWS * all as f64 {
            let hint = "; a separator is missing or too many (a decimal comma without quotes?), or cells at the end \
                        are left out: write the file so that every row has a cell for each name";
            return Err(Error::new(RejectionCode::CellCount, message + hint));
        }
        let message =
            message + "; they are left out because the cells cannot be assigned to columns";
        Ok(Some(warning("bad_line", None, count, None, message)))
    }
}

/// The line of the file that a row stands in.
fn line_of(record: &ByteRecord, writing: Writing<'_>) -> u64 {
    record.position().map_or(0, |p| p.line() - 1) + writing.first_line
}

/// The beginning of a row, for messages.
fn text_of(record: &ByteRecord) -> String {
    let cells: Vec<String> = record.iter().map(decoded).collect();
    cells.join(", ").chars().take(60).collect()
}

/// Unreadable cells are a warning as long as they are few.
fn judged(
    name: &str,
    (bad, line, text): (usize, u64, String),
    rows: usize,
    most: f64,
) -> Result<Warning, Error> {
    let text: String = text.trim().chars().take(40).collect();
    let message = format!(
        "column `{name}`: {bad} of {rows} cells are not numbers, the first is `{text}` in line \
         {line}"
    );
    if bad as f64 > most * rows as f64 {
        return Err(Error::new(RejectionCode::BadCell, message + &hint(&text)));
    }
    Ok(warning("bad_cell", None, bad, None, message + "; taken as missing"))
}

/// Advice about a cell that is no number.
fn hint(text: &str) -> String {
    if let Some((_, unit)) = with_unit(text) {
        return format!(
            "; the unit follows the number: remove it, or write it after the column's name, `name ({unit})`"
        );
    }
    if seconds(text).is_some() {
        return "; it is a time: times are read only in the column of the map's [time], all in one form".to_owned();
    }
    if text.contains(',') && number(text, ',').is_some() {
        return "; if it is a decimal comma, write `csv.decimal = \",\"` in the map".to_owned();
    }
    "; list it in the map's `csv.missing` if it means no sample; stamps are numbers, \
     `hh:mm:ss.sss`, or dates with a time of day as in ISO 8601"
        .to_owned()
}

enum Cell {
    Number(f64),
    Missing,
    Bad,
}

/// One cell. Infinities are no measurement, so they are missing.
#[inline]
fn cell(bytes: &[u8], place: usize, writing: Writing<'_>, clock: Option<&mut Clock>) -> Cell {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return with_its_unit(&decoded(bytes), place, writing);
    };
    let text = text.trim();
    if text.is_empty() || writing.missing.iter().any(|m| m == text) {
        return Cell::Missing;
    }
    match (number(text, writing.decimal), clock) {
        (Some(x), Some(clock)) if x.is_finite() => match clock.read_number(text) {
            Some(x) => Cell::Number(x),
            // a number among dates
            None if clock.kind() != Kind::Numbers => Cell::Bad,
            None => Cell::Number(x),
        },
        (Some(_), Some(clock)) if clock.kind() != Kind::Numbers => Cell::Bad,
        (Some(x), _) if x.is_finite() => Cell::Number(x),
        (Some(_), _) => Cell::Missing,
        (None, Some(clock)) => match clock.read(text) {
            Some(x) => Cell::Number(x),
            None => with_its_unit(text, place, writing),
        },
        (None, None) => with_its_unit(text, place, writing),
    }
}

/// A cell of a position.
fn position(record: &ByteRecord, coordinate: &Coordinate, writing: Writing<'_>) -> Cell {
    let text = record.get(coordinate.cell).unwrap_or_default().trim_ascii();
    if writing.missing.iter().any(|m| m.as_bytes() == text) {
        return Cell::Missing;
    }
    match coordinate.read(record, writing.decimal) {
        Ok(number) => number.map_or(Cell::Missing, Cell::Number),
        // a column like it may hold what is none: a number in another unit
        Err(()) => cell(text, coordinate.cell, writing, None),
    }
}

/// A number in groups of three digits, or with its column's unit after it.
fn with_its_unit(text: &str, place: usize, writing: Writing<'_>) -> Cell {
    if let Some(x) = grouped(text, writing.decimal) {
        return Cell::Number(x);
    }
    let own = writing.units.get(place).filter(|u| !u.is_empty());
    let number = own.and_then(|own| {
        let (text, unit) = with_unit(text)?;
        number(text, writing.decimal).filter(|_| units::same(own, unit) == Some(true))
    });
    number.map_or(Cell::Bad, Cell::Number)
}
