//! A cell of a position in a delimited text: its numbers, its letter, and the degrees that they are.

use ::csv::ByteRecord;

use super::layout::number;
use super::text::decoded;

/// The coordinate that a column holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Axis {
    North,
    East,
}

/// Kind of the numbers of a column, where a cell is one number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Form {
    /// Its own unit, degrees as a rule.
    Plain,
    /// Degrees by this factor.
    Scaled(f64),
    /// Degrees and minutes in one number, `dddmm.mmmm`.
    Minutes,
    /// Degrees, minutes and seconds in one number, `dddmmss.ss`.
    Seconds,
}

/// Which half a letter `O` means: east in German, west in the Romance languages.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum O {
    East,
    West,
    Unknown,
}

/// How the cells of a coordinate are read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coordinate {
    /// Place of the cell in a row.
    pub cell: usize,
    /// Which of the two.
    pub(super) axis: Axis,
    /// Kind of a number.
    pub(super) form: Form,
    /// Place of the cell with the hemisphere's letter.
    pub(super) letters: Option<usize>,
    /// Meaning of the letter `O` there.
    pub(super) o: O,
    /// Whether the column's name says that positive is south or west.
    pub(super) turned: bool,
    /// Which of two numbers in the cell it is.
    pub(super) part: Option<usize>,
    /// Whether anything says that it is in degrees once it is read.
    pub(super) degrees: bool,
}

/// The letter of a hemisphere that a text is.
pub(super) fn letter(text: &str) -> Option<char> {
    let text = text.trim().trim_end_matches('.').to_uppercase();
    Some(match text.as_str() {
        "N" | "NORTH" | "NORD" => 'N',
        "S" | "SOUTH" | "SUD" | "SÜD" => 'S',
        "E" | "EAST" => 'E',
        "W" | "WEST" => 'W',
        "O" => 'O',
        _ => return None,
    })
}

/// 1 for north and east, -1 for south and west; `None` of a letter that is none of the axis.
pub(super) fn half(letter: char, axis: Axis, o: O) -> Option<f64> {
    match (axis, letter, o) {
        (Axis::North, 'N', _) | (Axis::East, 'E', _) | (Axis::East, 'O', O::East) => Some(1.0),
        (Axis::North, 'S', _) | (Axis::East, 'W', _) | (Axis::East, 'O', O::West) => Some(-1.0),
        _ => None,
    }
}

/// The numbers and the letter of a cell.
pub(super) struct CellParts {
    /// One to three, of which only the first may be negative.
    pub numbers: Vec<f64>,
    pub letter: Option<char>,
}

/// Takes a cell apart: `W105.0`, `40.0 N`, `47°00'12.5"N`, `47 00.2`, `-8:30:12`.
pub(super) fn apart(cell: &str, decimal: char) -> Option<CellParts> {
    let mut text = cell.trim();
    let mut found = None;
    if let Some((begin, rest)) = text.split_at_checked(1)
        && let Some(letter) = letter(begin)
    {
        (found, text) = (Some(letter), rest);
    } else if let Some((rest, end)) = text.split_at_checked(text.len().saturating_sub(1))
        && let Some(letter) = letter(end)
    {
        (found, text) = (Some(letter), rest);
    }
    let between = |c: char| c.is_whitespace() || "°º˚'’′\"”″:*".contains(c);
    let parts = text.split(between).filter(|p| !p.is_empty());
    let numbers: Vec<f64> = parts.map(|p| number(p, decimal)).collect::<Option<_>>()?;
    let rest_fits = numbers.iter().skip(1).all(|x| (0.0..=60.0).contains(x));
    let fits = (1..=3).contains(&numbers.len()) && rest_fits && numbers[0].is_finite();
    fits.then_some(CellParts { numbers, letter: found })
}

/// The text in the brackets of `POINT(8.0 47.0)`.
pub(super) fn well_known(cell: &str) -> Option<&str> {
    let text = cell.trim().rsplit(';').next()?.trim();
    let (word, rest) = text.split_once('(')?;
    let point = word.trim().to_uppercase();
    (point.split_whitespace().next() == Some("POINT")).then(|| rest.trim_end().strip_suffix(')'))?
}

