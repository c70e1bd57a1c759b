#![no_main]
//! FIT, NMEA, UBX and archives of sensors: the first byte says which.

mod log;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((first, rest)) = bytes.split_first() else { return };
    let extension = [".fit", ".nmea", ".ubx", ".zip"][usize::from(first % 4)];
    log::read(rest, extension);
});
