//! What is wrong with a key of a file, or with a name in it.

/// Error in a key of a file, or in a name in it: a sentence with the key or name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum KeyError {
    /// No key has this path.
    #[error("unknown key `{path}`; {remedy}")]
    Unknown {
        /// Dotted path.
        path: String,
        /// The nearest key, or where all are listed.
        remedy: String,
    },
    /// No channel has this name.
    #[error("unknown channel `{name}`{hint}")]
    UnknownChannel {
        /// Name as it stands in the file.
        name: String,
        /// The nearest name, where one is near.
        hint: String,
    },
    /// The value is of another type.
    #[error("`{path}` must be {wanted}")]
    Type {
        /// Dotted path.
        path: String,
        /// The type, and what was found.
        wanted: String,
    },
    /// The number is not finite.
    #[error("`{path}` = {value}: it must be a finite number")]
    Infinite {
        /// Dotted path.
        path: String,
        /// Value in the file.
        value: f64,
    },
    /// The number is beyond what is possible.
    #[error("`{path}` = {value} {unit} is {out_of}")]
    Range {
        /// Dotted path.
        path: String,
        /// As given, in `unit`.
        value: f64,
        /// Unit of the key.
        unit: String,
        /// The range and its unit, in words.
        out_of: String,
    },
    /// Values contradict one another.
    #[error("{0}")]
    Values(String),
    /// The standard uncertainty of a key is wrong.
    #[error("[uncertainty]: {0}")]
    Uncertainty(Box<KeyError>),
    /// The standard uncertainty of a key is negative.
    #[error("`{path}` = {value} must not be negative")]
    Negative {
        /// Dotted path.
        path: String,
        /// Value in the file.
        value: f64,
    },
    /// Only numbers have an uncertainty.
    #[error("`{path}` is not a number")]
    NoNumber {
        /// Dotted path.
        path: String,
    },
    /// Keys that must be there are not.
    #[error("missing {keys}{hint}")]
    Missing {
        /// All of them, with their meaning.
        keys: String,
        /// Advice, or empty.
        hint: String,
    },
    /// The file is one of another kind.
    #[error("this is {found}, and {wanted} is wanted; {places}")]
    WrongFile {
        /// Kind of the file, with its article.
        found: &'static str,
        /// Kind of the expected file, with its article.
        wanted: &'static str,
        /// Where files of either kind go.
        places: String,
    },
}

impl From<KeyError> for String {
    fn from(e: KeyError) -> Self {
        e.to_string()
    }
}

impl From<String> for KeyError {
    fn from(sentence: String) -> Self {
        KeyError::Values(sentence)
    }
}

impl From<&str> for KeyError {
    fn from(sentence: &str) -> Self {
        KeyError::Values(sentence.to_owned())
    }
}
