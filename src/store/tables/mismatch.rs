//! What does not fit a table.

use crate::contract::sentence_error::sentence_error;

sentence_error! {
    /// Why rows or columns are not those of a table.
    Mismatch
}
