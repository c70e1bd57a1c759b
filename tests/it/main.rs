//! Integration tests: one binary.

mod fit;
mod report;
