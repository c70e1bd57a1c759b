#![no_main]
//! Logs in MCAP. Seeds are in fixtures/formats.

mod log;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| log::read(bytes, ".mcap"));
