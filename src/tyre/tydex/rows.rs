//! Lines of measured values: one point each, in columns of ten characters or with blanks between.

use super::fault::Fault;
use super::line::{columns, number};

/// Width of a value's column.
const WIDTH: usize = 10;
/// Words for a value that was not measured.
const MISSING: [&str; 6] = ["NOTAVAIL", "NAN", "NA", "N/A", "-", "--"];

/// Beyond this a number is no measurement.
const NO_MEASUREMENT: f64 = 1e20;

/// Whether a number is a mark of a missing value: a row of nines (-9999, 99999.0), which benches write where the word
/// does not fit. Positive ones need five: 9999 may be a load in N.
fn is_mark(word: &str) -> bool {
    let negative = word.starts_with('-');
    let (whole, after) = word.split_once(['.', ',']).unwrap_or((word, ""));
    let whole = whole.trim_start_matches(['-', '+']);
    let nines = |part: &str| part.chars().all(|c| c == '9');
    let zeros = |part: &str| part.chars().all(|c| c == '0');
    let least = if negative { 4 } else { 5 };
    whole.len() >= least && nines(whole) && (nines(after) || zeros(after))
}

/// Collects the values of points from lines.
#[derive(Debug)]
pub(crate) struct Rows {
    channels: usize,
    /// Whether a point takes several lines; not known before the first.
    wrapped: Option<bool>,
    /// Values of a point that goes on on the next line.
    begun: Vec<Option<f64>>,
    /// Line in which it began, from 1.
    began: usize,
}

impl Rows {
    /// Of so many channels.
    pub(crate) fn new(channels: usize) -> Self {
        Rows { channels, wrapped: None, begun: Vec::new(), began: 0 }
    }

    /// Takes a line (`number` from 1); the values of a point that ends with it.
    ///
    /// # Errors
    /// Too many or too few values, or a word that is none.
    pub(crate) fn line(
        &mut self,
        line: &str,
        at: usize,
    ) -> Result<Option<Vec<Option<f64>>>, Fault> {
        let n = self.channels;
        let words: Vec<&str> = line.split_whitespace().collect();
        if self.wrapped != Some(true) {
            if words.len() == n {
                self.wrapped = Some(false);
                return values(&words).map(Some);
            }
            // blank columns are values that were not measured; long numbers touch one another
            let length = line.trim_end().chars().count();
            if length > WIDTH * (n - 1) && length <= WIDTH * n {
                let cells: Vec<String> =
                    (0..n).map(|i| columns(line, i * WIDTH, (i + 1) * WIDTH)).collect();
                let cells: Vec<&str> = cells.iter().map(String::as_str).collect();
                if let Ok(row) = values(&cells) {
                    self.wrapped = Some(false);
                    return Ok(Some(row));
                }
            }
            if self.wrapped == Some(false) || words.len() > n {
                return Err(Fault::from(format!(
                    "{} values, but the file has {n} channels; each line needs a value or NOTAVAIL for every channel",
                    words.len()
                )));
            }
            self.wrapped = Some(true);
        }
        if self.begun.is_empty() {
            self.began = at;
        }
        self.begun.extend(values(&words)?);
        if self.begun.len() > n {
            let found = self.begun.len();
            return Err(Fault::from(format!(
                "{found} values from line {} on, but the file has {n} channels; is a value missing above?",
                self.began
            )));
        }
        if self.begun.len() < n {
            return Ok(None);
        }
        Ok(Some(std::mem::take(&mut self.begun)))
    }

    /// Ends the section.
    ///
    /// # Errors
    /// The last point is not whole.
    pub(crate) fn end(self) -> Result<(), Fault> {
        if self.begun.is_empty() {
            return Ok(());
        }
        Err(Fault::from(format!(
            "the point that begins in line {} has {} of {} values; is the file cut off?",
            self.began,
            self.begun.len(),
            self.channels
        )))
    }
}

fn values(words: &[&str]) -> Result<Vec<Option<f64>>, Fault> {
    words.iter().map(|word| value(word)).collect()
}

fn value(word: &str) -> Result<Option<f64>, Fault> {
    let is_missing =
        MISSING.contains(&word.to_ascii_uppercase().as_str()) || word.chars().all(|c| c == '*');
    if is_missing || is_mark(word) {
        return Ok(None); // also of a blank column
    }
    number(word).map(|x| (x.abs() < NO_MEASUREMENT).then_some(x)).ok_or_else(|| {
        Fault::from(format!(
            "`{word}` is not a number; write NOTAVAIL for a value that was not measured"
        ))
    })
}
