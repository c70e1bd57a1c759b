//! The tests that use roadbench from the outside, in one binary.

mod fit;
mod ingest;
mod recovery;
mod report;
