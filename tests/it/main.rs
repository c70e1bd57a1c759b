//! The tests that use roadbench from the outside, in one binary.

mod advice;
mod batch;
mod book;
mod cli;
mod cluster;
mod coefficients;
mod commands;
mod damage;
mod diagnose;
mod diagnose_batch;
mod diagnose_offroad;
mod diagnose_report;
mod dirt;
mod disk;
mod effects;
mod export;
mod fit;
mod fleet;
mod formats;
mod in_gear;
mod ingest;
mod kill;
mod levels;
mod motorcycle;
#[cfg(feature = "cloud")]
mod objects;
mod offroad;
mod offroad_reference;
mod page;
mod polish;
mod racing;
mod racing_files;
mod recordings;
mod recovery;
mod replayed;
mod report;
mod report_fleet;
mod report_pages;
mod riding;
mod rooms;
#[cfg(feature = "cloud")]
mod s3_server;
mod script;
mod segment;
mod superbike;
mod suspicions;
