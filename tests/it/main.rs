//! The tests that use roadbench from the outside, in one binary.

mod advice;
mod batch;
mod cli;
mod cluster;
mod damage;
mod diagnose;
mod diagnose_offroad;
mod diagnose_report;
mod dirt;
mod disk;
mod fit;
mod fleet;
mod ingest;
mod kill;
mod motorcycle;
#[cfg(feature = "cloud")]
mod objects;
mod offroad;
mod offroad_reference;
mod recordings;
mod recovery;
mod report;
mod report_fleet;
mod riding;
#[cfg(feature = "cloud")]
mod s3_server;
mod script;
mod segment;
mod suspicions;
