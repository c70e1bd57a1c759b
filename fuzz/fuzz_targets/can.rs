#![no_main]
//! CAN logs: BLF, ASC, candump, PEAK traces. Seeds are in fixtures/formats.

mod log;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| log::read(bytes, ".blf"));
