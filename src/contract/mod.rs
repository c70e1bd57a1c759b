//! TODO room

pub mod bike;
pub mod channel;
pub mod schema;
pub mod session;
pub mod warning;
