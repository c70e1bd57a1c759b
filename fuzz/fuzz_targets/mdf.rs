#![no_main]
//! Logs in ASAM MDF, versions 3 and 4. Seeds are in fixtures/formats.

mod log;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| log::read(bytes, ".mf4"));
