//! How a delimited text is laid out: what is between cells, how decimals are written, which cells a line has.

use std::io::{self, BufRead, Read};

use ::csv::{Reader, ReaderBuilder};

use crate::ingest::clock::stamps::text::seconds;
use crate::ingest::maps::units;

/// Possible delimiters, the likeliest first. Blanks (`b' '`) are taken where there is none of these.
const DELIMITERS: [u8; 4] = [b'\t', b';', b'|', b','];

/// Delimiter of the cells: what both the names and a row of numbers have most of.
pub(super) fn delimiter(names: &str, row: &str) -> u8 {
    let (above, below) = (counts(names), counts(row));
    let both = |i: usize| above[i].min(below[i]);
    let most = (0..4).max_by_key(|i| (both(*i), 4 - i)).filter(|i| both(*i) > 0);
    if let Some(place) = most {
        return DELIMITERS[place];
    }
    if by_blanks(row) && names.split_whitespace().count() > 1 {
        return b' ';
    }
    let most = (0..4).max_by_key(|i| (above[*i], 4 - i)).filter(|i| above[*i] > 0);
    most.map_or(b',', |place| DELIMITERS[place])
}

/// How often each delimiter stands outside of quotes.
fn counts(line: &str) -> [usize; 4] {
    let (mut quoted, mut counts) = (false, [0; 4]);
    for b in line.bytes() {
        match DELIMITERS.iter().position(|d| *d == b) {
            _ if b == b'"' => quoted = !quoted,
            Some(place) if !quoted => counts[place] += 1,
            _ => {}
        }
    }
    counts
}

/// Whether blanks separate numbers.
fn by_blanks(row: &str) -> bool {
    let cells = row.split_whitespace();
    let numbers = cells.clone().filter(|c| is_number(c)).count();
    let count = cells.count();
    count > 1 && 2 * numbers > count
}

/// The number that a text is, if it is one.
pub(super) fn number(text: &str, decimal: char) -> Option<f64> {
    if decimal == ',' && text.contains(',') {
        text.replace(',', ".").parse().ok()
    } else {
        text.parse().ok()
    }
}

/// A number whose digits stand in groups of three: `1'000`, `1.792.835.985,5`. A single dot is none between groups.
pub(super) fn grouped(text: &str, decimal: char) -> Option<f64> {
    const BETWEEN: [char; 6] = ['\'', '\u{2019}', '\u{a0}', '\u{202f}', '\u{2009}', ' '];
    let text = text.trim();
    // a sign that stands more than once is no decimal sign
    let (whole, part) = match text.matches(decimal).count() {
        1 => text.rsplit_once(decimal).unwrap_or((text, "")),
        _ => (text, ""),
    };
    let (whole, part) = match part.bytes().all(|b| b.is_ascii_digit()) {
        true => (whole, part),
        false => (text, ""),
    };
    let digits = whole.trim_start_matches(['-', '+']);
    let between = digits.chars().find(|c| !c.is_ascii_digit())?;
    let groups: Vec<&str> = digits.split(between).collect();
    let three = |g: &&str| g.len() == 3 && g.bytes().all(|b| b.is_ascii_digit());
    let first = groups[0].len();
    let sure = BETWEEN.contains(&between) || (between == '.' && groups.len() > 2);
    let fits = (1..=3).contains(&first) && groups[0].bytes().all(|b| b.is_ascii_digit());
    if !sure || !fits || !groups[1..].iter().all(three) {
        return None;
    }
    let plain: String = whole.chars().filter(|c| *c != between).collect();
    format!("{plain}.{}", if part.is_empty() { "0" } else { part }).parse().ok()
}

/// Whether a cell is a number, a stamp, or a number with its unit after it.
pub(super) fn is_number(cell: &str) -> bool {
    let digits = cell.bytes().any(|b| b.is_ascii_digit());
    digits
        && (number(cell, ',').is_some()
            || seconds(cell).is_some()
            || with_unit(cell).is_some()
            || grouped(cell, ',').is_some())
}

/// A number and the unit after it: `50.4 km/h`.
pub(super) fn with_unit(cell: &str) -> Option<(&str, &str)> {
    let cell = cell.trim();
    let end = cell.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | ',' | '+' | '-')))?;
    let (text, unit) = (cell[..end].trim(), cell[end..].trim());
    let known =
        !unit.is_empty() && units::dimension(unit).is_some_and(|d| d != "ratio" || unit == "%");
    (known && number(text, ',').is_some()).then_some((text, unit))
}

/// Whether a row is one of numbers: its first cell is one, or most of them are.
pub(super) fn is_row(line: &str, most: bool) -> bool {
    let line = line.trim_start();
    let cell = match line.strip_prefix('"') {
        Some(quoted) => quoted.split('"').next().unwrap_or(""),
        None => {
            let cell = line.split([';', '\t', '|']).next().unwrap_or("");
            // a comma is a delimiter or a decimal one
            cell.split(',').next().unwrap_or("")
        }
    };
    let cell = cell.trim();
    let digit = cell.contains(|c: char| c.is_ascii_digit());
    if digit && number(cell, ',').is_some() {
        return true;
    }
    most && (mostly_numbers(line) || by_blanks(line))
}

