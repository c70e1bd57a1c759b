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
mod offroad;
mod offroad_reference;
mod recordings;
mod recovery;
mod report;
mod riding;
mod script;
mod segment;
mod suspicions;
