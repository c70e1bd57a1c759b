#![no_main]
//! MoTeC `.ld` logs.

mod log;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| log::read(bytes, ".ld"));
