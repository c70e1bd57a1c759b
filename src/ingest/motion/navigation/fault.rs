//! Why a log cannot be navigated.

use crate::contract::sentence_error::sentence_error;

sentence_error! {
    /// Why a log cannot be navigated.
    Fault
}
