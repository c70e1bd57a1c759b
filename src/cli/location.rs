//! Paths and object store addresses as arguments.

use clap::builder::{PathBufValueParser, TypedValueParser};

use crate::objects::Location;

/// A path, or a URL of an object store; the message of one that cannot be used, or is empty, says why.
pub fn location() -> impl TypedValueParser<Value = Location> {
    PathBufValueParser::new().try_map(Location::parse)
}
