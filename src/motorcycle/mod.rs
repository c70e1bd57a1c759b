//! What is known of a motorcycle before its ride: its file, classes and tyre sizes; and the balance of forces on it.

pub(crate) mod balance;
mod bike_file;
pub(crate) mod catalogue;