/// Whether most of a line's cells are numbers.
fn mostly_numbers(line: &str) -> bool {
    // not the most frequent one alone: between decimal commas semicolons are fewer
    let there = DELIMITERS.iter().zip(counts(line)).filter(|(_, count)| *count > 0);
    there.into_iter().any(|(delimiter, _)| {
        let cells = cells(line, *delimiter);
        let filled = cells.iter().filter(|c| !c.is_empty());
        let numbers = filled.clone().filter(|c| is_number(c)).count();
        let count = filled.count();
        count > 1 && 2 * numbers > count
    })
}

/// A comma is a decimal one where a cell is a number with it.
pub(super) fn decimal<'a>(rows: impl Iterator<Item = &'a str>, delimiter: u8) -> char {
    let comma = |cell: &String| {
        let text = with_unit(cell).map_or(cell.as_str(), |w| w.0);
        text.contains(',') && number(text, ',').is_some()
    };
    let mut rows = rows.map(|row| cells(row, delimiter));
    if rows.any(|row| row.iter().any(comma)) { ',' } else { '.' }
}

/// Lines that a quoted cell may take, at most.
const QUOTED_LINES: usize = 100;

/// Reads a line, at most `most` bytes of it, with the lines that follow within a quoted cell: their ends become blanks.
/// How many these are.
///
/// # Errors
/// The text cannot be read.
pub(super) fn line(text: &mut impl BufRead, most: u64, line: &mut Vec<u8>) -> io::Result<u64> {
    line.clear();
    text.by_ref().take(most).read_until(b'\n', line)?;
    if !is_open(line) {
        return Ok(0);
    }
    // a quote that never ends is a letter like others
    let ahead = text.fill_buf()?;
    let mut whole = line.clone();
    let mut count = 0;
    for next in ahead.split_inclusive(|b| *b == b'\n').take(QUOTED_LINES) {
        whole.truncate(whole.trim_ascii_end().len());
        whole.push(b' ');
        whole.extend(next);
        count += 1;
        if !is_open(&whole) {
            let used = ahead.split_inclusive(|b| *b == b'\n').take(count).map(<[u8]>::len).sum();
            text.consume(used);
            *line = whole;
            return Ok(count as u64);
        }
    }
    Ok(0)
}

/// Whether a line ends within a quoted cell.
fn is_open(line: &[u8]) -> bool {
    let (mut open, mut begins) = (false, true);
    for &b in line {
        let was_open = open;
        match b {
            b'"' if open => open = false,
            // also the second one of two within a cell
            b'"' if begins => open = true,
            _ => {}
        }
        begins = !open && (DELIMITERS.contains(&b) || was_open);
    }
    open
}

/// A line's cells, without quotes and blanks around them.
pub(super) fn cells(line: &str, delimiter: u8) -> Vec<String> {
    let mut reader = reader(delimiter, line.as_bytes());
    let record = reader.records().next().and_then(Result::ok);
    record.map(|r| r.iter().map(|c| c.trim().to_owned()).collect()).unwrap_or_default()
}

/// The names in a line, as many as `row` has cells if that can be: names between blanks may hold single ones.
pub(super) fn names(line: &str, delimiter: u8, row: &str) -> Vec<String> {
    let mut names = cells(line, delimiter);
    let wanted = cells(row, delimiter).len();
    if delimiter == b' ' && names.len() != wanted {
        let wide = line.replace('\t', "  ");
        let apart: Vec<String> =
            wide.split("  ").map(str::trim).filter(|n| !n.is_empty()).map(str::to_owned).collect();
        if apart.len() == wanted {
            names = apart;
        }
    }
    // a delimiter at the end of the names only
    while names.len() > wanted.max(1) && names.last().is_some_and(String::is_empty) {
        names.pop();
    }
    names
}

/// A reader of rows.
pub(super) fn reader<R: Read>(delimiter: u8, from: R) -> Reader<Squeezed<R>> {
    let mut builder = ReaderBuilder::new();
    builder.has_headers(false).flexible(true).delimiter(delimiter);
    builder.from_reader(Squeezed::new(from, delimiter == b' '))
}

/// A text in which any number of blanks is one, and none begins or ends a line; if that is wanted.
pub(crate) struct Squeezed<R> {
    text: R,
    wanted: bool,
    ready: Vec<u8>,
    given: usize,
    /// A blank that waits for what is after it.
    waiting: bool,
    begins: bool,
}

impl<R: Read> Squeezed<R> {
    fn new(text: R, wanted: bool) -> Self {
        Squeezed { text, wanted, ready: Vec::new(), given: 0, waiting: false, begins: true }
    }

