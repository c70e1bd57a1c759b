//! A table of delimited text with lines of its source's own above it.
//!
//! Where the names stand, what separates cells and how decimals are written is found out from the
//! text itself: loggers write it as the computer's country does.

use std::io::{BufRead, BufReader, Cursor, Read};

use ::csv::Reader;

use super::layout::{self, Squeezed, cells};
use super::text::{Text, decoded};
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;
use crate::ingest::formats::format::HEAD_LEN;
use crate::store::objects::{Location, source};

/// Lines in which the first row of numbers must come.
const MOST_LINES: usize = 1000;

/// Rows between names and numbers, at most.
const MOST_NOTES: usize = 4;

/// Rows of numbers that are looked at for a decimal comma.
const LOOKED_AT: usize = 50;

/// Bytes of a text that are looked at as a sample of its rows.
pub(super) const SAMPLE: usize = 1 << 16;

/// Rows of it, at most.
const SAMPLED: usize = 400;

/// A text that is open at its first row of numbers.
pub(crate) struct Table {
    /// The lines above the names, split into cells.
    pub above: Vec<Vec<String>>,
    /// The names as written, one per cell.
    pub names: Vec<String>,
    /// The rows between names and numbers (units, say), blank ones left out.
    pub notes: Vec<Vec<String>>,
    /// Between cells.
    pub delimiter: u8,
    /// `.` or `,`.
    pub decimal: char,
    /// Lines above the row of names; a line break in quotes begins none.
    pub names_line: usize,
    /// Lines between the names and the first row of numbers.
    pub lines_below: usize,
    /// Line of the first row of numbers, from 1; a line break in quotes begins one.
    pub first_line: u64,
    /// The rows of numbers.
    pub rows: Reader<Squeezed<Box<dyn Read>>>,
    /// The first of them, as it is written.
    pub first: String,
    /// Cells of the first rows.
    pub sample: Vec<Vec<String>>,
}

/// Opens a text.
///
/// The names stand in the last row above the numbers whose first cell is one of `begin`; if there
/// is none, in the one before the last `notes` rows above the numbers. Numbers begin where the
/// first cell is one; of a text of which nothing is known (no `begin`) where most cells are.
///
/// # Errors
/// The file cannot be read, or has no such row.
pub(crate) fn open(log: &Location, begin: &[&str], notes: usize) -> Result<Table, Error> {
    let file = source::open(log).map_err(|e| Error::unreadable(log, &e))?;
    read(log, file, begin, notes)
}

/// As [`open`], of a text wherever it is; `log` is for messages.
///
/// # Errors
/// As [`open`].
pub(crate) fn read(
    log: &Location,
    file: impl Read + 'static,
    begin: &[&str],
    notes: usize,
) -> Result<Table, Error> {
    let fail = |e: std::io::Error| Error::unreadable(log, &e);
    let mut text = BufReader::with_capacity(SAMPLE, Text::new(file).map_err(fail)?);
    let mut lines: Vec<String> = Vec::new();
    let mut first = Vec::new();
    let mut breaks = 0;
    loop {
        breaks += layout::line(&mut text, HEAD_LEN, &mut first).map_err(fail)?;
        let line = decoded(&first);
        let line = line.trim_end_matches(['\r', '\n']);
        let numbers = layout::is_row(line, begin.is_empty());
        // numbers before any line of words belong to those words
        if first.is_empty() || (!lines.is_empty() && numbers) {
            break;
        }
        lines.push(line.to_owned());
        if lines.len() > MOST_LINES {
            let message = format!("{log}: no row of numbers in {MOST_LINES} lines");
            return Err(Error::new(RejectionCode::NoTable, message));
        }
    }
    if first.is_empty() && begin.is_empty() {
        let message = format!("{log} has no row of numbers");
        return Err(Error::new(RejectionCode::NoTable, message));
    }
    let first_line = lines.len() as u64 + 1 + breaks;
    let numbers = decoded(&first);
    let numbers = numbers.trim_end_matches(['\r', '\n']).to_owned();
    let Some(at) = names_row(&lines, begin, notes, &numbers) else {
        let message = format!("{log}: no row of names above the numbers");
        return Err(Error::new(RejectionCode::NoTable, message));
    };
    let delimiter = layout::delimiter(&lines[at], &numbers);
    let more = decoded(text.fill_buf().map_err(fail)?);
    let rows = std::iter::once(numbers.as_str()).chain(more.lines().take(LOOKED_AT));
    let decimal = layout::decimal(rows, delimiter);
    let sample = sample(&numbers, &more, delimiter);
    let mut below: Vec<Vec<String>> =
        lines[at + 1..].iter().map(|l| cells(l, delimiter)).filter(|c| !is_blank(c)).collect();
    below.truncate(MOST_NOTES);
    let rest: Box<dyn Read> = Box::new(Cursor::new(first).chain(text));
    Ok(Table {
        above: lines[..at].iter().map(|l| cells(l, delimiter)).collect(),
        names: layout::names(&lines[at], delimiter, &numbers),
        notes: below,
        delimiter,
        decimal,
        names_line: at,
        lines_below: lines.len() - at - 1,
        first_line,
        rows: layout::reader(delimiter, rest),
        first: numbers,
        sample,
    })
}

