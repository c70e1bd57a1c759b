//! A number of a bike file, how well it is known and where from.

/// A number and its standard deviation, both in the unit of its key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValueWithSd {
    pub value: f64,
    /// Standard deviation; zero is exact.
    pub sd: f64,
}

/// Where a number is from, from the best to the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Origin {
    /// The owner measured it.
    Measured,
    /// The owner said it.
    Said,
    /// The model's data sheet.
    DataSheet,
    /// It follows from the tyre's size.
    TyreSize,
    /// A guess: usual of the class.
    Class,
}

impl Origin {
    pub fn name(self) -> &'static str {
        match self {
            Origin::Measured => "measured by you",
            Origin::Said => "given by the user",
            Origin::DataSheet => "data sheet",
            Origin::TyreSize => "from the tyre size",
            Origin::Class => "guess from the class",
        }
    }

    /// Whether it is of a data sheet or of the tyre's size: not measured, and no guess of the class either.
    pub fn is_printed(self) -> bool {
        matches!(self, Origin::DataSheet | Origin::TyreSize)
    }

    /// Whether nobody measured it on this motorcycle.
    pub fn is_guess(self) -> bool {
        !matches!(self, Origin::Measured | Origin::Said)
    }
}

/// A number of a bike file.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// Its key, dotted.
    pub key: String,
    /// Value and standard deviation.
    pub known: ValueWithSd,
    /// Where it is from.
    pub origin: Origin,
    /// The same in more words.
    pub source: String,
}

/// Two values of one number that differ by less, relatively, are one that was rounded.
const ROUNDED: f64 = 1e-3;

/// Says that a number has two values, each with where it is from; `None` where they are the same.
pub(crate) fn twice(key: &str, values: [(f64, &str); 2]) -> Option<String> {
    let [(a, of_a), (b, of_b)] = values;
    let differ = (a - b).abs() > ROUNDED * a.abs().max(b.abs());
    let [a, b] = [a, b].map(|x| (1e4 * x).round() / 1e4);
    differ.then(|| format!("`{key}` has two values: {a} ({of_a}) and {b} ({of_b}); leave one out"))
}
