//! What is wrong with a TYDEX file.

use crate::contract::sentence_error::sentence_error;

sentence_error! {
    /// What is wrong with a line of a TYDEX file, or with all of it.
    Fault
}
