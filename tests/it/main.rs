//! Integration tests: one binary.

mod fit;
mod segment;
