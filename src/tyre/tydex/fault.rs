//! What is wrong with a TYDEX file.

use crate::contract::sentence_error::sentence_error;

sentence_error! {
    /// Error of a line of a TYDEX file, or with all of it.
    Fault
}
