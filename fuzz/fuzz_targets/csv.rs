#![no_main]
//! Logs in comma-separated text of any dialect.

mod log;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| log::read(bytes, ".csv"));