    fn fill(&mut self) -> io::Result<()> {
        let mut block = vec![0; 1 << 14];
        self.ready.clear();
        self.given = 0;
        while self.ready.is_empty() {
            let n = self.text.read(&mut block)?;
            if n == 0 {
                break;
            }
            for &b in &block[..n] {
                match b {
                    b' ' | b'\t' => self.waiting = !self.begins,
                    b'\n' | b'\r' => {
                        (self.waiting, self.begins) = (false, true);
                        self.ready.push(b);
                    }
                    _ => {
                        if self.waiting {
                            self.ready.push(b' ');
                        }
                        (self.waiting, self.begins) = (false, false);
                        self.ready.push(b);
                    }
                }
            }
        }
        Ok(())
    }
}

impl<R: Read> Read for Squeezed<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if !self.wanted {
            return self.text.read(out);
        }
        if self.given == self.ready.len() {
            self.fill()?;
        }
        let n = out.len().min(self.ready.len() - self.given);
        out[..n].copy_from_slice(&self.ready[self.given..self.given + n]);
        self.given += n;
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_between_cells() {
        for (names, row, wanted) in [
            ("a,b,c", "1,2,3", b','),
            ("a;b;c", "0,5;1,5;2,5", b';'),
            ("a (x;y),b,c", "1,2,3", b','),
            ("a\tb", "1\t2", b'\t'),
            ("a|b|c", "1|2|3", b'|'),
            ("a b  c", "1.0  2.0   3.0", b' '),
            ("Time (s)  GPS Speed", "0,5  1,5", b' '),
            ("a,b,c,d", "1;2,3,4", b','),
            ("Time", "1", b','),
        ] {
            assert_eq!(delimiter(names, row), wanted, "{names}");
        }
    }

    #[test]
    fn names_between_blanks_may_hold_single_ones() {
        let of = |line: &str, row: &str| names(line, b' ', row);
        assert_eq!(
            of("Time (s)   GPS Speed   Lean", " 0.0 1.0  2.0"),
            ["Time (s)", "GPS Speed", "Lean"]
        );
        assert_eq!(of("t  v w", "0.0 1.0  2.0"), ["t", "v", "w"]);
        assert_eq!(names("a,b,", b',', "1,2"), ["a", "b"]);
        assert_eq!(names("a,b,", b',', "1,2,"), ["a", "b", ""]);
    }

    #[test]
    fn units_behind_numbers() {
        assert_eq!(with_unit("50.4 km/h"), Some(("50.4", "km/h")));
        assert_eq!(with_unit("-0,5m/s2"), Some(("-0,5", "m/s2")));
        assert_eq!(with_unit("12°"), Some(("12", "°")));
        for none in ["50.4", "x", "3 laps", "km/h", "1e5", "12:00"] {
            assert_eq!(with_unit(none), None, "{none}");
        }
    }

    #[test]
    fn a_quoted_cell_may_take_several_lines() {
        let read = |text: &str| {
            let mut of = Vec::new();
            let count = line(&mut text.as_bytes(), 1000, &mut of).expect("in memory");
            (String::from_utf8(of).expect("text"), count)
        };
        let (names, count) = read("\"Time\r\n(s)\",\"a \"\"b\"\"\nc\"\r\n0,1\r\n");
        assert_eq!((names.as_str(), count), ("\"Time (s)\",\"a \"\"b\"\" c\"\r\n", 2));
        for alone in ["17\" wheel,x\n0,1\n", "\"never closed,x\n0,1\n2,3\n", "47°00'00\"N,1\n2,3\n"]
        {
            assert_eq!(
                read(alone),
                (alone.split_inclusive('\n').next().expect("a line").into(), 0)
            );
        }
    }

    #[test]
    fn digits_in_groups() {
        for (text, decimal, wanted) in [
            ("1'000", '.', 1000.0),
            ("1\u{202f}000,5", ',', 1000.5),
            ("-12\u{a0}345", ',', -12_345.0),
            ("1.792.835.985.000", ',', 1_792_835_985_000.0),
            ("1.792.835.985,5", ',', 1_792_835_985.5),
            ("1.792.835.985.000", '.', 1_792_835_985_000.0),
        ] {
            assert_eq!(grouped(text, decimal), Some(wanted), "{text}");
        }
        for none in ["1'00", "24.10.2026", "1.2.3", "192.168.1.1", "", "'", "1234'567", "a'000"] {
            assert_eq!(grouped(none, '.'), None, "{none}");
        }
    }

    #[test]
    fn blanks_are_squeezed() {
        for text in [" 1   2 \t 3  \n  4 5 6\n", "1 2 3\r\n4 5 6"] {
            let rows: Vec<Vec<String>> = reader(b' ', text.as_bytes())
                .records()
                .map(|r| r.expect("text").iter().map(str::to_owned).collect())
                .collect();
            assert_eq!(rows, [["1", "2", "3"], ["4", "5", "6"]]);
        }
    }

    #[test]
    fn decimals_may_be_in_quotes() {
        assert_eq!(decimal(["\"0,50\",\"1,5\""].into_iter(), b','), ',');
        assert_eq!(decimal(["0;1", "0,5;1"].into_iter(), b';'), ',');
        assert_eq!(decimal(["0,5,1"].into_iter(), b','), '.');
    }
}
