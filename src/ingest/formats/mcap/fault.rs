//! What is wrong with a message of an MCAP log.

use crate::contract::sentence_error::sentence_error;

sentence_error! {
    /// Error in a message or its definition.
    Fault
}
