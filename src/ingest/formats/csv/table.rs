//! A table of delimited text with lines of its source's own above it.
//!
//! Where the names stand, what separates cells and how decimals are written is found out from the
//! text itself: loggers write it as the computer's country does.

use std::io::{BufRead, BufReader, Cursor, Read};

use ::csv::{Reader, ReaderBuilder};

use super::cells::number;
use super::text::{Text, decoded};
use crate::ingest::error::Error;
use crate::ingest::format::HEAD_LEN;
use crate::objects::{Location, source};

/// Lines in which the first row of numbers must come.
const MOST_LINES: usize = 1000;

/// Rows between names and numbers, at most.
const MOST_NOTES: usize = 4;

/// A text that is open at its first row of numbers.
pub struct Table {
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
    /// Lines above the row of names.
    pub names_line: usize,
    /// Line of the first row of numbers, from 1.
    pub first_line: u64,
    /// The rows of numbers.
    pub rows: Reader<Box<dyn Read>>,
}

/// Opens a text.
///
/// The names stand in the last row above the numbers whose first cell is one of `begin`; if there
/// is none, in the one before the last `notes` rows above the numbers. Numbers begin where the
/// first cell is one; of a text of which nothing is known (no `begin`) where most cells are.
///
/// # Errors
/// The file cannot be read, or has no such row.
pub fn open(log: &Location, begin: &[&str], notes: usize) -> Result<Table, Error> {
    let fail = |e: std::io::Error| Error::unreadable(log, &e);
    let file = source::open(log).map_err(fail)?;
    let mut text = BufReader::new(Text::new(file).map_err(fail)?);
    let mut lines: Vec<String> = Vec::new();
    let mut first = Vec::new();
    loop {
        first.clear();
        (&mut text).take(HEAD_LEN).read_until(b'\n', &mut first).map_err(fail)?;
        let line = decoded(&first);
        let line = line.trim_end_matches(['\r', '\n']);
        let numbers = begins_with_number(line) || (begin.is_empty() && mostly_numbers(line));
        // numbers before any line of words belong to those words
        if first.is_empty() || (!lines.is_empty() && numbers) {
            break;
        }
        lines.push(line.to_owned());
        if lines.len() > MOST_LINES {
            let message = format!("{log}: no row of numbers in {MOST_LINES} lines");
            return Err(Error::new("no_table", message));
        }
    }
    if first.is_empty() && begin.is_empty() {
        let message = format!("{log} has no row of numbers");
        return Err(Error::new("no_table", message));
    }
    let first_line = lines.len() as u64 + 1;
    let Some(at) = names_row(&lines, begin, notes) else {
        let message = format!("{log}: no row of names above the numbers");
        return Err(Error::new("no_table", message));
    };
    let delimiter = delimiter(&lines[at]);
    let numbers = decoded(&first);
    let decimal = decimal(&numbers, delimiter);
    let mut below: Vec<Vec<String>> =
        lines[at + 1..].iter().map(|l| cells(l, delimiter)).filter(|c| !is_blank(c)).collect();
    below.truncate(MOST_NOTES);
    let names = cells(&lines[at], delimiter);
    let rest: Box<dyn Read> = Box::new(Cursor::new(first).chain(text));
    Ok(Table {
        above: lines[..at].iter().map(|l| cells(l, delimiter)).collect(),
        names,
        notes: below,
        delimiter,
        decimal,
        names_line: at,
        first_line,
        rows: ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(delimiter)
            .from_reader(rest),
    })
}

/// Which line holds the names.
fn names_row(lines: &[String], begin: &[&str], notes: usize) -> Option<usize> {
    let named = |line: &String| {
        let first = line.split([',', ';', '\t']).next().unwrap_or("");
        begin.contains(&first.trim().trim_matches('"').trim())
    };
    let blank = |line: &&String| line.chars().all(|c| ",;\t\" ".contains(c));
    lines.iter().rposition(named).or_else(|| {
        let words: Vec<usize> = (0..lines.len()).rev().filter(|&i| !blank(&&lines[i])).collect();
        words.get(notes).copied()
    })
}

/// The most frequent of what can be between cells.
pub fn delimiter(line: &str) -> u8 {
    let mut quoted = false;
    let mut counts = [0; 3];
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            '\t' if !quoted => counts[0] += 1,
            ';' if !quoted => counts[1] += 1,
            ',' if !quoted => counts[2] += 1,
            _ => {}
        }
    }
    let most = counts.iter().max().copied().unwrap_or(0);
    match counts.iter().position(|c| *c == most) {
        Some(0) if most > 0 => b'\t',
        Some(1) if most > 0 => b';',
        _ => b',',
    }
}

/// A comma is a decimal one where it does not separate cells.
fn decimal(line: &str, delimiter: u8) -> char {
    let comma = |cell: &String| cell.contains(',') && number(cell, ',').is_some();
    if delimiter != b',' && cells(line, delimiter).iter().any(comma) { ',' } else { '.' }
}

/// A line's cells, without quotes and blanks around them.
pub fn cells(line: &str, delimiter: u8) -> Vec<String> {
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(delimiter)
        .from_reader(line.as_bytes());
    let record = reader.records().next().and_then(Result::ok);
    record.map(|r| r.iter().map(|c| c.trim().to_owned()).collect()).unwrap_or_default()
}

fn is_blank(cells: &[String]) -> bool {
    cells.iter().all(String::is_empty)
}

/// Whether a line's first cell is a number. A decimal comma may stand in it.
fn begins_with_number(line: &str) -> bool {
    let line = line.trim_start();
    let cell = match line.strip_prefix('"') {
        Some(quoted) => quoted.split('"').next().unwrap_or(""),
        None => line.split([';', '\t']).next().and_then(|c| c.split(',').next()).unwrap_or(""),
    };
    let cell = cell.trim();
    cell.contains(|c: char| c.is_ascii_digit()) && number(cell, ',').is_some()
}

/// Whether most of a line's cells are numbers.
fn mostly_numbers(line: &str) -> bool {
    let cells = cells(line, delimiter(line));
    let filled: Vec<&String> = cells.iter().filter(|c| !c.is_empty()).collect();
    let numbers = filled.iter().filter(|c| number(c, ',').is_some()).count();
    filled.len() > 1 && 2 * numbers > filled.len()
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
        assert_eq!(table(b"words\n", &["Time"], 1).err().expect("none").code, "no_table");
        let many = "words and words\n".repeat(MOST_LINES + 2);
        assert_eq!(table(many.as_bytes(), &["Time"], 1).err().expect("none").code, "no_table");
        assert_eq!(table(b"a, b\nc, d\n", &[], 0).err().expect("prose").code, "no_table");
        // a first column of words
        let text = b"mode,v,w\non,1,2\noff,2,3\n";
        assert_eq!(table(text, &[], 0).expect("a table").names, ["mode", "v", "w"]);
        // cut before the first number
        let cut = table(b"Time,v\ns,m/s\n", &["Time"], 1).expect("names at least");
        assert_eq!(cut.names, ["Time", "v"]);
    }
}
