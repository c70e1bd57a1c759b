//! Integration tests: one binary.

mod fit;
