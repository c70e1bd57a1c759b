//! Integration tests: one binary, one module per area.

mod batch;
mod cli;
mod fit;
mod report;
