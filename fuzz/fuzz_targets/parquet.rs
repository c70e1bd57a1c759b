#![no_main]
//! Logs in Parquet.

mod log;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| log::read(bytes, ".parquet"));