/// Latitude and longitude of a cell that holds both.
pub(super) fn pair(cell: &str, decimal: char) -> Option<[f64; 2]> {
    if let Some(inside) = well_known(cell) {
        let mut numbers = inside.split_whitespace().map(|p| p.parse::<f64>().ok());
        let [east, north] = [numbers.next()??, numbers.next()??];
        return Some([north, east]);
    }
    let text = cell.trim().trim_matches(|c| "()[]{}".contains(c));
    let separators: &[char] = if decimal == ',' { &[';'] } else { &[',', ';'] };
    let (first, second) = text
        .split_once(separators)
        .or_else(|| text.split_once(char::is_whitespace).filter(|_| !text.contains(['°', '\''])))?;
    let one = |part: &str, axis: Axis| {
        let read = apart(part, if decimal == ',' { ',' } else { '.' })?;
        degrees(&read.numbers, read.letter, axis, Form::Plain, O::Unknown)
    };
    Some([one(first, Axis::North)?, one(second, Axis::East)?])
}

/// Angle of numbers and letter.
fn degrees(numbers: &[f64], letter: Option<char>, axis: Axis, form: Form, o: O) -> Option<f64> {
    let (&first, rest) = numbers.split_first()?;
    let size = first.abs();
    let size = match (rest, form) {
        ([], Form::Plain) => size,
        ([], Form::Scaled(factor)) => size * factor,
        ([], Form::Minutes) => (size / 100.0).floor() + (size % 100.0) / 60.0,
        ([], Form::Seconds) => {
            let minutes = (size % 10_000.0 / 100.0).floor();
            (size / 10_000.0).floor() + minutes / 60.0 + (size % 100.0) / 3600.0
        }
        _ => size + rest.iter().zip([60.0, 3600.0]).map(|(x, part)| x / part).sum::<f64>(),
    };
    match letter {
        None => Some(if first.is_sign_negative() { -size } else { size }),
        // a minus beside `S` or `W` says the same again
        Some(letter) => match half(letter, axis, o)? {
            half if half < 0.0 => Some(-size),
            _ => Some(if first.is_sign_negative() { -size } else { size }),
        },
    }
}

impl Coordinate {
    pub(super) fn of_name(name: &str, cell: usize, axis: Axis) -> Self {
        let halves = match axis {
            Axis::North => [["n", "north", "nord"], ["S", "south", "sud"]],
            Axis::East => [["e", "east", "est"], ["w", "west", "ouest"]],
        };
        let words: Vec<&str> =
            name.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).skip(1).collect();
        // a small `s` may be seconds
        let is =
            |word: &str, half: &str| word == half || (half != "S" && word.to_lowercase() == half);
        let has = |of: [&str; 3]| words.iter().any(|w| of.iter().any(|half| is(w, half)));
        let [positive, negative] = halves.map(has);
        Coordinate {
            cell,
            axis,
            form: Form::Plain,
            letters: None,
            o: O::Unknown,
            // `(W-)` and `(E+, W-)` say that negative is west
            turned: negative && !positive && !name.contains('-'),
            part: None,
            degrees: positive || negative,
        }
    }

    /// Whether it is one of two in its cell.
    pub(super) fn is_part(&self) -> bool {
        self.part.is_some()
    }

    /// The number of a row; `None` where there is none, an error where the cell cannot be read.
    pub(crate) fn read(&self, record: &ByteRecord, decimal: char) -> Result<Option<f64>, ()> {
        let text = decoded(record.get(self.cell).unwrap_or_default());
        let text = text.trim();
        let infinite = number(text, decimal).is_some_and(|x| !x.is_finite());
        if text.is_empty() || infinite {
            return Ok(None);
        }
        if let Some(part) = self.part {
            return pair(text, decimal).map(|p| Some(p[part])).ok_or(());
        }
        let read = apart(text, decimal).ok_or(())?;
        let beside = match self.letters {
            Some(place) => match decoded(record.get(place).unwrap_or_default()).trim() {
                "" => return Ok(None), // no half, no position
                text => Some(letter(text).ok_or(())?),
            },
            None => None,
        };
        let x = degrees(&read.numbers, read.letter.or(beside), self.axis, self.form, self.o);
        let x = x.ok_or(())?;
        let turned = self.turned && read.letter.is_none();
        Ok(Some(if turned { -x } else { x }))
    }
}
