//! One line of a channel or a constant: fixed columns, and what vendors make of them.

use super::channel::Meaning;
use super::fault::Fault;

/// First columns of the fields, from 0.
const DESCRIPTION: usize = 10;
const UNIT: usize = 40;
const NUMBERS: [usize; 4] = [50, 60, 70, 80];

/// A channel or a constant.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    /// In the format's name, or the vendor's.
    pub name: String,
    /// Meaning, if it is read.
    pub meaning: Option<Meaning>,
    /// As it is written.
    pub unit: String,
    /// Numbers after the unit: `a, b, c` of a channel, the value of a constant.
    pub numbers: Vec<f64>,
}

/// A number as vendors write it: a comma for the point, a `D` for the exponent.
pub(crate) fn number(word: &str) -> Option<f64> {
    let plain = match (word.matches(',').count(), word.contains('.')) {
        (1, false) => word.replace(',', "."),
        _ => word.to_owned(),
    };
    plain.replace(['D', 'd'], "E").parse::<f64>().ok().filter(|x| x.is_finite())
}

/// Characters `from..to` of a line, trimmed.
pub(crate) fn columns(line: &str, from: usize, to: usize) -> String {
    let part: String = line.chars().skip(from).take(to - from).collect();
    part.trim().to_owned()
}

impl Entry {
    /// Of a line. Where the fields do not stand in their columns, the last words are the numbers and the word before
    /// them is the unit.
    ///
    /// # Errors
    /// A channel that is needed has a unit that is not known, or numbers that are none.
    pub(crate) fn parse(line: &str) -> Result<Self, Fault> {
        let name = columns(line, 0, DESCRIPTION);
        let name = name.split_whitespace().next().unwrap_or_default().to_owned();
        let meaning = Meaning::of(&name);
        let by_columns = Self::in_columns(line);
        let known = |unit: &str| meaning.is_none_or(|m| m.quantity().factor(unit).is_some());
        if let Some((unit, numbers)) = by_columns.as_ref().filter(|(unit, _)| known(unit)) {
            return Ok(Entry { name, meaning, unit: unit.clone(), numbers: numbers.clone() });
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        let is_number = |word: &&&str| number(word).is_some();
        let n = words.iter().skip(1).rev().take(3).take_while(is_number).count();
        let (before, last) = words.split_at(words.len() - n);
        let numbers: Vec<f64> = last.iter().filter_map(|word| number(word)).collect();
        // `1` is a unit, too: a number too many may be it
        let unit = before.last().filter(|_| before.len() > 1).map_or("", |unit| unit);
        let Some(meaning) = meaning else {
            let unit = unit.to_owned();
            return Ok(Entry { name, meaning: None, unit, numbers });
        };
        if !known(unit) {
            let found = by_columns.map_or(unit.to_owned(), |(unit, _)| unit);
            return Err(Fault::from(format!(
                "unit `{found}` of `{name}` (columns 41 to 50) is not known; write one of {}",
                meaning.quantity().known()
            )));
        }
        Ok(Entry { name, meaning: Some(meaning), unit: unit.to_owned(), numbers })
    }

    /// Unit and numbers, if they stand in their columns.
    fn in_columns(line: &str) -> Option<(String, Vec<f64>)> {
        let unit = columns(line, UNIT, NUMBERS[0]);
        let mut numbers = Vec::new();
        for ends in NUMBERS.windows(2) {
            let field = columns(line, ends[0], ends[1]);
            if field.is_empty() {
                break;
            }
            numbers.push(number(&field)?);
        }
        Some((unit, numbers))
    }

    /// SI units in one of this; 1 of what is not read.
    pub(crate) fn factor(&self) -> f64 {
        self.meaning.and_then(|m| m.quantity().factor(&self.unit)).unwrap_or(1.0)
    }

    /// A measured value in SI units: `a (value + b) + c`, then the unit.
    pub(crate) fn physical(&self, value: f64) -> f64 {
        let at = |i: usize, else_: f64| self.numbers.get(i).copied().unwrap_or(else_);
        (at(0, 1.0) * (value + at(1, 0.0)) + at(2, 0.0)) * self.factor()
    }

    /// A constant in SI units.
    pub(crate) fn constant(&self) -> Option<f64> {
        self.numbers.first().map(|x| x * self.factor())
    }
}
