//! Integration tests: one binary.

mod fit;
mod recovery;
