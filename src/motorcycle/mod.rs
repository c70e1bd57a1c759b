//! What is known of a motorcycle before its ride: its file, classes and tyre sizes; its numbers, the balance of forces on
//! it, and the rigid bodies of an off-road one.

pub(crate) mod balance;
mod bike_file;
pub(crate) mod catalogue;
pub(crate) mod offroad;
pub(crate) mod vehicle;
