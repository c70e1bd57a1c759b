//! TODO room

pub mod chain;
pub mod equations;
pub mod machine;
