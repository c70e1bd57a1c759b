#![no_main]
//! GPX tracks; the element that one is known by stands in front.

mod log;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    log::read(&[b"<gpx >", bytes].concat(), ".gpx");
});
