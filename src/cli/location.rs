//! Paths and object store addresses as arguments.

use clap::builder::{OsStringValueParser, TypedValueParser};

use crate::objects::Location;

/// A path, or a URL of an object store; the message of one that cannot be used says why.
pub fn location() -> impl TypedValueParser<Value = Location> {
    OsStringValueParser::new().try_map(Location::parse)
}