/// Cells of the first rows: the first of them, and those that are in memory after it.
pub(super) fn sample(first: &str, more: &str, delimiter: u8) -> Vec<Vec<String>> {
    // the last line may be cut
    let whole = more.rsplit_once('\n').map_or("", |w| w.0);
    let rows = std::iter::once(first).chain(whole.lines()).filter(|l| !l.trim().is_empty());
    rows.take(SAMPLED).map(|line| cells(line, delimiter)).collect()
}

/// Which line holds the names. Where nothing is known of them they are as many as the row of numbers has cells: what
/// has fewer or more is a comment.
fn names_row(lines: &[String], begin: &[&str], notes: usize, row: &str) -> Option<usize> {
    let known = |line: &String| {
        let first = line.split([',', ';', '\t']).next().unwrap_or("");
        begin.contains(&first.trim().trim_matches('"').trim())
    };
    let blank = |line: &&String| line.chars().all(|c| ",;|\t\" ".contains(c));
    lines.iter().rposition(known).or_else(|| {
        let words: Vec<usize> = (0..lines.len()).rev().filter(|&i| !blank(&&lines[i])).collect();
        let whole = |i: &usize| {
            let delimiter = layout::delimiter(&lines[*i], row);
            let wanted = cells(row, delimiter).len();
            wanted > 1 && layout::names(&lines[*i], delimiter, row).len() == wanted
        };
        let alike: Vec<usize> = words.iter().copied().filter(whole).collect();
        if begin.is_empty() && alike.len() > notes { alike.get(notes) } else { words.get(notes) }
            .copied()
    })
}

fn is_blank(cells: &[String]) -> bool {
    cells.iter().all(String::is_empty)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &[u8], begin: &[&str], notes: usize) -> Result<Table, Error> {
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), text).expect("written");
        open(&file.path().into(), begin, notes)
    }

    #[test]
    fn names_are_the_last_such_row_above_the_numbers() {
        let text = b"Format,AiM CSV File\nTime,3:42 PM\nSample Rate,20\n,,\nTime,GPS Speed,Lap\n\
            s,km/h,\n,,\n0.00,12.5,1\n0.05,12.7,1\n";
        let mut table = table(text, &["Time"], 1).expect("a table");
        assert_eq!(table.names, ["Time", "GPS Speed", "Lap"]);
        assert_eq!(table.notes, [["s", "km/h", ""]]);
        assert_eq!((table.delimiter, table.decimal, table.first_line), (b',', '.', 8));
        assert_eq!(table.above[1], ["Time", "3:42 PM"]);
        assert_eq!(table.rows.records().count(), 2);
    }

    #[test]
    fn other_countries_write_otherwise() {
        let text = b"\"Time\";\"T [\xb0C]\"\n\"s\";\"\xb0C\"\n\n\"0,000\";\"20,5\"\n";
        let table = table(text, &["Time"], 1).expect("a table");
        assert_eq!((table.delimiter, table.decimal), (b';', ','));
        assert_eq!((table.names[1].as_str(), table.notes[0][1].as_str()), ("T [°C]", "°C"));
    }

    #[test]
    fn without_a_known_first_cell_the_rows_are_counted() {
        let text = b"Format,MoTeC CSV File\nSample Rate,50\n\nDistance,RPM\nm,rpm\n\n0,4000\n";
        let table = table(text, &["Time"], 1).expect("a table");
        assert_eq!(table.names, ["Distance", "RPM"]);
        assert_eq!(table.notes, [["m", "rpm"]]);
    }

    #[test]
    fn no_table_is_said() {
        assert_eq!(table(b"words\n", &["Time"], 1).err().expect("none").code.as_str(), "no_table");
        let many = "words and words\n".repeat(MOST_LINES + 2);
        assert_eq!(
            table(many.as_bytes(), &["Time"], 1).err().expect("none").code.as_str(),
            "no_table"
        );
        assert_eq!(table(b"a, b\nc, d\n", &[], 0).err().expect("prose").code.as_str(), "no_table");
        // a first column of words
        let text = b"mode,v,w\non,1,2\noff,2,3\n";
        assert_eq!(table(text, &[], 0).expect("a table").names, ["mode", "v", "w"]);
        // cut before the first number
        let cut = table(b"Time,v\ns,m/s\n", &["Time"], 1).expect("names at least");
        assert_eq!(cut.names, ["Time", "v"]);
    }
}
